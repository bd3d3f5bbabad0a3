// The renderer against closed forms, on snapshots made by hand: no files, no world.
//
// The stage: a room, 4 x 4 x 4 m around the origin, of six one-sided quads that face inwards, grey. Tests add
// a light, an occluder, a camera.
#define _POSIX_C_SOURCE 200809L // setenv, mkdtemp
#include "gpu_test.h"

#include "asset/assets.h"
#include "components/components.h"
#include "components/light_directional.h"
#include "components/light_disk.h"
#include "components/light_mesh.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "components/light_spot.h"
#include "gpu/frame.h"
#include "graph/graph.h"
#include "render/display_kernels.h"
#include "render/renderer.h"
#include "shaders/shared/brdf.h"
#include "shaders/shared/tonemap.h"

#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <sys/stat.h>

#define SIZE   64u
#define QUADS  8
#define LIGHTS 4
#define WALL   0.5f
#define PI     3.14159265358979f

static const float quad_positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const float quad_normals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
static const float quad_tangents[] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
static const float quad_uvs[] = {0, 1, 1, 1, 1, 0, 0, 0};
static const uint32_t quad_indices[] = {0, 1, 2, 0, 2, 3};

struct stage {
    struct ng_gpu *gpu;
    struct ng_renderer *renderer;
    struct ng_snapshot snapshot;
    struct ng_snapshot_mesh mesh;
    struct ng_snapshot_material materials[2];
    struct ng_snapshot_instance instances[QUADS];
    struct ng_snapshot_light lights[LIGHTS];
    struct ng_render_params render;
};

// A quad of half size `half` at `center`, its normal along `normal` (an axis).
static void add_quad(struct stage *s, uint32_t material, const float center[3], const float normal[3],
                     float half)
{
    struct ng_snapshot_instance *i = &s->instances[s->snapshot.instance_count++];
    float up[3] = {0, fabsf(normal[1]) < 0.5f, fabsf(normal[1]) >= 0.5f}, right[3];
    for (int a = 0; a < 3; a++)
        right[a] = up[(a + 1) % 3] * normal[(a + 2) % 3] - up[(a + 2) % 3] * normal[(a + 1) % 3];
    *i = (struct ng_snapshot_instance){.entity = {s->snapshot.instance_count | 1ull << 32},
                                       .material = material,
                                       .light = NG_NONE,
                                       .version = s->snapshot.instance_count};
    for (int a = 0; a < 3; a++) {
        i->matrix[a * 4 + 0] = right[a] * half;
        i->matrix[a * 4 + 1] = up[a] * half;
        i->matrix[a * 4 + 2] = normal[a] * half;
        i->matrix[a * 4 + 3] = center[a];
        i->bounds_min[a] = center[a] - half * (1 - fabsf(normal[a])) - 1e-4f;
        i->bounds_max[a] = center[a] + half * (1 - fabsf(normal[a])) + 1e-4f;
    }
    memcpy(i->previous_matrix, i->matrix, sizeof i->matrix);
}

static void identity(float m[16])
{
    memset(m, 0, 16 * sizeof *m);
    for (int i = 0; i < 4; i++)
        m[i * 5] = 1;
}

static struct ng_snapshot_light *add_light(struct stage *s, ng_component component, const void *params,
                                           size_t size, const float matrix[16])
{
    uint32_t place = s->snapshot.light_count++;
    struct ng_snapshot_light *l = &s->lights[place];
    *l = (struct ng_snapshot_light){.place = place,
                                    .entity = {100 + s->snapshot.light_count},
                                    .name = "lamp",
                                    .image = NG_NONE,
                                    .version = s->snapshot.light_count};
    l->source.type = ng_light_type_of(component);
    memcpy(l->source.params, params, size);
    memcpy(l->source.matrix, matrix, sizeof l->source.matrix);
    l->source.scene_radius = s->snapshot.scene_radius;
    assert_int_equal(ng_light_prepare(&l->source), NG_OK);
    l->power = ng_light_power(&l->source);
    return l;
}

static struct ng_snapshot_light *add_point(struct stage *s, float x, float y, float z, float intensity)
{
    const struct ng_light_point p = {.on = true, .color = {1, 1, 1}, .intensity = intensity};
    float m[16];
    identity(m);
    m[12] = x, m[13] = y, m[14] = z;
    return add_light(s, NG_LIGHT_POINT, &p, sizeof p, m);
}

static const char *const all_layers[] = {"beauty",   "direct",   "unshadowed", "shadow",    "albedo",
                                         "specular", "position", "normal",     "roughness", "motion",
                                         "depth",    "entity",   "display",    "emission"};

static int begin_with(void **state, struct ng_renderer_params params)
{
    struct stage *s = calloc(1, sizeof *s);
    s->gpu = gpu_test_begin();
    params.gpu = s->gpu;
    assert_int_equal(ng_renderer_create(&params, &s->renderer), NG_OK);
    s->mesh = (struct ng_snapshot_mesh){.key = 1,
                                        .revision = 1,
                                        .vertex_count = 4,
                                        .index_count = 6,
                                        .positions = quad_positions,
                                        .normals = quad_normals,
                                        .tangents = quad_tangents,
                                        .uvs = quad_uvs,
                                        .indices = quad_indices};
    for (int i = 0; i < 2; i++)
        s->materials[i] = (struct ng_snapshot_material){.base_color = {WALL, WALL, WALL},
                                                        .roughness = 1,
                                                        .alpha = 1,
                                                        .specular = 1,
                                                        .specular_color = {0.04f, 0.04f, 0.04f},
                                                        .textures = NG_SNAPSHOT_NO_TEXTURES};
    s->snapshot = (struct ng_snapshot){.scene_radius = 4,
                                       .mesh_count = 1,
                                       .material_count = 2,
                                       .meshes = &s->mesh,
                                       .instances = s->instances,
                                       .materials = s->materials,
                                       .lights = s->lights,
                                       .environment = NG_NONE};
    // Looks along -Z from the room's front; 90 degrees, so that a pixel's ray is (x, y, -1).
    s->snapshot.camera = (struct ng_snapshot_camera){
        .position = {0, 0, 1}, .fov_y = PI / 2, .near_plane = 0.01f, .exposure = 1};
    identity(s->snapshot.camera.view);
    s->snapshot.camera.view[14] = -1;
    memcpy(s->snapshot.camera.previous_view, s->snapshot.camera.view, sizeof s->snapshot.camera.view);
    for (int a = 0; a < 3; a++)
        for (int side = -1; side <= 1; side += 2) {
            float center[3] = {0}, normal[3] = {0};
            center[a] = (float)side * 2;
            normal[a] = (float)-side;
            add_quad(s, 0, center, normal, 2);
        }
    s->render = (struct ng_render_params){.snapshot = &s->snapshot,
                                          .width = SIZE,
                                          .height = SIZE,
                                          .layers = all_layers,
                                          .layer_count = NG_COUNT(all_layers)};
    *state = s;
    return 0;
}

static int begin(void **state)
{
    return begin_with(state, (struct ng_renderer_params){0});
}

static int end(void **state)
{
    struct stage *s = *state;
    for (uint32_t i = 0; i < s->snapshot.light_count; i++)
        ng_light_finish(&s->lights[i].source);
    ng_renderer_destroy(&s->renderer);
    gpu_test_end(s->gpu);
    free(s);
    return 0;
}

static void draw(struct stage *s)
{
    struct ng_cmd *cmd;
    s->snapshot.frame++;
    assert_int_equal(ng_frame_begin(s->gpu, &cmd), NG_OK);
    assert_int_equal(ng_renderer_frame(s->renderer, &cmd, &s->render), NG_OK);
    assert_int_equal(ng_frame_end(s->gpu, &cmd), NG_OK);
}

static const float *texel(struct stage *s, const char *name, uint32_t x, uint32_t y)
{
    struct ng_layer l;
    assert_int_equal(ng_renderer_layer(s->renderer, name, &l), NG_OK);
    assert_int_equal(l.width, s->render.width);
    assert_int_equal(l.height, s->render.height);
    return l.pixels + ((size_t)y * l.width + x) * l.channels;
}

static void assert_near(float got, float want, float tolerance)
{
    if (!(fabsf(got - want) <= tolerance))
        fail_msg("got %g, want %g within %g", (double)got, (double)want, (double)tolerance);
}

// The ray of a pixel's centre, unnormalised: (x, y, -1).
static void pixel_ray(uint32_t px, uint32_t py, float *x, float *y)
{
    *x = ((float)px + 0.5f) / SIZE * 2 - 1;
    *y = 1 - ((float)py + 0.5f) / SIZE * 2;
}

static void gbuffer_holds_the_surface_at_the_pixel_centre(void **state)
{
    struct stage *s = *state;
    s->materials[0].metallic = 0.25f;
    s->materials[0].roughness = 0.5f;
    draw(s);
    for (uint32_t py = 1; py < SIZE; py += 9)
        for (uint32_t px = 1; px < SIZE; px += 9) {
            float x, y;
            pixel_ray(px, py, &x, &y);
            if (fabsf(fabsf(x) - fabsf(y)) < 1e-3f)
                continue; // the edge between two walls
            // The nearest wall along the ray: back (z = -2, 3 m away) or a side at +-2.
            float m = fmaxf(fabsf(x), fabsf(y)), t = fminf(3, 2 / m);
            const float *p = texel(s, "position", px, py);
            assert_near(p[0], x * t, 1e-3f);
            assert_near(p[1], y * t, 1e-3f);
            assert_near(p[2], 1 - t, 1e-3f);
            assert_near(texel(s, "depth", px, py)[0], t, 1e-3f);
            const float *n = texel(s, "normal", px, py);
            if (t == 3)
                assert_near(n[2], 1, 1e-3f);
            else
                assert_near(fabsf(x) > fabsf(y) ? n[0] * x : n[1] * y, -m, 2e-3f);
            assert_near(texel(s, "roughness", px, py)[0], 0.5f, 1e-3f);
            assert_near(texel(s, "albedo", px, py)[1], WALL * 0.75f, 1e-3f);
            assert_near(texel(s, "specular", px, py)[1], 0.04f * 0.75f + WALL * 0.25f, 1e-3f);
            assert_near(texel(s, "motion", px, py)[0], 0, 1e-3f);
        }
}

static void picking_names_the_entity(void **state)
{
    struct stage *s = *state;
    ng_entity e;
    draw(s);
    assert_int_equal(ng_renderer_pick(s->renderer, SIZE / 2, SIZE / 2, &e), NG_OK);
    assert_int_equal(e.id, s->instances[4].entity.id); // the back wall: the third axis, negative side
    assert_int_equal(ng_renderer_pick(s->renderer, SIZE - 1, SIZE / 2, &e), NG_OK);
    assert_int_equal(e.id, s->instances[1].entity.id);
    s->snapshot.instance_count = 0;
    draw(s);
    assert_int_equal(ng_renderer_pick(s->renderer, SIZE / 2, SIZE / 2, &e), NG_OK);
    assert_int_equal(e.id, 0);
}

static void motion_is_now_minus_before_in_pixels(void **state)
{
    struct stage *s = *state;
    s->instances[4].previous_matrix[3] = -0.3f; // the back wall was 0.3 m to the left, 3 m away
    s->instances[4].previous_matrix[7] = 0.15f; // and 0.15 m higher
    draw(s);
    const float *m = texel(s, "motion", SIZE / 2, SIZE / 2);
    assert_near(m[0], 0.3f / 3 * SIZE / 2, 1e-3f);
    assert_near(m[1], 0.15f / 3 * SIZE / 2, 1e-3f);
}

static void a_flattened_instance_has_finite_motion(void **state)
{
    struct stage *s = *state;
    float *m = s->instances[4].matrix; // the back wall, its normal's axis scaled to nothing
    m[2] = m[6] = m[10] = 0;
    s->instances[4].previous_matrix[3] = -0.3f;
    draw(s);
    for (uint32_t i = 0; i < SIZE * SIZE; i++)
        assert_true(isfinite(texel(s, "motion", i % SIZE, i / SIZE)[0]));
}

// Diffuse and specular light of a point source at a back-wall pixel, from the shared BRDF.
static float point_radiance(const float light[3], float intensity, float px, float py, float pz,
                            const float eye[3])
{
    float l[3] = {light[0] - px, light[1] - py, light[2] - pz},
          v[3] = {eye[0] - px, eye[1] - py, eye[2] - pz}, h[3];
    float ll = sqrtf(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]),
          lv = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    float hh = 0, vh = 0;
    for (int a = 0; a < 3; a++) {
        l[a] /= ll;
        v[a] /= lv;
        h[a] = l[a] + v[a];
        hh += h[a] * h[a];
    }
    for (int a = 0; a < 3; a++)
        vh += v[a] * h[a] / sqrtf(hh);
    return ng_brdf(l[2], v[2], h[2] / sqrtf(hh), vh, WALL, 0.04f, 1.0f) * l[2] * intensity / (ll * ll);
}

static void a_point_light_obeys_the_inverse_square_and_the_brdf(void **state)
{
    struct stage *s = *state;
    const float at[3] = {0.5f, 0.25f, 0}, eye[3] = {0, 0, 1};
    add_point(s, at[0], at[1], at[2], 7);
    draw(s);
    for (uint32_t py = 20; py < 44; py += 5)
        for (uint32_t px = 20; px < 44; px += 5) {
            float x, y;
            pixel_ray(px, py, &x, &y);
            float want = point_radiance(at, 7, x * 3, y * 3, -2, eye);
            assert_near(texel(s, "unshadowed", px, py)[0], want, want * 2e-3f);
            assert_near(texel(s, "shadow", px, py)[0], 1, 0); // nothing in the way: not one texel of acne
            assert_near(texel(s, "beauty", px, py)[0], want, want * 2e-3f);
        }
    // No acne anywhere in the room, grazing angles and corners included.
    for (uint32_t py = 0; py < SIZE; py++)
        for (uint32_t px = 0; px < SIZE; px++)
            assert_near(texel(s, "shadow", px, py)[0], 1, 0.05f);
}

static void an_occluder_casts_the_shadow_that_geometry_says(void **state)
{
    struct stage *s = *state;
    const float center[3] = {0, 0, -1}, toward_light[3] = {0, 0, 1};
    add_point(s, 0, 0, 0, 7);
    add_quad(s, 1, center, toward_light, 0.25f); // half way: its shadow on the back wall is 1 m wide, +-0.5
    s->snapshot.camera.position[0] = 0;
    draw(s);
    for (uint32_t px = 0; px < SIZE; px++) {
        float x, y;
        pixel_ray(px, SIZE / 2 + 14, &x,
                  &y); // a row below the occluder's own picture, y = -0.45: wall at y = -1.36
        const float *p = texel(s, "position", px, SIZE / 2 + 14);
        if (p[2] > -1.99f)
            continue;
        assert_near(texel(s, "shadow", px, SIZE / 2 + 14)[0], 1, 0);
    }
    // Seen from the side: rows that look past the occluder at its shadow.
    s->snapshot.camera.view[12] = -1.5f; // camera at x = 1.5
    s->snapshot.camera.position[0] = 1.5f;
    memcpy(s->snapshot.camera.previous_view, s->snapshot.camera.view, sizeof s->snapshot.camera.view);
    draw(s);
    int dark = 0, lit = 0;
    for (uint32_t px = 0; px < SIZE; px++) {
        const float *p = texel(s, "position", px, SIZE / 2);
        if (p[2] > -1.99f || fabsf(fabsf(p[0]) - 0.5f) < 0.02f)
            continue; // not the back wall, or within a texel of the edge
        bool in_shadow = fabsf(p[0]) < 0.5f;
        assert_near(texel(s, "shadow", px, SIZE / 2)[0], in_shadow ? 0.0f : 1.0f, 0);
        dark += in_shadow;
        lit += !in_shadow;
    }
    assert_true(dark > 3 && lit > 10);
}

// Of copies in one place the last is seen, and all but that need not be drawn; but where it has no part, as
// the surface of a light has none in that light's shadows, another one has.
static void copies_in_one_place_are_one(void **state)
{
    struct stage *s = *state;
    const float center[3] = {0, 0, -0.5f}, toward[3] = {0, 0, 1};
    const uint32_t shadow_x = 24; // of the light, beside the quad
    ng_entity e;
    s->materials[1].base_color[0] = 0.9f;
    add_quad(s, 0, center, toward, 0.25f);
    add_quad(s, 1, center, toward, 0.25f);
    add_point(s, 0.5f, 0, 0.5f, 5);
    for (int i = 0; i < 4; i++) {
        s->instances[6].light = i == 1 ? 0 : NG_NONE;
        s->instances[7].light = i == 2 ? 0 : NG_NONE;
        s->materials[1].alpha_mode = i == 3 ? NG_ALPHA_MASK : NG_ALPHA_OPAQUE;
        s->materials[1].alpha_cutoff = 0.5f;
        s->instances[6].version += 10; // drawn anew
        draw(s);
        assert_int_equal(ng_renderer_pick(s->renderer, SIZE / 2, SIZE / 2, &e), NG_OK);
        assert_int_equal(e.id, s->instances[7].entity.id);
        assert_near(texel(s, "albedo", SIZE / 2, SIZE / 2)[0], 0.9f, 1e-3f);
        assert_near(texel(s, "shadow", shadow_x, SIZE / 2)[0], 0, 0);
        assert_near(texel(s, "shadow", 4, SIZE / 2)[0], 1, 0);
    }
    s->instances[7].light = s->instances[6].light = 0; // neither
    s->instances[6].version += 10;
    draw(s);
    assert_near(texel(s, "shadow", shadow_x, SIZE / 2)[0], 1, 0);
}

static void what_moves_takes_its_shadow_along(void **state)
{
    struct stage *s = *state;
    const float center[3] = {0, 0, -1}, toward_light[3] = {0, 0, 1};
    add_point(s, 0, 0, 0, 7);
    add_quad(s, 1, center, toward_light, 0.25f);
    s->snapshot.camera.view[12] = -1.5f;
    s->snapshot.camera.position[0] = 1.5f;
    for (int frame = 0; frame < 4; frame++) {
        float at = 0.6f * (float)frame; // its shadow is twice as far
        s->instances[6].matrix[3] = at;
        s->instances[6].bounds_min[0] = at - 0.25f;
        s->instances[6].bounds_max[0] = at + 0.25f;
        s->instances[6].version = 50 + (uint64_t)frame;
        draw(s);
        for (uint32_t px = 0; px < SIZE; px++) {
            const float *p = texel(s, "position", px, SIZE / 2);
            float distance = fabsf(p[0] - 2 * at);
            if (p[2] < -1.99f && fabsf(distance - 0.5f) > 0.03f)
                assert_near(texel(s, "shadow", px, SIZE / 2)[0], distance < 0.5f ? 0.0f : 1.0f, 0);
        }
    }
}

// A wide lamp in an empty room: nothing is in its way, whatever the corners suggest to a filter.
static void corners_are_no_occluders(void **state)
{
    struct stage *s = *state;
    const struct ng_light_rectangle r = {
        .on = true, .color = {1, 1, 1}, .radiance = 10, .size = {1.5f, 1.5f}};
    const float below_ceiling[16] = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 1.9f, 0, 1}; // emits downwards
    add_light(s, NG_LIGHT_RECTANGLE, &r, sizeof r, below_ceiling);
    draw(s);
    for (uint32_t py = 0; py < SIZE; py++)
        for (uint32_t px = 0; px < SIZE; px++)
            if (texel(s, "position", px, py)[1] <
                1.5f) // next to the lamp a map from its centre sees too little
                // Where three walls meet, one texel of the map may hold any of them.
                assert_near(texel(s, "shadow", px, py)[0], 1, 0.05f);
}

static void an_area_light_has_a_penumbra(void **state)
{
    struct stage *s = *state;
    const struct ng_light_rectangle r = {
        .on = true, .color = {1, 1, 1}, .radiance = 10, .size = {0.5f, 0.5f}};
    const float center[3] = {0, 0, -1}, normal[3] = {0, 0, 1};
    float m[16];
    identity(m); // emits along -Z, from the origin
    add_light(s, NG_LIGHT_RECTANGLE, &r, sizeof r, m);
    add_quad(s, 1, center, normal, 0.25f);
    s->snapshot.camera.view[12] = -1.5f;
    s->snapshot.camera.position[0] = 1.5f;
    draw(s);
    // The light spans +-0.25: the umbra on the back wall is +-0.25, the penumbra ends at +-0.75.
    float last = -1;
    for (uint32_t px = 0; px < SIZE; px++) {
        const float *p = texel(s, "position", px, SIZE / 2);
        float shadow = texel(s, "shadow", px, SIZE / 2)[0];
        if (p[2] > -1.99f || p[0] < 0)
            continue;
        if (p[0] < 0.1f)
            assert_near(shadow, 0, 0.1f);
        if (p[0] > 1.0f)
            assert_near(shadow, 1, 0);
        assert_true(shadow >= last - 0.15f); // grows outwards, but for the filter's noise
        last = shadow;
    }
    assert_near(last, 1, 0);
}

static float read_flux(struct stage *s)
{
    struct ng_graph *g = ng_renderer_graph(s->renderer);
    struct ng_graph_memory m;
    double sum = 0;
    const char *const names[] = {"rsm:lamp/flux"};
    s->render.resources = names;
    s->render.resource_count = 1;
    draw(s);
    s->render.resource_count = 0;
    assert_int_equal(ng_graph_readback_get(g, "rsm:lamp/flux", &m), NG_OK);
    for (uint64_t i = 0; i < m.size / 16; i++)
        sum += (double)((const float *)m.data)[i * 4];
    return (float)sum;
}

// In a closed room all of a light's power meets a wall, and the diffuse share comes back; the specular part
// of walls of roughness 1 adds what the fit of its albedo says, a few percent.
static void the_rsm_reflects_the_power_of_the_light(void **state)
{
    struct stage *s = *state;
    add_point(s, 0.3f, -0.4f, 0.2f, 7);
    float power = 4 * PI * 7;
    assert_near(s->lights[0].power, power, power * 1e-4f);
    float flux = read_flux(s);
    assert_true(flux > power * WALL && flux < power * (WALL + 0.05f));
    s->materials[0].base_color[0] = 0;
    for (int i = 0; i < 6; i++)
        s->instances[i].version += 100;
    float specular_only = read_flux(s);
    assert_near(flux - specular_only, power * WALL, power * WALL * 2e-3f);
}

static uint64_t runs_of(struct stage *s, const char *name)
{
    size_t count;
    const struct ng_pass_stats *stats = ng_graph_stats(ng_renderer_graph(s->renderer), &count);
    for (size_t i = 0; i < count; i++)
        if (strcmp(stats[i].name, name) == 0)
            return stats[i].runs;
    return 0;
}

static void light_maps_are_redrawn_only_when_what_they_show_changes(void **state)
{
    struct stage *s = *state;
    const struct ng_light_directional sun = {.on = true, .color = {1, 1, 1}, .irradiance = 2};
    const float center[3] = {0, 0, -1}, normal[3] = {0, 0, 1};
    float m[16];
    identity(m);
    add_light(s, NG_LIGHT_DIRECTIONAL, &sun, sizeof sun, m);
    add_quad(s, 1, center, normal, 0.25f);
    draw(s);
    assert_int_equal(runs_of(s, "rsm:lamp/depth"), 1);
    struct ng_layer before;
    assert_int_equal(ng_renderer_layer(s->renderer, "beauty", &before), NG_OK);
    float pixel = before.pixels[(SIZE / 2 * SIZE + SIZE / 4) * 3];
    for (int i = 0; i < 3; i++)
        draw(s);
    assert_int_equal(runs_of(s, "rsm:lamp/depth"), 1);
    assert_near(texel(s, "beauty", SIZE / 4, SIZE / 2)[0], pixel, 0);

    s->snapshot.camera.view[12] = 0.1f; // the camera is not among the inputs
    draw(s);
    assert_int_equal(runs_of(s, "rsm:lamp/depth"), 1);

    s->instances[6].matrix[3] += 0.5f; // the occluder is
    s->instances[6].version = 77;
    draw(s);
    assert_int_equal(runs_of(s, "rsm:lamp/depth"), 2);

    s->instances[6].bounds_min[1] += 100; // gone from all views: redrawn once, then never
    s->instances[6].bounds_max[1] += 100;
    draw(s);
    assert_int_equal(runs_of(s, "rsm:lamp/depth"), 3);
    s->instances[6].version = 78;
    draw(s);
    assert_int_equal(runs_of(s, "rsm:lamp/depth"), 3);

    read_flux(s);
    s->lights[0].version = 99; // brightness: the small maps hold flux, the depth map does not care
    uint64_t surface = runs_of(s, "rsm:lamp/surface");
    draw(s); // and nothing here reads the small maps
    assert_int_equal(runs_of(s, "rsm:lamp/depth"), 3);
    assert_int_equal(runs_of(s, "rsm:lamp/surface"), surface);
    read_flux(s); // until somebody does
    assert_int_equal(runs_of(s, "rsm:lamp/surface"), surface + 1);
    read_flux(s);
    assert_int_equal(runs_of(s, "rsm:lamp/surface"), surface + 1);
    assert_int_equal(runs_of(s, "rsm:lamp/depth"), 3);
}

// ---- light near an emitter
// ---------------------------------------------------------------------------------

#define NEAR_SAMPLES (1 << 16)
#define TUBE_SIDES   64

// Radiance to the eye at a pixel, of so many samples of the light that none shows.
static float sampled_radiance(struct stage *s, const struct ng_light_source *light,
                              const struct ng_light_sample *samples, uint32_t px, uint32_t py)
{
    const float *p = texel(s, "position", px, py), *n = texel(s, "normal", px, py);
    const float eye[3] = {0, 0, 1};
    float v[3], nv = 0, length = 0;
    double sum = 0;
    for (int a = 0; a < 3; a++)
        v[a] = eye[a] - p[a], length += v[a] * v[a];
    for (int a = 0; a < 3; a++)
        v[a] /= sqrtf(length), nv += n[a] * v[a];
    for (uint32_t i = 0; i < NEAR_SAMPLES; i++) {
        struct ng_light_incident in;
        float nl = 0, lv = 0;
        ng_light_incident_at(light, &samples[i], p, &in);
        for (int a = 0; a < 3; a++)
            nl += n[a] * in.direction[a], lv += in.direction[a] * v[a];
        float half = sqrtf(fmaxf(0.5f * (1 + lv), 1e-6f)); // v.h
        if (nl > 0)
            sum += (double)(ng_brdf(nl, nv, (nl + nv) / (2 * half), half, WALL, 0.04f, 1) * nl *
                            in.irradiance[0]);
    }
    return (float)(sum / NEAR_SAMPLES);
}

// The picture of a light without anything in between, against that: everywhere within `tolerance` of what is
// there, plus a hundredth of the brightest.
static void assert_lights_evenly(struct stage *s, const char *what, float tolerance)
{
    enum { STEP = 5 };
    const struct ng_light_source *light = &s->lights[0].source;
    struct ng_light_sample *samples = calloc(NEAR_SAMPLES, sizeof *samples);
    float want[SIZE / STEP][SIZE / STEP], most = 0;
    draw(s);
    ng_light_vpls(light, NEAR_SAMPLES, samples);
    for (uint32_t y = 0; y < SIZE / STEP; y++)
        for (uint32_t x = 0; x < SIZE / STEP; x++) {
            want[y][x] = sampled_radiance(s, light, samples, x * STEP + 2, y * STEP + 2);
            most = fmaxf(most, want[y][x]);
        }
    for (uint32_t y = 0; y < SIZE / STEP; y++)
        for (uint32_t x = 0; x < SIZE / STEP; x++) {
            float got = texel(s, "unshadowed", x * STEP + 2, y * STEP + 2)[0];
            if (!(fabsf(got - want[y][x]) <= tolerance * want[y][x] + 0.01f * most))
                fail_msg("%s, pixel %u %u: got %g, want %g", what, x * STEP + 2, y * STEP + 2, (double)got,
                         (double)want[y][x]);
        }
    ng_light_finish(&s->lights[0].source);
    s->snapshot.light_count = 0;
    free(samples);
}

// At `distance` before the wall at the back, facing it, or for -1 standing on the floor, facing the camera.
static void pose_emitter(float distance, float height, float m[16])
{
    identity(m); // looks along -Z
    m[14] = -2 + distance;
    if (distance < 0) {
        m[0] = m[10] = -1;
        m[13] = -2 + height;
        m[14] = -1.9f;
    }
}

static void light_is_even_however_near_the_emitter(void **state)
{
    struct stage *s = *state;
    const float distances[] = {0.01f, 0.1f, 1, -1};
    const struct ng_light_rectangle r = {.on = true, .color = {1, 1, 1}, .radiance = 5, .size = {1, 0.6f}};
    const struct ng_light_disk d = {.on = true, .color = {1, 1, 1}, .radiance = 5, .radius = 0.4f};
    const struct ng_light_sphere b = {.on = true, .color = {1, 1, 1}, .radiance = 5, .radius = 0.3f};
    for (size_t i = 0; i < NG_COUNT(distances); i++) {
        float m[16];
        pose_emitter(distances[i], 0.3f, m);
        add_light(s, NG_LIGHT_RECTANGLE, &r, sizeof r, m);
        assert_lights_evenly(s, "rectangle", 0.08f);
        pose_emitter(distances[i], 0.4f, m);
        add_light(s, NG_LIGHT_DISK, &d, sizeof d, m);
        assert_lights_evenly(s, "disk", 0.08f);
        pose_emitter(distances[i] < 0 ? -1 : distances[i] + 0.3f, 0.3f, m);
        m[14] = fmaxf(m[14], -1.69f);
        add_light(s, NG_LIGHT_SPHERE, &b, sizeof b, m);
        assert_lights_evenly(s, "sphere", 0.08f);
    }
}

static void light_of_a_textured_emitter_is_even(void **state)
{
    struct stage *s = *state;
    const struct ng_light_rectangle r = {.on = true, .color = {1, 1, 1}, .radiance = 5, .size = {1, 0.6f}};
    static float texels[8][8][4];
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++)
            texels[y][x][0] = texels[y][x][1] = texels[y][x][2] = x < 4 ? 1 : 0.2f;
    const float distances[] = {0.02f, 0.1f, -1, 0.1f};
    for (size_t i = 0; i < NG_COUNT(distances); i++) {
        float m[16];
        if (i == 3) // a spot that is smaller than what the surface is cut into
            texels[2][2][0] = texels[2][2][1] = texels[2][2][2] = 20;
        pose_emitter(distances[i], 0.3f, m);
        struct ng_snapshot_light *l = add_light(s, NG_LIGHT_RECTANGLE, &r, sizeof r, m);
        l->source.image = (struct ng_light_image){
            .width = 8, .height = 8, .format = NG_LIGHT_TEXEL_FLOAT32, .pixels = texels};
        assert_int_equal(ng_light_prepare(&l->source), NG_OK);
        l->power = ng_light_power(&l->source);
        assert_lights_evenly(s, "textured rectangle", 0.15f);
    }
}

static void an_emitter_does_not_light_itself(void **state)
{
    struct stage *s = *state;
    const struct ng_light_mesh mesh = {.on = true, .color = {1, 1, 1}, .scale = 1};
    static float triangles[18]; // the back wall
    float m[16];
    for (int i = 0; i < 6; i++) {
        triangles[i * 3 + 0] = 2 * quad_positions[quad_indices[i] * 3];
        triangles[i * 3 + 1] = 2 * quad_positions[quad_indices[i] * 3 + 1];
        triangles[i * 3 + 2] = -2;
    }
    identity(m);
    struct ng_snapshot_light *l = add_light(s, NG_LIGHT_MESH, &mesh, sizeof mesh, m);
    l->source.triangles = triangles;
    l->source.triangle_count = 2;
    l->source.double_sided = true;
    for (int c = 0; c < 3; c++)
        l->source.emission[c] = 5;
    assert_int_equal(ng_light_prepare(&l->source), NG_OK);
    l->power = ng_light_power(&l->source);
    draw(s);
    for (uint32_t i = 0; i < SIZE; i++) // of the wall
        assert_near(texel(s, "unshadowed", SIZE / 3 + i / 4, SIZE / 3 + i / 3)[0], 0, 1e-3f);
    ng_light_finish(&l->source);
    s->snapshot.light_count = 0;
}

// An upright tube that stands on the floor, of rings of triangles.
static uint32_t make_tube(uint32_t rings, float *out)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < rings; k++)
        for (uint32_t i = 0; i < TUBE_SIDES; i++)
            for (uint32_t half = 0; half < 2; half++)
                for (uint32_t c = 0; c < 3; c++, count++) {
                    static const uint32_t corners[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}},
                                                              {{0, 0}, {1, 1}, {0, 1}}};
                    float angle = 2 * PI * (float)(i + corners[half][c][0]) / TUBE_SIDES;
                    out[count * 3 + 0] = 0.2f * sinf(angle);
                    out[count * 3 + 1] = -2 + (float)(k + corners[half][c][1]) / (float)rings;
                    out[count * 3 + 2] = -1.6f + 0.2f * cosf(angle);
                }
    return count / 3;
}

static void light_of_a_mesh_is_even(void **state)
{
    struct stage *s = *state;
    const struct ng_light_mesh mesh = {.on = true, .color = {1, 1, 1}, .scale = 1};
    static float triangles[8 * TUBE_SIDES * 2 * 9];
    for (uint32_t rings = 1; rings <= 8; rings *= 8)
        for (int sides = 1; sides <= 2; sides++) {
            float m[16];
            identity(m);
            struct ng_snapshot_light *l = add_light(s, NG_LIGHT_MESH, &mesh, sizeof mesh, m);
            l->source.triangles = triangles;
            l->source.triangle_count = make_tube(rings, triangles);
            l->source.double_sided = sides == 2;
            for (int c = 0; c < 3; c++)
                l->source.emission[c] = 5;
            assert_int_equal(ng_light_prepare(&l->source), NG_OK);
            l->power = ng_light_power(&l->source);
            assert_lights_evenly(s, rings == 1 ? "mesh" : "mesh of many triangles",
                                 rings == 1 ? 0.08f : 0.3f);
        }
}

static void lights_add_up_and_names_may_clash(void **state)
{
    struct stage *s = *state;
    add_point(s, 0.5f, 0, 0, 7);
    draw(s);
    float one = texel(s, "direct", 30, 30)[0];
    s->lights[0].version++;
    add_point(s, 0.5f, 0, 0, 7); // the same name again
    draw(s);
    assert_near(texel(s, "direct", 30, 30)[0], 2 * one, one * 1e-5f);
    uint64_t runs = runs_of(s, "rsm:lamp#2/depth");
    assert_int_equal(runs, 1);
    draw(s); // each keeps maps of its own
    assert_int_equal(runs_of(s, "rsm:lamp#2/depth"), runs);
    for (int i = 0; i < 2; i++) // what would drive a terminal
        snprintf(s->lights[i].name, sizeof s->lights[i].name, "la\x1bmp");
    draw(s);
    assert_int_equal(runs_of(s, "rsm:la?mp#2/depth"), 1);
    s->snapshot.light_count = 0;
    ng_light_finish(&s->lights[0].source);
    ng_light_finish(&s->lights[1].source);
    draw(s);
    assert_near(texel(s, "beauty", 30, 30)[0], 0, 0);
    assert_near(texel(s, "shadow", 30, 30)[0], 1, 0);
}

static void the_display_is_the_tone_map_of_beauty(void **state)
{
    struct stage *s = *state;
    const uint8_t *rgba;
    uint32_t width, height;
    add_point(s, 0, 0, -1.5f, 3);
    s->snapshot.camera.exposure = 1.5f;
    draw(s);
    assert_int_equal(ng_renderer_display(s->renderer, &rgba, &width, &height), NG_OK);
    assert_int_equal(width, SIZE);
    for (uint32_t i = 0; i < SIZE * SIZE; i += 37) {
        const float *b = texel(s, "beauty", i % SIZE, i / SIZE);
        float x[3], peak = 0, toe = 1e30f;
        for (int c = 0; c < 3; c++) {
            x[c] = b[c] * 1.5f;
            peak = fmaxf(peak, x[c]);
            toe = fminf(toe, x[c]);
        }
        for (int c = 0; c < 3; c++)
            assert_near(rgba[i * 4 + (uint32_t)c], 255 * ng_srgb_encode(ng_tonemap(x[c], peak, toe)), 1.01f);
    }
}

// The mean of what is shown, 0 to 255, of a room lit by one lamp.
static float shown_by(struct stage *s, float intensity)
{
    const uint8_t *rgba;
    uint32_t width, height, sum = 0;
    while (s->snapshot.light_count)
        ng_light_finish(&s->lights[--s->snapshot.light_count].source);
    add_point(s, 0, 0, 0, intensity);
    s->lights[0].version = (uint64_t)(intensity * 1e6f) + 1;
    draw(s);
    assert_int_equal(ng_renderer_display(s->renderer, &rgba, &width, &height), NG_OK);
    for (uint32_t i = 0; i < width * height * 4; i++)
        sum += i % 4 == 3 ? 0 : rgba[i];
    return (float)sum / (float)(width * height * 3);
}

static void the_meter_exposes_light_of_any_strength(void **state)
{
    struct stage *s = *state;
    s->snapshot.camera.auto_exposure = true;
    float shown = shown_by(s, 1);
    assert_true(shown > 90 && shown < 190);
    assert_near(shown_by(s, 1e-3f), shown, 2);
    assert_near(shown_by(s, 1e5f), shown, 2);
    s->snapshot.camera.exposure = 2; // a stop more
    float brighter = shown_by(s, 1e5f);
    assert_true(brighter > shown + 20);
    s->snapshot.camera.exposure = 1;
    shown_by(s, 0); // in the dark it finds a number all the same
    assert_near(shown_by(s, 1), shown, 2);
}

// Of pictures that are seen one after the other each goes a part of the way; after a first one, and without
// adaptation, it is what it is alone.
static void exposure_adapts_to_what_is_seen(void **state)
{
    struct stage *s = *state;
    s->snapshot.camera.auto_exposure = true;
    float alone = shown_by(s, 1);
    s->render.adaptation = 0.5f;
    float first = shown_by(s, 1), second = shown_by(s, 4), third = shown_by(s, 4);
    assert_near(first, alone, 0.5f);
    assert_true(second > first + 10); // four times the light, of two stops one is made up for
    assert_true(third < second - 5 && third > first);
    for (int i = 0; i < 12; i++)
        shown_by(s, 4);
    assert_near(shown_by(s, 4), alone, 2);
    s->render.adaptation = 0;
    assert_near(shown_by(s, 100), alone, 2);
}

static void where_nothing_is_seen_the_background_is_shown(void **state)
{
    struct stage *s = *state;
    const uint8_t *rgba;
    uint32_t width, height;
    add_point(s, 0, 0, 0, 7);
    for (int i = 0; i < 2; i++) {
        if (i)
            memcpy(s->snapshot.camera.background, (const float[]){0.1f, 0.2f, 0.3f}, 3 * sizeof(float));
        s->snapshot.instance_count = 4;
        draw(s);
        assert_int_equal(ng_renderer_display(s->renderer, &rgba, &width, &height), NG_OK);
        const uint8_t *pixel = rgba + (size_t)4 * (SIZE / 2 * SIZE + SIZE / 2),
                      *wall = rgba + (size_t)4 * SIZE / 2;
        for (int c = 0; c < 3; c++)
            assert_near(pixel[c], 255 * ng_srgb_encode(s->snapshot.camera.background[c]), 1.01f);
        assert_true(wall[0] > 100);
        assert_near(texel(s, "beauty", SIZE / 2, SIZE / 2)[2], 0, 0); // it is no light
    }
}

// ---- The display on the host -----------------------------------------------------------------------------

static struct ng_display_map map_of(struct stage *s, const char *resource)
{
    struct ng_graph_memory m;
    assert_int_equal(ng_graph_readback_get(ng_renderer_graph(s->renderer), resource, &m), NG_OK);
    return m.format == VK_FORMAT_R32G32B32A32_SFLOAT ? (struct ng_display_map){.floats = m.data}
                                                     : (struct ng_display_map){.halfs = m.data};
}

// A layer as the device shows it, beside what the kernels make of the same resources; in parts that are no
// multiples of their lanes.
static void assert_host_shows(struct stage *s, const char *left, const char *left_divisor, const char *right,
                              struct ng_display_data shown)
{
    static uint8_t ours[SIZE * SIZE * 4], first[SIZE * SIZE * 4];
    const uint8_t *rgba;
    uint32_t width, height;
    draw(s);
    assert_int_equal(ng_renderer_display(s->renderer, &rgba, &width, &height), NG_OK);
    const struct ng_display_picture picture = {.shown = shown,
                                               .exposure = s->snapshot.camera.exposure,
                                               .left = map_of(s, left),
                                               .left_divisor = left_divisor ? map_of(s, left_divisor)
                                                                            : (struct ng_display_map){0},
                                               .right = right ? map_of(s, right) : (struct ng_display_map){0},
                                               .position = map_of(s, "gbuffer/position"),
                                               .width = SIZE,
                                               .out = ours};
    const struct ng_display_kernels *k;
    for (uint32_t set = 0; (k = ng_display_kernels_of(set)); set++) {
        memset(ours, 1, sizeof ours);
        k->show(&picture, 0, 7);
        k->show(&picture, 7, 1000);
        k->show(&picture, 1000, SIZE * SIZE);
        for (uint32_t i = 0; i < SIZE * SIZE * 4; i++)
            if (abs(ours[i] - rgba[i]) > 1)
                fail_msg("%s: byte %u is %u, and %u on the device", left, i, ours[i], rgba[i]);
        if (set)
            assert_memory_equal(ours, first, sizeof ours);
        memcpy(first, ours, sizeof ours);
    }
}

static void the_host_shows_what_the_device_shows(void **state)
{
    static const char *const resources[] = {
        "gbuffer/position",  "gbuffer/diffuse",  "gbuffer/normal", "raster/direct",
        "raster/unshadowed", "gbuffer/emission", "beauty"};
    struct stage *s = *state;
    struct ng_shown *shown = &s->render.shown;
    s->render.resources = resources;
    s->render.resource_count = NG_COUNT(resources);
    s->materials[0].roughness = 0.25f;
    s->materials[0].base_color[1] = 0.1f;
    s->snapshot.camera.exposure = 3; // white in the middle, dark in corners
    memcpy(s->snapshot.camera.background, (const float[]){0.1f, 0.2f, 0.3f}, 3 * sizeof(float));
    s->snapshot.instance_count = 5; // a wall is open
    const float lit[3] = {0, 0.6f, -0.5f}, up[3] = {0, 0, 1};
    add_quad(s, 1, lit, up, 0.3f);
    add_point(s, 0.5f, 0, 0, 7);
    struct ng_display_data data = {.encoding = NG_SHOWN_BEAUTY, .background = {0.1f, 0.2f, 0.3f}};
    assert_host_shows(s, "beauty", NULL, NULL, data);
    shown->layer = "direct";
    data.encoding = NG_SHOWN_RADIANCE;
    assert_host_shows(s, "raster/direct", NULL, NULL, data);
    shown->layer = "shadow";
    data.encoding = NG_SHOWN_RATIO;
    assert_host_shows(s, "raster/direct", "raster/unshadowed", NULL, data);
    shown->layer = "roughness";
    data.encoding = NG_SHOWN_W;
    assert_host_shows(s, "gbuffer/normal", NULL, NULL, data);
    shown->layer = "normal";
    data.encoding = NG_SHOWN_DIRECTION;
    assert_host_shows(s, "gbuffer/normal", NULL, NULL, data);
    shown->layer = "albedo";
    data.encoding = NG_SHOWN_PLAIN;
    assert_host_shows(s, "gbuffer/diffuse", NULL, NULL, data);
    shown->other_layer = "beauty";
    shown->divider = 0.3f;
    shown->comparison = data.comparison = NG_COMPARE_SPLIT;
    data.divider = 0.3f * SIZE;
    data.other_encoding = NG_SHOWN_BEAUTY;
    assert_host_shows(s, "gbuffer/diffuse", NULL, "beauty", data);
    shown->comparison = data.comparison = NG_COMPARE_DIFFERENCE;
    assert_host_shows(s, "gbuffer/diffuse", NULL, "beauty", data);
}

static void the_host_adds_up_what_the_device_adds_up(void **state)
{
    static const char *const resources[] = {"raster/direct", "gbuffer/emission", "beauty"};
    static float ours[SIZE * SIZE * 4];
    struct stage *s = *state;
    s->render.resources = resources;
    s->render.resource_count = NG_COUNT(resources);
    add_point(s, 0.5f, 0, 0, 7);
    draw(s);
    const struct ng_display_map parts[3] = {map_of(s, "raster/direct"), {0}, map_of(s, "gbuffer/emission")};
    const struct ng_display_kernels *k;
    for (uint32_t set = 0; (k = ng_display_kernels_of(set)); set++) {
        memset(ours, 1, sizeof ours);
        k->compose(parts, 0, 5, ours);
        k->compose(parts, 5, SIZE * SIZE, ours);
        assert_memory_equal(ours, map_of(s, "beauty").floats, sizeof ours);
    }
}

// Same scene, other flags: the same bytes.
static void pictures_do_not_depend_on_culling_or_aliasing(void **state)
{
    NG_UNUSED(state);
    float *first = NULL;
    for (int i = 0; i < 4; i++) {
        void *p;
        begin_with(&p, (struct ng_renderer_params){.no_culling = i & 1, .no_aliasing = i & 2});
        struct stage *s = p;
        const float center[3] = {0, 0, -1}, normal[3] = {0, 0, 1};
        add_point(s, 0.2f, 0.3f, 0, 7);
        add_quad(s, 1, center, normal, 0.25f);
        for (int frame = 0; frame < 3; frame++)
            draw(s);
        const float *beauty = texel(s, "beauty", 0, 0);
        if (!first) {
            first = malloc(SIZE * SIZE * 12);
            memcpy(first, beauty, SIZE * SIZE * 12);
        } else {
            assert_memory_equal(first, beauty, SIZE * SIZE * 12);
        }
        end(&p);
    }
    free(first);
}

static void steady_frames_create_nothing(void **state)
{
    struct stage *s = *state;
    add_point(s, 0, 0, 0, 7);
    for (int i = 0; i < 4; i++)
        draw(s);
    struct ng_graph *g = ng_renderer_graph(s->renderer);
    struct ng_graph_counters before = ng_graph_counters(g);
    struct ng_gpu_stats gpu = ng_gpu_stats(s->gpu);
    for (int i = 0; i < 4; i++)
        draw(s);
    assert_int_equal(ng_graph_counters(g).objects_created, before.objects_created);
    assert_int_equal(ng_gpu_stats(s->gpu).memory_reserved, gpu.memory_reserved);
    assert_int_equal(ng_gpu_stats(s->gpu).bind_groups, gpu.bind_groups);
}

static void odd_sizes_work(void **state)
{
    struct stage *s = *state;
    const uint32_t sizes[][2] = {{1, 1}, {17, 3}, {3, 200}};
    add_point(s, 0, 0, 0, 7);
    for (size_t i = 0; i < NG_COUNT(sizes); i++) {
        s->render.width = sizes[i][0];
        s->render.height = sizes[i][1];
        draw(s);
        assert_true(texel(s, "beauty", sizes[i][0] / 2, sizes[i][1] / 2)[0] > 0);
    }
}

static const uint8_t *shown_at(struct stage *s, uint32_t x, uint32_t y)
{
    const uint8_t *rgba;
    uint32_t width, height;
    draw(s);
    assert_int_equal(ng_renderer_display(s->renderer, &rgba, &width, &height), NG_OK);
    return rgba + ((size_t)y * width + x) * 4;
}

static void assert_shown(struct stage *s, uint32_t x, uint32_t y, float r, float g, float b)
{
    const uint8_t *at = shown_at(s, x, y);
    assert_near(at[0], 255 * r, 1.5f);
    assert_near(at[1], 255 * g, 1.5f);
    assert_near(at[2], 255 * b, 1.5f);
}

static void any_layer_can_be_shown_and_compared(void **state)
{
    struct stage *s = *state;
    const uint32_t mid = SIZE / 2, left = mid - 8, right = mid + 8; // on the back wall
    float wall = ng_srgb_encode(WALL), rough = ng_srgb_encode(0.25f);
    s->materials[0].roughness = 0.25f;
    s->render.shown.layer = "albedo";
    assert_shown(s, mid, mid, wall, wall, wall);
    s->render.shown.layer = "roughness";
    assert_shown(s, mid, mid, rough, rough, rough);
    s->render.shown.layer = "normal"; // towards +Z
    assert_shown(s, mid, mid, 0.5f, 0.5f, 1);
    s->render.shown.layer = "shadow"; // nothing is lit: 1 by definition
    assert_shown(s, mid, mid, 1, 1, 1);

    s->render.shown = (struct ng_shown){
        .layer = "albedo", .comparison = NG_COMPARE_SPLIT, .other_layer = "roughness", .divider = 0.5f};
    assert_shown(s, left, mid, wall, wall, wall);
    assert_shown(s, right, mid, rough, rough, rough);
    assert_shown(s, mid, mid, 1, 1, 1); // the divider
    s->render.shown.divider = 0;
    assert_shown(s, left, mid, rough, rough, rough);

    s->render.shown.comparison = NG_COMPARE_DIFFERENCE; // 0.5 against 0.25: brighter by more than half
    assert_shown(s, mid, mid, 1, 0.5f, 0.1f);
    s->render.shown.other_layer = "albedo";
    assert_shown(s, mid, mid, 0, 0, 0);

    s->render.shown = (struct ng_shown){.layer = "indirect"}; // not the rasterizer's
    assert_shown(s, mid, mid, 0, 0, 0);
    assert_false(ng_renderer_shows(s->renderer, 0));
}

static void what_cannot_be_had_is_said(void **state)
{
    struct stage *s = *state;
    struct ng_cmd *cmd;
    struct ng_layer layer;
    struct test_log log;
    const char *const indirect[] = {"indirect"}, *const unknown[] = {"glitter"};
    test_log_begin(&log);
    s->render.layers = indirect;
    s->render.layer_count = 1;
    draw(s);
    assert_int_equal(ng_renderer_layer(s->renderer, "indirect", &layer), NG_ERROR_UNSUPPORTED);
    assert_non_null(strstr(log.text, "\"raster\" does not compute it"));
    s->render.layers = unknown;
    assert_int_equal(ng_frame_begin(s->gpu, &cmd), NG_OK);
    assert_int_equal(ng_renderer_frame(s->renderer, &cmd, &s->render), NG_ERROR_NOT_FOUND);
    assert_non_null(strstr(log.text, "glitter"));
    s->render.layer_count = 0;
    s->render.method = "magic";
    assert_int_equal(ng_renderer_frame(s->renderer, &cmd, &s->render), NG_ERROR_NOT_FOUND);
    assert_non_null(strstr(log.text, "magic"));
    assert_int_equal(ng_frame_end(s->gpu, &cmd), NG_OK);
    s->render.method = NULL;
    draw(s); // and the next frame is fine
    test_log_end(&log);
    assert_int_equal(log.errors, 3);
}

static void set_camera(struct stage *s, float x, float y, float z)
{
    struct ng_snapshot_camera *c = &s->snapshot.camera;
    const float at[3] = {x, y, z};
    for (int a = 0; a < 3; a++) {
        c->position[a] = at[a];
        c->view[12 + a] = -at[a];
    }
    memcpy(c->previous_view, c->view, sizeof c->view);
}

// A sun straight from above on a plain of 800 m, which a single map would see at 0.8 m a texel: a plate of 1
// m that floats at 1 m, near and far from the camera, has a shadow with sharp edges all the same.
static void cascades_keep_shadows_sharp_in_large_scenes(void **state)
{
    struct stage *s = *state;
    const struct ng_light_directional sun = {.on = true, .color = {1, 1, 1}, .irradiance = PI};
    const float ground[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    const float downwards[16] = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}; // -Z becomes -Y
    s->snapshot.scene_radius = 400;
    s->snapshot.instance_count = 0;
    add_quad(s, 0, ground, up, 400);
    add_light(s, NG_LIGHT_DIRECTIONAL, &sun, sizeof sun, downwards);
    for (int far = 0; far < 2; far++) {
        float half = far ? 4.0f : 0.5f;
        const float plate[3] = {0.3f, far ? 20.0f : 1.0f, far ? -30.0f : -3.0f};
        s->snapshot.instance_count = 1;
        add_quad(s, 1, plate, up, half);
        s->instances[1].version = 10 + (uint64_t)far;
        set_camera(s, 0, far ? 8.0f : 0.5f, 0); // below the plate, level
        draw(s);
        int dark = 0, lit = 0;
        float margin = far ? 0.12f : 0.03f; // about two texels of the cascade
        for (uint32_t py = SIZE / 2; py < SIZE; py++)
            for (uint32_t px = 0; px < SIZE; px++) {
                const float *p = texel(s, "position", px, py);
                float dx = fabsf(p[0] - plate[0]) - half, dz = fabsf(p[2] - plate[2]) - half,
                      edge = fmaxf(dx, dz);
                if (p[2] > -0.1f || fabsf(p[1]) > 1e-2f || p[2] < -45 || fabsf(edge) < margin)
                    continue;
                assert_near(texel(s, "shadow", px, py)[0], edge < 0 ? 0.0f : 1.0f, 0);
                dark += edge < 0;
                lit += edge > 0;
                if (edge > 0 && p[2] > -3) // and the light itself: E / pi * albedo, and a little specular
                    assert_near(texel(s, "direct", px, py)[0], WALL * 0.98f, 0.05f);
            }
        assert_true(dark > 5 && lit > 200);
    }
    assert_int_equal(s->snapshot.light_count, 1);
}

static void the_face_size_falls_with_the_budget(void **state)
{
    NG_UNUSED(state);
    assert_int_equal(ng_light_maps_face_size(192 << 20, 1), 1024);
    assert_int_equal(ng_light_maps_face_size(192 << 20, 48), 1024);
    assert_int_equal(ng_light_maps_face_size(192 << 20, 49), 512);
    assert_int_equal(ng_light_maps_face_size(192 << 20, 1200), 128);
    assert_int_equal(ng_light_maps_face_size(1, 1), 64);
}

// ---- lavapipe's cache of shaders ------------------------------------------------------------------------

static int files_below(const char *folder)
{
    int count = 0;
    DIR *dir = opendir(folder);
    for (const struct dirent *e; dir && (e = readdir(dir));) {
        char path[4096];
        struct stat status;
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        if (e->d_name[0] != '.' && stat(path, &status) == 0)
            count += S_ISDIR(status.st_mode) ? files_below(path) : 1;
    }
    if (dir)
        closedir(dir);
    return count;
}

// Frame `n` of a scene in which every number changes, and the number of lights.
static void change_everything(struct stage *s, int n)
{
    const float t = (float)n / 20;
    float m[16];
    while (s->snapshot.light_count)
        ng_light_finish(&s->lights[--s->snapshot.light_count].source);
    add_point(s, t, 1, -t, 1 + t);
    identity(m);
    m[12] = -t;
    if (n % 3 == 1)
        add_light(
            s, NG_LIGHT_SPOT,
            &(struct ng_light_spot){.on = true, .color = {1, t, 1}, .intensity = 3, .outer_angle = 0.3f + t},
            sizeof(struct ng_light_spot), m);
    if (n % 3 == 2)
        add_light(
            s, NG_LIGHT_RECTANGLE,
            &(struct ng_light_rectangle){.on = true, .color = {1, 1, 1}, .radiance = t, .size = {0.2f, t}},
            sizeof(struct ng_light_rectangle), m);
    if (n > 10)
        add_light(s, NG_LIGHT_DIRECTIONAL,
                  &(struct ng_light_directional){.on = true, .color = {1, 1, 1}, .irradiance = t},
                  sizeof(struct ng_light_directional), m);
    s->materials[0].base_color[0] = s->materials[1].roughness = 0.1f + t / 2;
    s->materials[1].emission[1] = t;
    s->materials[1].double_sided = n % 2;
    s->snapshot.camera.exposure = 1 + t;
    s->snapshot.camera.auto_exposure = n % 2;
    s->snapshot.camera.background[1] = t / 2;
    s->render.adaptation = n % 4 > 1 ? t : 0;
    s->snapshot.camera.fov_y = 1 + t / 2;
    set_camera(s, t, 0, 1);
    s->render.shown.divider = t;
}

// Draws so many frames on a device whose shaders are cached in `folder`; the files that are there then.
static int files_after(const char *folder, int frames)
{
    void *state;
    assert_int_equal(setenv("MESA_SHADER_CACHE_DIR", folder, 1), 0);
    begin(&state);
    struct stage *s = state;
    add_quad(s, 1, (const float[]){0, -0.5f, -0.5f}, (const float[]){0, 1, 0}, 0.4f);
    s->render.shown.comparison = NG_COMPARE_SPLIT;
    for (int n = 0; n < frames; n++) {
        change_everything(s, n);
        draw(s);
    }
    end(&state);
    assert_int_equal(unsetenv("MESA_SHADER_CACHE_DIR"), 0);
    return files_below(folder);
}

// Lavapipe compiles shaders anew for each value of a uniform that they branch on (render/passes.h).
static void frames_of_new_numbers_compile_no_shader(void **state)
{
    NG_UNUSED(state);
    char folder[512];
    test_path(folder, sizeof folder, "shaders.XXXXXX");
    assert_non_null(mkdtemp(folder));
    if (!files_after(folder, 2))
        skip();                       // a driver that keeps its shaders elsewhere
    int few = files_after(folder, 2); // Mesa may have left one out while the folder was new
    assert_int_equal(files_after(folder, 20), few);
}

#define T(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(gbuffer_holds_the_surface_at_the_pixel_centre),
        T(picking_names_the_entity),
        T(motion_is_now_minus_before_in_pixels),
        T(a_flattened_instance_has_finite_motion),
        T(a_point_light_obeys_the_inverse_square_and_the_brdf),
        T(an_occluder_casts_the_shadow_that_geometry_says),
        T(copies_in_one_place_are_one),
        T(what_moves_takes_its_shadow_along),
        T(corners_are_no_occluders),
        T(an_area_light_has_a_penumbra),
        T(the_rsm_reflects_the_power_of_the_light),
        T(light_maps_are_redrawn_only_when_what_they_show_changes),
        T(light_is_even_however_near_the_emitter),
        T(light_of_a_textured_emitter_is_even),
        T(light_of_a_mesh_is_even),
        T(an_emitter_does_not_light_itself),
        T(lights_add_up_and_names_may_clash),
        T(the_display_is_the_tone_map_of_beauty),
        T(the_meter_exposes_light_of_any_strength),
        T(exposure_adapts_to_what_is_seen),
        T(where_nothing_is_seen_the_background_is_shown),
        T(any_layer_can_be_shown_and_compared),
        T(the_host_shows_what_the_device_shows),
        T(the_host_adds_up_what_the_device_adds_up),
        cmocka_unit_test(frames_of_new_numbers_compile_no_shader),
        cmocka_unit_test(pictures_do_not_depend_on_culling_or_aliasing),
        T(cascades_keep_shadows_sharp_in_large_scenes),
        T(steady_frames_create_nothing),
        T(odd_sizes_work),
        T(what_cannot_be_had_is_said),
        cmocka_unit_test(the_face_size_falls_with_the_budget),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

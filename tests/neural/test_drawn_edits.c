// Assets that are edited, and those who draw them: a drag costs no topology, no buffer and no structure of
// rays, and whatever is edited, undone or cancelled looks as it does to a renderer that never saw it
// otherwise.
#include "neural_test.h"

#include "asset/geometry.h"
#include "asset/image.h"
#include "components/animation.h"
#include "components/light_rectangle.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/name.h"
#include "components/subdivision.h"
#include "components/transform.h"
#include "lightformer/trace/tracer.h"
#include "render/extract.h"
#include "scene/history.h"
#include "scene/system.h"

enum { WIDTH = 48, HEIGHT = 40 };

static const char *const surface[] = {"position", "normal", "albedo", "emission"};
static const char *const all[] = {"position", "normal", "albedo", "emission", "unshadowed", "direct"};

// ---- Pictures --------------------------------------------------------------------------------------------
struct picture {
    float *layers[NG_COUNT(all)];
    size_t bytes[NG_COUNT(all)];
    uint32_t count;
};

static void draw(struct ng_gpu *gpu, struct ng_renderer *renderer, const struct ng_snapshot *snapshot,
                 const char *const *layers, uint32_t count)
{
    const struct ng_render_params params = {.snapshot = snapshot,
                                            .width = WIDTH,
                                            .height = HEIGHT,
                                            .method = "raster",
                                            .layers = layers,
                                            .layer_count = count};
    struct ng_cmd *cmd;
    OK(ng_frame_begin(gpu, &cmd));
    OK(ng_renderer_frame(renderer, &cmd, &params));
    OK(ng_frame_end(gpu, &cmd));
}

static struct picture keep(struct ng_renderer *renderer, const char *const *layers, uint32_t count)
{
    struct picture p = {.count = count};
    for (uint32_t i = 0; i < count; i++) {
        struct ng_layer layer;
        OK(ng_renderer_layer(renderer, layers[i], &layer));
        p.bytes[i] = (size_t)layer.width * layer.height * layer.channels * sizeof(float);
        p.layers[i] = malloc(p.bytes[i]);
        assert_non_null(p.layers[i]);
        memcpy(p.layers[i], layer.pixels, p.bytes[i]);
    }
    return p;
}

static void forget(struct picture *p)
{
    for (uint32_t i = 0; i < p->count; i++)
        free(p->layers[i]);
}

static bool same(const struct picture *a, const struct picture *b)
{
    bool equal = a->count == b->count;
    for (uint32_t i = 0; equal && i < a->count; i++)
        equal = a->bytes[i] == b->bytes[i] && memcmp(a->layers[i], b->layers[i], a->bytes[i]) == 0;
    return equal;
}

// What an extractor and a renderer draw that never saw the scene before.
static struct picture draw_afresh(const struct scene *s, struct ng_gpu *gpu, const char *const *layers,
                                  uint32_t count)
{
    const struct ng_extract_params params = {.world = s->world, .assets = s->assets, .jobs = s->jobs};
    const struct ng_snapshot *snapshot;
    struct ng_extractor *extractor;
    struct ng_renderer *renderer;
    OK(ng_extractor_create(&extractor));
    OK(ng_renderer_create(&(struct ng_renderer_params){.gpu = gpu, .jobs = s->jobs}, &renderer));
    OK(ng_extract(extractor, &params, &snapshot));
    draw(gpu, renderer, snapshot, layers, count);
    struct picture p = keep(renderer, layers, count);
    ng_renderer_destroy(&renderer);
    ng_extractor_destroy(&extractor);
    return p;
}

// ---- A drag ----------------------------------------------------------------------------------------------
static ng_entity find(const struct scene *s, const char *name)
{
    const ng_entity root = {0};
    for (ng_entity e = ng_world_first_child(s->world, root); !ng_entity_is_null(e);
         e = ng_world_next_below(s->world, root, e)) {
        const struct ng_name *text = ng_world_get(s->world, e, NG_NAME);
        if (text && strstr(text->text, name) && ng_world_has(s->world, e, NG_SUBDIVISION))
            return e;
    }
    fail_msg("nothing that is subdivided is named %s", name);
    return root;
}

struct cost {
    uint64_t topologies, buffers, images;
};

static struct cost cost_of(const struct scene *s, const struct ng_gpu *gpu)
{
    struct ng_gpu_stats stats = ng_gpu_stats(gpu);
    return (struct cost){.topologies = ng_extractor_stats_of(s->extractor).topologies,
                         .buffers = stats.buffers_made,
                         .images = stats.images_made};
}

static uint32_t highest(const float *points, uint32_t count)
{
    uint32_t best = 0;
    for (uint32_t i = 1; i < count; i++)
        best = points[(size_t)i * 3 + 1] > points[(size_t)best * 3 + 1] ? i : best;
    return best;
}

static void drag(struct scene *s, ng_asset id, uint32_t vertex)
{
    float *points = ng_assets_edit_points(s->assets, id);
    assert_non_null(points);
    points[vertex * 3 + 1] += 0.004f;
    points[vertex * 3] += 0.002f;
    OK(ng_assets_changed(s->assets, id));
    scene_frame(s, 0);
}

// A vertex of the king for a hundred frames: of its cage, or of its triangles.
static void drag_king(struct ng_gpu *gpu, bool of_cage)
{
    struct scene s;
    struct ng_renderer *renderer;
    scene_load(&s, 2, "content/chess/chess.glb");
    ng_entity king = find(&s, "king");
    if (!of_cage)
        OK(ng_world_remove(s.world, king, NG_SUBDIVISION));
    ng_asset id = of_cage ? ((const struct ng_subdivision *)ng_world_get(s.world, king, NG_SUBDIVISION))->cage
                          : ((const struct ng_mesh *)ng_world_get(s.world, king, NG_MESH))->geometry;
    OK(ng_renderer_create(&(struct ng_renderer_params){.gpu = gpu, .jobs = s.jobs}, &renderer));
    scene_frame(&s, 0);
    draw(gpu, renderer, s.snapshot, surface, NG_COUNT(surface));
    struct picture before = keep(renderer, surface, NG_COUNT(surface));

    const struct ng_cage *cage = ng_assets_cage(s.assets, id);
    const struct ng_geometry *g = ng_assets_geometry(s.assets, id);
    uint32_t top =
        of_cage ? highest(cage->positions, cage->vertex_count) : highest(g->positions, g->vertex_count);
    struct cost start = {0};
    uint64_t topologies = ng_extractor_stats_of(s.extractor).topologies;
    OK(ng_world_begin(s.world, "drag"));
    for (uint32_t i = 0; i < 100; i++) {
        drag(&s, id, top);
        assert_int_equal(lf_tracer_stats_of(s.tracer).built, 0);
        assert_true(lf_tracer_stats_of(s.tracer).updated > 0);
        draw(gpu, renderer, s.snapshot, surface, NG_COUNT(surface));
        if (i == 50) // what is staged goes around in a ring, which has all of its buffers by now
            start = cost_of(&s, gpu);
    }
    OK(ng_world_commit(s.world));
    struct cost stop = cost_of(&s, gpu);
    assert_int_equal(stop.topologies, topologies);
    assert_int_equal(stop.buffers, start.buffers);
    assert_int_equal(stop.images, start.images);
    struct picture dragged = keep(renderer, surface, NG_COUNT(surface));
    struct picture fresh = draw_afresh(&s, gpu, surface, NG_COUNT(surface));
    assert_true(same(&dragged, &fresh));
    assert_false(same(&dragged, &before));

    start = cost_of(&s, gpu);
    OK(ng_world_undo(s.world));
    assert_null(ng_world_undo_label(s.world));
    scene_frame(&s, 0);
    assert_int_equal(lf_tracer_stats_of(s.tracer).built, 0);
    draw(gpu, renderer, s.snapshot, surface, NG_COUNT(surface));
    struct picture undone = keep(renderer, surface, NG_COUNT(surface));
    assert_true(same(&undone, &before));
    OK(ng_world_redo(s.world));
    scene_frame(&s, 0);
    draw(gpu, renderer, s.snapshot, surface, NG_COUNT(surface));
    struct picture redone = keep(renderer, surface, NG_COUNT(surface));
    assert_true(same(&redone, &dragged));
    assert_int_equal(cost_of(&s, gpu).topologies, start.topologies);
    assert_int_equal(cost_of(&s, gpu).buffers, start.buffers);

    struct picture *pictures[] = {&before, &dragged, &fresh, &undone, &redone};
    for (size_t i = 0; i < NG_COUNT(pictures); i++)
        forget(pictures[i]);
    ng_renderer_destroy(&renderer);
    scene_close(&s);
}

static void a_dragged_vertex_of_a_cage_costs_its_points(void **state)
{
    drag_king(*state, true);
}

static void a_dragged_vertex_of_a_geometry_costs_its_points(void **state)
{
    drag_king(*state, false);
}

// ---- Edits of every kind ---------------------------------------------------------------------------------
struct room_of_assets {
    struct scene s;
    ng_entity quad;
    ng_asset geometry, image, light_image, clip;
};

static void *copy_of(const void *data, size_t size)
{
    void *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, data, size);
    return copy;
}

static struct ng_image checks(uint32_t side, unsigned char value)
{
    struct ng_image image = {.width = side,
                             .height = side,
                             .levels = 1,
                             .format = NG_PIXEL_RGBA8_SRGB,
                             .size = (size_t)side * side * 4,
                             .pixels = calloc((size_t)side * side, 4)};
    assert_non_null(image.pixels);
    unsigned char *texels = image.pixels;
    for (size_t i = 0; i < image.size; i++)
        texels[i] = (i / 4 + i / 4 / side) % 2 ? value : (unsigned char)(255 - value);
    return image;
}

static ng_asset take_checks(struct room_of_assets *r, uint32_t side)
{
    struct ng_image image = checks(side, 200);
    ng_asset id;
    OK(ng_image_make_mips(&image));
    OK(ng_assets_take_image(r->s.assets, "checks", &image, &id));
    return id;
}

// A textured quad that a clip moves, and a textured lamp in front of it.
static void open_assets(struct room_of_assets *r)
{
    struct scene *s = &r->s;
    scene_open(s, 2);
    r->image = take_checks(r, 4);
    r->light_image = take_checks(r, 8);
    ng_entity material = scene_material(s, (const float[3]){0.8f, 0.8f, 0.8f}, 0, 0.5f);
    ((struct ng_material *)ng_world_edit(s->world, material, NG_MATERIAL))->base_color_texture = r->image;
    r->quad = scene_quad(s, (const float[3]){-1.5f, -1.5f, 0}, (const float[3]){3, 0, 0},
                         (const float[3]){0, 3, 0}, material);
    r->geometry = ((const struct ng_mesh *)ng_world_get(s->world, r->quad, NG_MESH))->geometry;
    const struct ng_light_rectangle lamp = {
        .on = true, .color = {1, 1, 1}, .radiance = 3, .size = {1, 1}, .texture = r->light_image};
    scene_light(s, NG_LIGHT_RECTANGLE, &lamp, (const float[3]){0.2f, 0.3f, 1.5f}, NULL);

    const float times[2] = {0, 1}, values[6] = {0.1f, 0, 0, 0.5f, 0.5f, 0};
    struct ng_channel channel = {.target = r->quad,
                                 .component = NG_TRANSFORM,
                                 .field_offset = offsetof(struct ng_transform, translation),
                                 .width = 3,
                                 .interpolation = NG_INTERPOLATION_LINEAR,
                                 .key_count = 2,
                                 .times = copy_of(times, sizeof times),
                                 .values = copy_of(values, sizeof values)};
    struct ng_clip clip = {.channel_count = 1, .channels = copy_of(&channel, sizeof channel), .duration = 1};
    OK(ng_assets_take_clip(s->assets, "clip", &clip, &r->clip));
    ng_entity player = ng_entity_create(s->world);
    OK(ng_world_add(s->world, player, NG_ANIMATION,
                    &(struct ng_animation){.clip = r->clip, .playing = true, .speed = 1, .weight = 1}));
}

static void edit_points(struct room_of_assets *r)
{
    float *points = ng_assets_edit_points(r->s.assets, r->geometry);
    assert_non_null(points);
    points[2] += 0.6f;
    points[0] -= 0.4f;
    OK(ng_assets_changed(r->s.assets, r->geometry));
}

static void edit_topology(struct room_of_assets *r)
{
    const float positions[15] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 0.5f};
    const uint32_t indices[12] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
    struct ng_geometry g = {.vertex_count = 5,
                            .index_count = 12,
                            .positions = copy_of(positions, sizeof positions),
                            .indices = copy_of(indices, sizeof indices)};
    OK(ng_geometry_complete(&g));
    OK(ng_assets_replace_geometry(r->s.assets, r->geometry, &g));
}

static void edit_texels(struct room_of_assets *r)
{
    unsigned char *texels = ng_assets_edit_texels(r->s.assets, r->image);
    assert_non_null(texels);
    memset(texels, 90, 4 * 4 * 4 / 2);
    OK(ng_assets_changed(r->s.assets, r->image));
}

static void edit_size(struct room_of_assets *r)
{
    struct ng_image image = checks(16, 30);
    OK(ng_assets_replace_image(r->s.assets, r->image, &image));
}

static void edit_lamp(struct room_of_assets *r)
{
    unsigned char *texels = ng_assets_edit_texels(r->s.assets, r->light_image);
    assert_non_null(texels);
    memset(texels, 20, 8 * 8 * 4 / 2);
    OK(ng_assets_changed(r->s.assets, r->light_image));
}

static void edit_keys(struct room_of_assets *r)
{
    struct ng_clip *clip = ng_assets_edit_clip(r->s.assets, r->clip);
    assert_non_null(clip);
    clip->channels[0].values[0] = -0.7f;
    OK(ng_assets_changed(r->s.assets, r->clip));
}

static void replace_keys(struct room_of_assets *r)
{
    struct ng_channel channel = ng_assets_clip(r->s.assets, r->clip)->channels[0];
    const float time = 0, value[3] = {0, -0.8f, 0.2f};
    channel.key_count = 1;
    channel.times = copy_of(&time, sizeof time);
    channel.values = copy_of(value, sizeof value);
    struct ng_clip clip = {.channel_count = 1, .channels = copy_of(&channel, sizeof channel)};
    OK(ng_assets_replace_clip(r->s.assets, r->clip, &clip));
}

static void remove_image(struct room_of_assets *r)
{
    assert_true(ng_assets_remove(r->s.assets, r->image));
}

static void remove_geometry(struct room_of_assets *r)
{
    assert_true(ng_assets_remove(r->s.assets, r->geometry));
}

// The picture of one who saw what was before, which is that of one who did not.
static struct picture look(struct room_of_assets *r, struct ng_gpu *gpu, struct ng_renderer *renderer)
{
    scene_frame(&r->s, 0);
    draw(gpu, renderer, r->s.snapshot, all, NG_COUNT(all));
    struct picture p = keep(renderer, all, NG_COUNT(all));
    struct picture fresh = draw_afresh(&r->s, gpu, all, NG_COUNT(all));
    assert_true(same(&p, &fresh));
    forget(&fresh);
    return p;
}

static void every_edit_is_drawn_as_if_it_had_always_been(void **state)
{
    struct ng_gpu *gpu = *state;
    void (*const edits[])(struct room_of_assets *) = {edit_points,  edit_topology, edit_texels,
                                                      edit_size,    edit_lamp,     edit_keys,
                                                      replace_keys, remove_image,  remove_geometry};
    for (size_t i = 0; i < NG_COUNT(edits); i++) {
        struct room_of_assets r;
        struct ng_renderer *renderer;
        struct test_log log;
        open_assets(&r);
        OK(ng_renderer_create(&(struct ng_renderer_params){.gpu = gpu, .jobs = r.s.jobs}, &renderer));
        test_log_begin(&log); // of a geometry that is missing
        struct picture pictures[5];
        pictures[0] = look(&r, gpu, renderer);
        OK(ng_world_begin(r.s.world, "cancelled"));
        edits[i](&r);
        scene_frame(&r.s, 0);
        OK(ng_world_cancel(r.s.world));
        pictures[1] = look(&r, gpu, renderer);
        OK(ng_world_begin(r.s.world, "edit"));
        edits[i](&r);
        OK(ng_world_commit(r.s.world));
        pictures[2] = look(&r, gpu, renderer);
        OK(ng_world_undo(r.s.world));
        pictures[3] = look(&r, gpu, renderer);
        OK(ng_world_redo(r.s.world));
        pictures[4] = look(&r, gpu, renderer);
        test_log_end(&log);
        if (!same(&pictures[0], &pictures[1]) || same(&pictures[0], &pictures[2]) ||
            !same(&pictures[0], &pictures[3]) || !same(&pictures[2], &pictures[4]))
            fail_msg("edit %zu is not seen, or not taken back", i);
        for (size_t k = 0; k < NG_COUNT(pictures); k++)
            forget(&pictures[k]);
        ng_renderer_destroy(&renderer);
        scene_close(&r.s);
    }
}

static int begin(void **state)
{
    *state = gpu_test_begin();
    return 0;
}

static int end(void **state)
{
    gpu_test_end(*state);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_dragged_vertex_of_a_cage_costs_its_points, begin, end),
        cmocka_unit_test_setup_teardown(a_dragged_vertex_of_a_geometry_costs_its_points, begin, end),
        cmocka_unit_test_setup_teardown(every_edit_is_drawn_as_if_it_had_always_been, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

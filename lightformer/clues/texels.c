// The reflective shadow map of a light: rays through the centres of its texels, or what the renderer drew.
// Both become the same texels. As engine/shaders/observe.frag.glsl, line by line.
#include "lightformer/clues/clues_internal.h"

#include "base/half.h"
#include "lightformer/trace/vec.h"
#include "shaders/shared/brdf.h"

#include <string.h>

#define SIDE        NG_RSM_SIZE
#define TEXELS      (SIDE * SIDE)
#define TILE        4    // texels a side of a packet
#define LEAST_SLANT 0.1f // cosine at which the area behind a texel stops growing

struct search {
    const struct lf_clues_scene *scene;
    struct lf_light_clues *light;
    bool thinned; // of four tiles one is traced, and stands for all of them
};

// ---- what the light sends --------------------------------------------------------------------------------

// VPLs that shine alike are one lobe: a flat emitter has one, whatever its size.
static void add_lobe(struct lf_light_clues *light, const float normal[3], const float weight[3])
{
    for (size_t i = 0; i < light->intensity.count; i++) {
        struct lf_intensity_lobe *lobe = &light->intensity.items[i];
        const float *n = lobe->normal;
        if (n[0] == normal[0] && n[1] == normal[1] && n[2] == normal[2]) {
            lf_mad(lobe->weight, weight, 1, lobe->weight);
            return;
        }
    }
    struct lf_intensity_lobe *lobe = &light->intensity.items[light->intensity.count++];
    memcpy(lobe->normal, normal, sizeof lobe->normal);
    memcpy(lobe->weight, weight, sizeof lobe->weight);
}

static ng_result find_intensity(struct lf_light_clues *light)
{
    size_t count = light->vpls.count;
    if (!lf_take(&light->memory[LF_LIGHT_RSM], &light->intensity, count))
        return ng_out_of_memory("the texels of a light");
    light->intensity.count = 0;
    for (size_t i = 0; i < count; i++) {
        const struct ng_light_sample *v = &light->vpls.items[i];
        float weight[3];
        if (!(v->pdf > 0) || !(light->phi > 0))
            continue;
        lf_scale(v->radiance, 1 / (v->pdf * (float)count * light->phi), weight);
        add_lobe(light, v->normal, weight);
    }
    return NG_OK;
}

// Toward a direction: share of the power per steradian; of lights at infinity per square metre.
static void intensity(const struct lf_light_clues *light, const float direction[3], float out[3])
{
    bool point = light->data.vpl_kind == NG_VPL_POINT;
    memset(out, 0, 3 * sizeof *out);
    for (size_t i = 0; i < light->intensity.count; i++) {
        const struct lf_intensity_lobe *lobe = &light->intensity.items[i];
        float cosine = point ? 1 : lf_dot(lobe->normal, direction);
        if (cosine > 0)
            lf_mad(out, lobe->weight, cosine, out);
    }
    float cone = lf_dot(light->data.look, direction) * light->data.cone_scale + light->data.cone_offset;
    cone = ng_clamp(cone, 0.0f, 1.0f);
    lf_scale(out, cone * cone, out);
}

// ---- texels ----------------------------------------------------------------------------------------------

// Solid angle of the rectangle from (0, 0) to (x, y) on the plane z = 1.
static float corner_angle(float x, float y)
{
    return atan2f(x * y, sqrtf(x * x + y * y + 1));
}

// What a texel is, before it is known what the light meets there.
struct aim {
    float origin[3], direction[3]; // world
    float far;
    float extent;   // solid angle, or area across the view in square metres
    float power[3]; // share of the power that leaves into it
};

static void aim_at(const struct lf_light_clues *light, const struct ng_light_view_data *v, uint32_t x,
                   uint32_t y, struct aim *out)
{
    float half = v->tangent / SIDE;
    float a = (((float)x + 0.5f) / SIDE * 2 - 1) * v->tangent,
          b = (((float)y + 0.5f) / SIDE * 2 - 1) * v->tangent;
    memcpy(out->origin, v->origin, sizeof out->origin);
    memcpy(out->direction, v->axis_z, sizeof out->direction);
    bool parallel = light->data.window_count > 0;
    float *moved = parallel ? out->origin : out->direction;
    lf_mad(moved, v->axis_x, a, moved);
    lf_mad(moved, v->axis_y, b, moved);
    if (parallel) {
        out->far = v->depth_range;
        out->extent = 4 * half * half;
    } else {
        lf_normalize(out->direction);
        out->far = INFINITY;
        out->extent = corner_angle(a + half, b + half) - corner_angle(a - half, b + half) -
                      corner_angle(a + half, b - half) + corner_angle(a - half, b - half);
    }
    intensity(light, out->direction, out->power);
    lf_scale(out->power, out->extent, out->power);
}

// Area of the surface behind a texel, in squared radii.
static float area_behind(const struct lf_light_clues *light, const struct aim *aim, const float position[3],
                         const float normal[3])
{
    float offset[3], square = 1, slant = fabsf(lf_dot(normal, aim->direction));
    if (!light->data.window_count) {
        lf_mad(position, aim->origin, -1, offset);
        square = lf_dot(offset, offset);
    }
    return aim->extent * square / (fmaxf(slant, LEAST_SLANT) * light->space.radius * light->space.radius);
}

static void set_texel(const struct search *search, const struct aim *aim, const struct lf_hit *hit,
                      struct lf_texel *out)
{
    struct lf_surface s;
    lf_surface_at(search->scene->tracer, hit, &s);
    if (lf_surface_is_black(&s))
        return; // it blocks light and reflects none
    float cosine = fmaxf(-lf_dot(s.normal, aim->direction), 0);
    lf_to_scene(&search->light->space, s.position, out->position);
    memcpy(out->normal, s.normal, sizeof out->normal);
    out->area = area_behind(search->light, aim, s.position, s.normal);
    for (int c = 0; c < 3; c++) {
        float reflectance = s.albedo[c] + ng_brdf_specular_albedo(cosine, s.f0[c], s.roughness);
        out->flux[c] = lf_finite(aim->power[c] * fminf(reflectance, 1));
    }
}

static void stand_for_four(struct lf_texel *texel)
{
    lf_scale(texel->flux, 4, texel->flux);
    texel->area *= 4;
}

static void trace_tile(const struct search *search, uint32_t view, uint32_t x0, uint32_t y0)
{
    struct lf_light_clues *light = search->light;
    struct lf_packet packet = {.passes = light->light};
    struct lf_hit hits[LF_PACKET];
    struct aim aims[LF_PACKET];
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        aim_at(light, &light->views[view], x0 + i % TILE, y0 + i / TILE, &aims[i]);
        for (int c = 0; c < 3; c++) {
            packet.origin[c][i] = aims[i].origin[c];
            packet.direction[c][i] = aims[i].direction[c];
        }
        packet.far[i] = lf_max3(aims[i].power) > 0 ? aims[i].far : 0;
    }
    lf_count_packet(search->scene, &packet);
    lf_trace_packet(search->scene->tracer, &packet, hits);
    for (uint32_t i = 0; i < LF_PACKET; i++) {
        struct lf_texel *texel = &light->texels.items[view * TEXELS + (y0 + i / TILE) * SIDE + x0 + i % TILE];
        *texel = (struct lf_texel){0};
        if (packet.met[i])
            set_texel(search, &aims[i], &hits[i], texel);
        if (search->thinned)
            stand_for_four(texel);
    }
}

static void trace_tiles(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    enum { ROW = SIDE / TILE, TILES = ROW * ROW };
    const struct search *search = user;
    for (uint32_t t = begin; t < end; t++) {
        uint32_t column = t % ROW, row = t / ROW % ROW;
        if (!search->thinned || (column % 2 == row / 2 % 2 && row % 2 == column / 2 % 2))
            trace_tile(search, t / TILES, column * TILE, row * TILE);
    }
}

// The renderer's maps hold W of the light as it is.
static void read_texel(const struct lf_light_clues *light, float power, size_t i, struct lf_texel *out)
{
    const struct lf_captured_light *maps = light->maps;
    struct aim aim;
    *out = (struct lf_texel){0};
    if (!(maps->position[4 * i + 3] > 0) || !(power > 0))
        return;
    aim_at(light, &light->views[i / TEXELS], (uint32_t)(i % SIDE), (uint32_t)(i % TEXELS / SIDE), &aim);
    for (size_t c = 0; c < 3; c++) {
        out->normal[c] = lf_finite(ng_half_to_float(maps->normal[4 * i + c]));
        out->flux[c] = lf_finite(maps->flux[4 * i + c] / power);
    }
    lf_to_scene(&light->space, &maps->position[4 * i], out->position);
    out->area = area_behind(light, &aim, &maps->position[4 * i], out->normal);
}

static bool is_row(const struct lf_texel *t)
{
    return lf_max3(t->flux) > 0;
}

// ---- rows ------------------------------------------------------------------------------------------------

static ng_result write_rows(struct lf_light_clues *light)
{
    uint32_t count = 0, vpls = light->vpl_count;
    for (size_t i = 0; i < light->texels.count; i++)
        count += is_row(&light->texels.items[i]);
    light->texel_count = count;
    if (!lf_take(&light->memory[LF_LIGHT_RSM], &light->rows, 12 * ((size_t)count + vpls)))
        return ng_out_of_memory("the texels of a light");
    float *rows = light->rows.items + (size_t)12 * vpls, proxy[3];
    lf_to_scene(&light->space, light->data.proxy, proxy);
    size_t n = count, row = 0;
    for (size_t i = 0; i < light->texels.count; i++) {
        const struct lf_texel *t = &light->texels.items[i];
        if (!is_row(t))
            continue;
        for (size_t c = 0; c < 3; c++) {
            rows[c * n + row] = t->position[c] - proxy[c];
            rows[(3 + c) * n + row] = t->position[c];
            rows[(6 + c) * n + row] = t->normal[c];
            rows[(9 + c) * n + row] = t->flux[c] * (float)count;
        }
        row++;
    }
    light->values.of[LF_INPUT_TEXEL_OFFSET] = rows;
    light->values.of[LF_INPUT_TEXEL_POSITION] = rows + 3 * n;
    light->values.of[LF_INPUT_TEXEL_NORMAL] = rows + 6 * n;
    light->values.of[LF_INPUT_TEXEL_FLUX] = rows + 9 * n;
    return NG_OK;
}

// ---- the second bounce -----------------------------------------------------------------------------------

// A block of texels as one source: the flux of all, at the texel with which half of it is found. False if
// there is none.
static bool find_source(const struct lf_light_clues *light, uint32_t view, uint32_t x0, uint32_t y0,
                        uint32_t side, struct lf_rsm_source *out)
{
    struct lf_rsm_source source = {.area = 0};
    const struct lf_texel *first = &light->texels.items[view * TEXELS + y0 * SIDE + x0], *middle = NULL;
    float found = 0;
    for (uint32_t i = 0; i < side * side; i++) {
        const struct lf_texel *t = &first[i / side * SIDE + i % side];
        lf_mad(source.flux, t->flux, 1, source.flux);
        source.area += is_row(t) ? t->area : 0;
    }
    float half = lf_mean(source.flux) / 2;
    for (uint32_t i = 0; i < side * side && (!middle || found < half); i++) {
        const struct lf_texel *t = &first[i / side * SIDE + i % side];
        found += lf_mean(t->flux);
        middle = is_row(t) ? t : middle;
    }
    if (!middle)
        return false;
    memcpy(source.position, middle->position, sizeof source.position);
    memcpy(source.normal, middle->normal, sizeof source.normal);
    *out = source;
    return true;
}

// Blocks of `side` texels each way. Returns how many are sources.
static uint32_t find_sources(const struct lf_light_clues *light, uint32_t side, struct lf_rsm_source *out)
{
    uint32_t blocks = SIDE / side, count = 0;
    for (uint32_t i = 0; i < light->view_count * blocks * blocks; i++)
        count += find_source(light, i / (blocks * blocks), i % blocks * side, i / blocks % blocks * side,
                             side, &out[count]);
    return count;
}

// 64 blocks of each view; 256 where there is one view alone. A quarter as many for where rays end, of which
// many are averaged.
static ng_result group_texels(struct lf_light_clues *light)
{
    uint32_t side = light->view_count > 1 ? 8 : 4, blocks = SIDE / side;
    size_t most = (size_t)light->view_count * blocks * blocks;
    struct lf_memory *memory = &light->memory[LF_LIGHT_RSM];
    if (!lf_take(memory, &light->sources, most) || !lf_take(memory, &light->sources_of_hits, most / 4))
        return ng_out_of_memory("the texels of a light");
    light->sources.count = find_sources(light, side, light->sources.items);
    light->sources_of_hits.count = find_sources(light, 2 * side, light->sources_of_hits.items);
    return NG_OK;
}

ng_result lf_texels_find(const struct lf_clues_scene *scene, struct lf_light_clues *light)
{
    struct search search = {.scene = scene, .light = light, .thinned = light->questions == LF_ASK_FEW};
    NG_TRY(find_intensity(light));
    if (!lf_take(&light->memory[LF_LIGHT_RSM], &light->texels, (size_t)light->view_count * TEXELS))
        return ng_out_of_memory("the texels of a light");
    float power = ng_light_power(&lf_tracer_snapshot(scene->tracer)->lights[light->light].source);
    if (light->maps)
        for (size_t i = 0; i < light->texels.count; i++)
            read_texel(light, power, i, &light->texels.items[i]);
    else {
        memset(light->texels.items, 0, light->texels.count * sizeof *light->texels.items);
        ng_jobs_for(scene->jobs, light->view_count * TEXELS / LF_PACKET, 8, trace_tiles, &search);
    }
    NG_TRY(write_rows(light));
    return group_texels(light);
}

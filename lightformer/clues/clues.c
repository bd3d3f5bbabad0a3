// The objects behind clues.h: where values lie and in which order they are computed.
#include "lightformer/clues/clues_internal.h"

#include "base/system.h"
#include "lightformer/trace/vec.h"
#include "render/light_gpu.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

const char *const lf_encode_stage_names[LF_ENCODE_STAGES] = {"pixels", "mirror",   "texels",     "occluders",
                                                             "direct", "reach",    "highlights", "bounce",
                                                             "around", "reflected"};

// ---- objects ---------------------------------------------------------------------------------------------

ng_result lf_pixel_clues_create(struct lf_pixel_clues **out)
{
    *out = calloc(1, sizeof **out);
    return *out ? NG_OK : ng_out_of_memory("the inputs of a picture");
}

void lf_pixel_clues_destroy(struct lf_pixel_clues **clues)
{
    struct lf_pixel_clues *p = *clues;
    *clues = NULL;
    if (!p)
        return;
    ng_array_finish(&p->memory.list);
    ng_array_finish(&p->grid_taps);
    ng_array_finish(&p->alone);
    ng_array_finish(&p->reflections.kinds);
    for (int i = 0; i < LF_MIRROR_KINDS; i++)
        ng_array_finish(&p->reflections.lattices[i].hit_at);
    ng_array_finish(&p->reflections.hits);
    ng_array_finish(&p->reflections.rays);
    ng_array_finish(&p->reflections.taps);
    ng_array_finish(&p->reflections.wide);
    ng_array_finish(&p->reflections.sights);
    ng_array_finish(&p->reflections.seen.list);
    ng_array_finish(&p->around.ends);
    ng_array_finish(&p->around.weights);
    free(p);
}

ng_result lf_light_clues_create(struct lf_light_clues **out)
{
    *out = calloc(1, sizeof **out);
    return *out ? NG_OK : ng_out_of_memory("the inputs of a light");
}

void lf_light_clues_destroy(struct lf_light_clues **clues)
{
    struct lf_light_clues *l = *clues;
    *clues = NULL;
    if (!l)
        return;
    ng_array_finish(&l->vpls);
    ng_array_finish(&l->intensity);
    ng_array_finish(&l->texels);
    ng_array_finish(&l->sources);
    ng_array_finish(&l->rows.list);
    ng_array_finish(&l->view.list);
    ng_array_finish(&l->grid.list);
    ng_array_finish(&l->reflected.list);
    ng_array_finish(&l->around.list);
    free(l);
}

struct lf_view_memory {
    struct lf_floats floats;
};

ng_result lf_view_memory_create(struct lf_view_memory **out)
{
    *out = calloc(1, sizeof **out);
    return *out ? NG_OK : ng_out_of_memory("the view of a light");
}

void lf_view_memory_destroy(struct lf_view_memory **memory)
{
    if (*memory)
        ng_array_finish(&(*memory)->floats.list);
    free(*memory);
    *memory = NULL;
}

const struct lf_net_values *lf_pixel_clues_values(const struct lf_pixel_clues *clues)
{
    return &clues->values;
}

const struct lf_net_values *lf_light_clues_values(const struct lf_light_clues *clues)
{
    return &clues->values;
}

uint32_t lf_light_clues_vpls(const struct lf_light_clues *clues)
{
    return clues->vpl_count;
}

uint32_t lf_light_clues_texels(const struct lf_light_clues *clues)
{
    return clues->texel_count;
}

uint32_t lf_light_clues_light(const struct lf_light_clues *clues)
{
    return clues->light;
}

void lf_light_clues_follow(struct lf_light_clues *clues, const struct ng_snapshot *snapshot, uint32_t light)
{
    clues->light = clues->data.index = light;
    ng_light_unit(&snapshot->lights[light].source, &clues->unit);
}

double lf_pixel_clues_ms(const struct lf_pixel_clues *clues, enum lf_encode_stage stage)
{
    return clues->ms[stage];
}

double lf_light_clues_ms(const struct lf_light_clues *clues, enum lf_encode_stage stage)
{
    return clues->ms[stage];
}

double lf_encode_lap(uint64_t *begin)
{
    uint64_t now = ng_clock_ns();
    double ms = (double)(now - *begin) * 1e-6;
    *begin = now;
    return ms;
}

// ---- powers ----------------------------------------------------------------------------------------------

static void set_frame(const struct ng_snapshot *snapshot, struct lf_pixel_clues *p)
{
    double sum = 0, square = (double)p->space.radius * (double)p->space.radius;
    uint32_t shining = 0;
    for (uint32_t i = 0; i < snapshot->light_count; i++) {
        float power = ng_light_power(&snapshot->lights[i].source);
        sum += (double)power;
        shining += power > 0;
    }
    p->radiance = lf_finite((float)(sum / square));
    p->mean_power = shining ? p->radiance / (float)shining : 0;
    p->values.of[LF_INPUT_FRAME_RADIANCE] = &p->radiance;
    p->values.of[LF_INPUT_FRAME_MEAN_POWER] = &p->mean_power;
    if (!p->emits)
        return;
    size_t count = (size_t)3 * p->width * p->height;
    for (size_t i = 0; i < count; i++)
        p->mirror_emission[0][i] = p->radiance > 0 ? lf_finite(p->emission[0][i] / p->radiance) : 0;
}

static void set_light(const struct ng_snapshot *snapshot, float radiance, struct lf_light_clues *l)
{
    const struct ng_light_source *source = &snapshot->lights[l->light].source;
    float square = l->space.radius * l->space.radius;
    ng_light_power_rgb(source, l->power);
    lf_scale(l->power, 1 / square, l->power);
    l->share = radiance > 0 ? lf_mean(l->power) / radiance : 0;
    l->values.of[LF_INPUT_LIGHT_POWER] = l->power;
    l->values.of[LF_INPUT_LIGHT_SHARE] = &l->share;
}

void lf_encode_powers(const struct ng_snapshot *snapshot, struct lf_pixel_clues *pixels,
                      struct lf_light_clues *const *lights, uint32_t light_count)
{
    set_frame(snapshot, pixels);
    for (uint32_t i = 0; i < light_count; i++)
        set_light(snapshot, pixels->radiance, lights[i]);
}

// ---- pixels ----------------------------------------------------------------------------------------------

ng_result lf_encode_pixels(const struct lf_encode_scene *scene, const struct lf_encode_pixels_params *params,
                           struct lf_pixel_clues *out)
{
    NG_REQUIRE(params->width && params->height, "a picture has pixels");
    uint64_t begin = ng_clock_ns();
    uint64_t pixels = (uint64_t)params->width * params->height;
    uint32_t budget = (uint32_t)lf_mirror_budget(pixels, params->mirror_rays);
    NG_TRY(lf_pixels_read(scene, params, out));
    out->ms[LF_ENCODE_PIXELS] = lf_encode_lap(&begin);
    NG_TRY(lf_mirror_cast(scene, budget, out));
    out->ms[LF_ENCODE_MIRROR] = lf_encode_lap(&begin);
    NG_TRY(lf_around_cast(scene, out));
    out->ms[LF_ENCODE_AROUND] = lf_encode_lap(&begin);
    set_frame(lf_tracer_snapshot(scene->tracer), out);
    return NG_OK;
}

// ---- a light ---------------------------------------------------------------------------------------------

// As the renderer observes it, at unit brightness: a snapshot of this light alone.
static void observe(const struct ng_snapshot *snapshot, struct lf_light_clues *out)
{
    struct ng_snapshot_light light = snapshot->lights[out->light];
    struct ng_snapshot alone = *snapshot;
    struct ng_light_gpu gpu;
    light.source = out->unit;
    alone.lights = &light;
    alone.light_count = 1;
    ng_light_gpu_observe(&alone, 0, 1, INFINITY, &gpu);
    out->data = gpu.data;
    out->data.index = out->light;
    out->view_count = gpu.rsm_view_count;
    memcpy(out->views, gpu.rsm_views, sizeof out->views);
}

static ng_result find_vpls(uint32_t count, struct lf_light_clues *out)
{
    out->vpl_count = out->unit.type->delta ? 1 : count;
    if (!ng_array_resize(&out->vpls, out->vpl_count))
        return ng_out_of_memory("the direct VPLs of a light");
    ng_light_vpls(&out->unit, out->vpl_count, out->vpls.items);
    return NG_OK;
}

static void write_vpls(struct lf_light_clues *l)
{
    float *rows = l->rows.list.items, proxy[3], scale = l->phi > 0 ? 1 / l->phi : 0;
    size_t n = l->vpl_count;
    lf_to_scene(&l->space, l->data.proxy, proxy);
    for (size_t i = 0; i < n; i++) {
        const struct ng_light_sample *v = &l->vpls.items[i];
        float position[3];
        lf_to_scene(&l->space, v->position, position);
        for (size_t c = 0; c < 3; c++) {
            rows[c * n + i] = position[c] - proxy[c];
            rows[(3 + c) * n + i] = position[c];
            rows[(6 + c) * n + i] = v->normal[c];
            rows[(9 + c) * n + i] = v->power[c] * scale;
        }
    }
    l->values.of[LF_INPUT_VPL_OFFSET] = rows;
    l->values.of[LF_INPUT_VPL_POSITION] = rows + 3 * n;
    l->values.of[LF_INPUT_VPL_NORMAL] = rows + 6 * n;
    l->values.of[LF_INPUT_VPL_POWER] = rows + 9 * n;
}

static void write_light(struct lf_light_clues *l)
{
    ng_light_power_rgb(&l->unit, l->color);
    for (int c = 0; c < 3; c++) {
        l->color[c] = l->phi > 0 ? l->color[c] / l->phi : 0;
        l->kind[c] = (uint32_t)c == l->data.vpl_kind;
    }
    l->values.of[LF_INPUT_LIGHT_COLOR] = l->color;
    l->values.of[LF_INPUT_LIGHT_KIND] = l->kind;
}

ng_result lf_encode_light(const struct lf_encode_scene *scene, uint32_t light,
                          const struct lf_encode_light_params *params, struct lf_light_clues *out)
{
    const struct ng_snapshot *snapshot = lf_tracer_snapshot(scene->tracer);
    NG_REQUIRE(light < snapshot->light_count, "the light is one of the snapshot's");
    uint64_t begin = ng_clock_ns();
    uint32_t count = params && params->vpl_count ? params->vpl_count : LF_VPL_COUNT;
    out->light = light;
    out->maps = params ? params->maps : NULL;
    out->space = lf_space_of(snapshot);
    memset(&out->values, 0, sizeof out->values);
    ng_light_unit(&snapshot->lights[light].source, &out->unit);
    out->phi = ng_light_power(&out->unit);
    observe(snapshot, out);
    const float *proxy = out->data.proxy;
    out->skin = ng_light_skin(out->space.radius, proxy[0], proxy[1], proxy[2]) + snapshot->place_size;
    NG_TRY(find_vpls(count, out));
    lf_shape_make(out);
    NG_TRY(lf_texels_find(scene, out));
    write_vpls(out);
    write_light(out);
    set_light(snapshot, 0, out);
    out->ms[LF_ENCODE_TEXELS] = lf_encode_lap(&begin);
    return NG_OK;
}

// ---- a light on screen -----------------------------------------------------------------------------------

struct view_planes {
    float *way[5]; // direction, distance, occluder
    float *diffuse[3], *glossy[3], *bounce[3], *mirror[3], *mirror_bounce[3];
    float *diffuse_reached[1], *glossy_reached[1], *gathered[3];
    float *rays[3]; // struct lf_block_rays
};

static bool wants_reached(const struct lf_encode_scene *s)
{
    return lf_encode_wants(s, LF_INPUT_VIEW_DIFFUSE_REACHED) ||
           lf_encode_wants(s, LF_INPUT_VIEW_GLOSSY_REACHED);
}

static bool wants_way(const struct lf_encode_scene *s)
{
    return lf_encode_wants(s, LF_INPUT_VIEW_DIRECTION) || lf_encode_wants(s, LF_INPUT_VIEW_DISTANCE) ||
           lf_encode_wants(s, LF_INPUT_VIEW_OCCLUDER) || wants_reached(s);
}

static bool wants_direct(const struct lf_encode_scene *s)
{
    return lf_encode_wants(s, LF_INPUT_VIEW_DIFFUSE) || lf_encode_wants(s, LF_INPUT_VIEW_GLOSSY) ||
           lf_encode_wants(s, LF_INPUT_VIEW_GLOSSY_REACHED);
}

static bool wants_mirror(const struct lf_encode_scene *s)
{
    return lf_encode_wants(s, LF_INPUT_VIEW_MIRROR) || lf_encode_wants(s, LF_INPUT_VIEW_MIRROR_BOUNCE);
}

static ng_result lay_out(const struct lf_encode_scene *scene, size_t count, struct lf_light_clues *l,
                         struct view_planes *out)
{
    struct lf_floats *memory = scene->view ? &scene->view->floats : &l->view;
    if (!ng_array_resize(&memory->list, LF_VIEW_PLANES * (count + LF_PLANE_GAP)))
        return ng_out_of_memory("the view of a light");
    l->pixel_count = count;
    float *next = memory->list.items;
    const struct {
        float **planes;
        int channels;
    } parts[] = {
        {out->way, 5},    {out->diffuse, 3},       {out->glossy, 3},          {out->bounce, 3},
        {out->mirror, 3}, {out->mirror_bounce, 3}, {out->diffuse_reached, 1}, {out->glossy_reached, 1},
        {out->rays, 3},   {out->gathered, 3},
    };
    for (size_t i = 0; i < NG_COUNT(parts); i++, next += LF_PLANE_GAP)
        for (int c = 0; c < parts[i].channels; c++, next += count)
            parts[i].planes[c] = next;
    assert(next == memory->list.items + LF_VIEW_PLANES * count + NG_COUNT(parts) * LF_PLANE_GAP);
    const struct {
        enum lf_net_input input;
        const float *plane;
    } inputs[] = {
        {LF_INPUT_VIEW_DIRECTION, out->way[0]},
        {LF_INPUT_VIEW_DISTANCE, out->way[3]},
        {LF_INPUT_VIEW_OCCLUDER, out->way[4]},
        {LF_INPUT_VIEW_DIFFUSE, out->diffuse[0]},
        {LF_INPUT_VIEW_GLOSSY, out->glossy[0]},
        {LF_INPUT_VIEW_BOUNCE, out->bounce[0]},
        {LF_INPUT_VIEW_MIRROR, out->mirror[0]},
        {LF_INPUT_VIEW_MIRROR_BOUNCE, out->mirror_bounce[0]},
        {LF_INPUT_VIEW_GLOSSY_REACHED, out->glossy_reached[0]},
        {LF_INPUT_VIEW_GATHERED, out->gathered[0]},
        {LF_INPUT_VIEW_DIFFUSE_REACHED, out->diffuse_reached[0]},
    };
    for (size_t i = 0; i < NG_COUNT(inputs); i++)
        l->values.of[inputs[i].input] = lf_encode_wants(scene, inputs[i].input) ? inputs[i].plane : NULL;
    return NG_OK;
}

ng_result lf_encode_view(const struct lf_encode_scene *scene, const struct lf_pixel_clues *pixels,
                         struct lf_light_clues *light)
{
    struct view_planes planes;
    uint64_t begin = ng_clock_ns();
    NG_TRY(lay_out(scene, (size_t)pixels->width * pixels->height, light, &planes));
    const struct lf_block_rays rays = {planes.rays[0], planes.rays[1], planes.rays[2]};
    if (wants_way(scene))
        lf_occluders_find(scene, pixels, light, planes.way);
    light->ms[LF_ENCODE_OCCLUDERS] = lf_encode_lap(&begin);
    if (wants_direct(scene))
        lf_direct_view(scene, pixels, light, planes.diffuse, planes.glossy);
    light->ms[LF_ENCODE_DIRECT] = lf_encode_lap(&begin);
    if (wants_reached(scene))
        lf_reach_find(scene, pixels, light, planes.way, &rays, planes.diffuse_reached[0]);
    light->ms[LF_ENCODE_REACH] = lf_encode_lap(&begin);
    if (lf_encode_wants(scene, LF_INPUT_VIEW_GLOSSY_REACHED))
        lf_highlights_find(scene, pixels, light, planes.glossy, planes.diffuse_reached[0], &rays,
                           planes.glossy_reached[0]);
    light->ms[LF_ENCODE_HIGHLIGHTS] = lf_encode_lap(&begin);
    if (lf_encode_wants(scene, LF_INPUT_VIEW_BOUNCE))
        NG_TRY(lf_bounce_view(scene, pixels, light, planes.bounce));
    light->ms[LF_ENCODE_BOUNCE] = lf_encode_lap(&begin);
    if (lf_encode_wants(scene, LF_INPUT_VIEW_GATHERED))
        NG_TRY(lf_around_light(scene, pixels, light, planes.gathered));
    light->ms[LF_ENCODE_AROUND] = lf_encode_lap(&begin);
    if (wants_mirror(scene))
        NG_TRY(lf_mirror_light(scene, pixels, light, planes.mirror, planes.mirror_bounce));
    light->ms[LF_ENCODE_REFLECTED] = lf_encode_lap(&begin);
    return NG_OK;
}

ng_result lf_light_clues_keep(struct lf_light_clues *light, uint64_t set)
{
    size_t count = light->pixel_count, kept = 0;
    for (int i = 0; i < LF_INPUT_COUNT; i++)
        if (lf_net_inputs[i].domain == LF_DOMAIN_VIEW && light->values.of[i] && set >> i & 1)
            kept += lf_net_inputs[i].channels * count;
    if (!ng_array_resize(&light->view.list, kept))
        return ng_out_of_memory("the view of a light");
    float *next = light->view.list.items;
    for (int i = 0; i < LF_INPUT_COUNT; i++) {
        const float *from = light->values.of[i];
        if (lf_net_inputs[i].domain != LF_DOMAIN_VIEW || !from)
            continue;
        light->values.of[i] = set >> i & 1 ? next : NULL;
        if (!(set >> i & 1))
            continue;
        memcpy(next, from, lf_net_inputs[i].channels * count * sizeof *next);
        next += lf_net_inputs[i].channels * count;
    }
    return NG_OK;
}

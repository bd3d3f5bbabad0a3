// The objects behind clues.h: where values lie and in which order they are computed.
#include "lightformer/clues/clues_internal.h"

#include "base/system.h"
#include "lightformer/trace/vec.h"
#include "render/light_gpu.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#define HIGHLIGHTS 0.25f // how much specular lobes count in frame.radiance

const char *const lf_clues_stage_names[LF_CLUES_STAGES] = {
    "pixels",     "reflection_rays",     "texels",     "shadow_distance",   "direct",
    "visibility", "specular_visibility", "rsm_gather", "hemisphere_gather", "reflected_light",
    "arriving"};

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
    for (int i = 0; i < LF_PIXEL_PARTS; i++)
        lf_memory_finish(&p->memory[i]);
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
    for (int i = 0; i < LF_LIGHT_PARTS; i++)
        lf_memory_finish(&l->memory[i]);
    free(l);
}

void lf_pixel_clues_lend(struct lf_pixel_clues *clues, enum lf_pixel_part part, void *data, uint64_t size)
{
    lf_memory_lend(&clues->memory[part], data, size);
}

void lf_light_clues_lend(struct lf_light_clues *clues, enum lf_light_part part, void *data, uint64_t size)
{
    lf_memory_lend(&clues->memory[part], data, size);
}

const struct lf_net_values *lf_pixel_clues_values(const struct lf_pixel_clues *clues)
{
    return &clues->values;
}

const struct lf_net_values *lf_light_clues_values(const struct lf_light_clues *clues)
{
    return &clues->values;
}

const struct lf_net_values *lf_light_clues_kept(const struct lf_light_clues *clues)
{
    return &clues->kept;
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

double lf_pixel_clues_ms(const struct lf_pixel_clues *clues, enum lf_clues_stage stage)
{
    return clues->ms[stage];
}

double lf_light_clues_ms(const struct lf_light_clues *clues, enum lf_clues_stage stage)
{
    return clues->ms[stage];
}

double lf_clues_lap(uint64_t *begin)
{
    uint64_t now = ng_clock_ns();
    double ms = (double)(now - *begin) * 1e-6;
    *begin = now;
    return ms;
}

// ---- normalization ---------------------------------------------------------------------------------------

static void set_frame(const struct ng_snapshot *snapshot, struct lf_pixel_clues *p)
{
    double radius = (double)lf_space_of(snapshot).radius, sum = 0, square = radius * radius;
    uint32_t active = 0;
    for (uint32_t i = 0; i < snapshot->light_count; i++) {
        float phi = ng_light_power(&snapshot->lights[i].source);
        sum += (double)phi;
        active += phi > 0;
    }
    float power = lf_finite((float)(sum / square));
    p->mean_power = active ? power / (float)active : 0;
    p->values.of[LF_INPUT_FRAME_RADIANCE] = &p->radiance;
    p->values.of[LF_INPUT_FRAME_MEAN_POWER] = &p->mean_power;
}

static void set_light(const struct ng_snapshot *snapshot, struct lf_light_clues *l)
{
    const struct ng_light_source *source = &snapshot->lights[l->light].source;
    float radius = lf_space_of(snapshot).radius, square = radius * radius;
    ng_light_power_rgb(source, l->power);
    lf_scale(l->power, 1 / square, l->power);
}

void lf_clues_set_unit(struct lf_pixel_clues *p, float unit, struct lf_light_clues *const *lights,
                       uint32_t light_count)
{
    p->radiance = lf_finite(unit);
    for (uint32_t i = 0; i < light_count; i++)
        lights[i]->share = p->radiance > 0 ? lf_finite(lf_mean(lights[i]->power) / p->radiance) : 0;
}

void lf_clues_set_powers(const struct ng_snapshot *snapshot, struct lf_pixel_clues *pixels,
                         struct lf_light_clues *const *lights, uint32_t light_count)
{
    set_frame(snapshot, pixels);
    for (uint32_t i = 0; i < light_count; i++)
        set_light(snapshot, lights[i]);
    lf_clues_set_unit(pixels, pixels->radiance, lights, light_count);
}

// ---- pixels ----------------------------------------------------------------------------------------------

// Notes what a part of the work took; gives up the rest if nobody wants it any more.
static ng_result end_part(const struct lf_clues_scene *scene, uint64_t *begin, double *ms)
{
    *ms = lf_clues_lap(begin);
    return scene->abandon && scene->abandon(scene->abandon_user) ? NG_ABANDONED : NG_OK;
}

ng_result lf_clues_pixels(const struct lf_clues_scene *scene, const struct lf_clues_pixels_params *params,
                          struct lf_pixel_clues *out)
{
    NG_REQUIRE(params->width && params->height, "a picture has pixels");
    uint64_t begin = ng_clock_ns();
    uint64_t pixels = (uint64_t)params->width * params->height;
    uint32_t budget = (uint32_t)lf_reflection_budget(pixels, params->reflection_rays);
    NG_TRY(lf_pixels_read(scene, params, out));
    float focal = lf_finite((float)out->height / (2 * tanf(out->eye.fov_y / 2)));
    NG_TRY(end_part(scene, &begin, &out->ms[LF_CLUES_PIXELS]));
    NG_TRY(lf_reflections_cast(scene, focal, budget, out));
    NG_TRY(end_part(scene, &begin, &out->ms[LF_CLUES_REFLECTION_RAYS]));
    NG_TRY(lf_hemisphere_cast(scene, focal, out));
    NG_TRY(end_part(scene, &begin, &out->ms[LF_CLUES_HEMISPHERE_GATHER]));
    set_frame(lf_tracer_snapshot(scene->tracer), out);
    return NG_OK;
}

// ---- a light ---------------------------------------------------------------------------------------------

static void find_views(const struct ng_snapshot *snapshot, const struct ng_light_gpu *observed,
                       struct lf_light_clues *out)
{
    struct ng_light_gpu own;
    if (!observed)
        ng_light_gpu_observe(snapshot, out->light, &out->unit, 1, INFINITY, &own);
    const struct ng_light_gpu *gpu = observed ? observed : &own;
    out->data = gpu->data;
    out->view_count = gpu->rsm_view_count;
    memcpy(out->views, gpu->rsm_views, sizeof out->views);
}

static ng_result find_vpls(uint32_t count, struct lf_light_clues *out)
{
    out->vpl_count = out->unit.type->delta ? 1 : count;
    if (!lf_take(&out->memory[LF_LIGHT_RSM], &out->vpls, out->vpl_count))
        return ng_out_of_memory("the direct VPLs of a light");
    ng_light_vpls(&out->unit, out->vpl_count, out->vpls.items);
    return NG_OK;
}

static void write_vpls(struct lf_light_clues *l)
{
    float *rows = l->rows.items, proxy[3], scale = l->phi > 0 ? 1 / l->phi : 0;
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
    l->values.of[LF_INPUT_LIGHT_POWER] = l->power;
    l->values.of[LF_INPUT_LIGHT_SHARE] = &l->share;
    l->values.of[LF_INPUT_LIGHT_COLOR] = l->color;
    l->values.of[LF_INPUT_LIGHT_KIND] = l->kind;
}

ng_result lf_clues_light(const struct lf_clues_scene *scene, uint32_t light,
                         const struct lf_clues_light_params *params, struct lf_light_clues *out)
{
    const struct ng_snapshot *snapshot = lf_tracer_snapshot(scene->tracer);
    NG_REQUIRE(light < snapshot->light_count, "the light is one of the snapshot's");
    uint64_t begin = ng_clock_ns();
    uint32_t count = params && params->vpl_count ? params->vpl_count : LF_VPL_COUNT;
    out->light = light;
    out->maps = params ? params->maps : NULL;
    out->questions = lf_questions_of(snapshot->light_count);
    out->space = lf_space_of(snapshot);
    memset(&out->values, 0, sizeof out->values);
    ng_light_unit(&snapshot->lights[light].source, &out->unit);
    out->phi = ng_light_power(&out->unit);
    find_views(snapshot, params ? params->observed : NULL, out);
    const float *proxy = out->data.proxy;
    out->skin = ng_light_skin(out->space.radius, proxy[0], proxy[1], proxy[2]) + snapshot->place_size;
    NG_TRY(lf_memory_begin(&out->memory[LF_LIGHT_RSM], lf_clues_rsm_bytes(count, out->view_count),
                           "the texels of a light"));
    NG_TRY(find_vpls(count, out));
    lf_emitter_make(out);
    NG_TRY(lf_texels_find(scene, out));
    write_vpls(out);
    write_light(out);
    out->ms[LF_CLUES_TEXELS] = lf_clues_lap(&begin);
    return NG_OK;
}

// ---- a light on screen -----------------------------------------------------------------------------------

struct view_planes {
    float *shadow[5]; // direction, distance, shadow distance
    float *diffuse[3], *glossy[3], *irradiance_rsm[3];
    float *visibility_diffuse[1], *visibility_specular[1];
    float *rays[3]; // struct lf_interleaved
};

static bool wants_visibility(const struct lf_clues_scene *s)
{
    return lf_clues_wants(s, LF_INPUT_VIEW_VISIBILITY_DIFFUSE) ||
           lf_clues_wants(s, LF_INPUT_VIEW_VISIBILITY_SPECULAR);
}

// The light's part of frame.radiance, at unit power: what pixels show of it, but for what is indirect.
// Highlights, which a few pixels may have most of, count little; of metals there is nothing else.
static float mean_reaching(const struct lf_clues_scene *scene, const struct lf_pixel_clues *p,
                           const struct view_planes *planes)
{
    bool diffuse = wants_visibility(scene),
         specular = lf_clues_wants(scene, LF_INPUT_VIEW_VISIBILITY_SPECULAR);
    float *rows = planes->rays[0];
    return lf_mean_shown(scene, p, planes->diffuse, diffuse ? planes->visibility_diffuse[0] : NULL, rows) +
           HIGHLIGHTS * lf_mean_shown(scene, p, planes->glossy,
                                      specular ? planes->visibility_specular[0] : NULL, rows);
}

// All there is to the visibility of a light without extent is one distance.
static bool wants_shadow(const struct lf_clues_scene *s, const struct lf_light_clues *light)
{
    return lf_clues_wants(s, LF_INPUT_VIEW_DIRECTION) || lf_clues_wants(s, LF_INPUT_VIEW_DISTANCE) ||
           lf_clues_wants(s, LF_INPUT_VIEW_SHADOW_DISTANCE) ||
           (light->unit.type->delta && wants_visibility(s));
}

static bool wants_direct(const struct lf_clues_scene *s)
{
    return lf_clues_wants(s, LF_INPUT_VIEW_DIFFUSE) || lf_clues_wants(s, LF_INPUT_VIEW_GLOSSY) ||
           lf_clues_wants(s, LF_INPUT_VIEW_VISIBILITY_SPECULAR);
}

static ng_result lay_out(const struct lf_clues_scene *scene, size_t count, struct lf_light_clues *l,
                         struct view_planes *out)
{
    LF_PART(float) all;
    if (!lf_take(&l->memory[LF_LIGHT_VIEW], &all, LF_VIEW_PLANES * (count + LF_PLANE_GAP)))
        return ng_out_of_memory("the view of a light");
    l->pixel_count = count;
    float *next = all.items;
    const struct {
        float **planes;
        int channels;
    } parts[] = {
        {out->shadow, 5},
        {out->diffuse, 3},
        {out->glossy, 3},
        {out->irradiance_rsm, 3},
        {out->visibility_diffuse, 1},
        {out->visibility_specular, 1},
        {out->rays, 3},
    };
    for (size_t i = 0; i < NG_COUNT(parts); i++, next += LF_PLANE_GAP)
        for (int c = 0; c < parts[i].channels; c++, next += count)
            parts[i].planes[c] = next;
    assert(next == all.items + LF_VIEW_PLANES * count + NG_COUNT(parts) * LF_PLANE_GAP);
    const struct {
        enum lf_net_input input;
        const float *plane;
    } inputs[] = {
        {LF_INPUT_VIEW_DIRECTION, out->shadow[0]},
        {LF_INPUT_VIEW_DISTANCE, out->shadow[3]},
        {LF_INPUT_VIEW_SHADOW_DISTANCE, out->shadow[4]},
        {LF_INPUT_VIEW_DIFFUSE, out->diffuse[0]},
        {LF_INPUT_VIEW_GLOSSY, out->glossy[0]},
        {LF_INPUT_VIEW_IRRADIANCE_RSM, out->irradiance_rsm[0]},
        {LF_INPUT_VIEW_VISIBILITY_SPECULAR, out->visibility_specular[0]},
        {LF_INPUT_VIEW_VISIBILITY_DIFFUSE, out->visibility_diffuse[0]},
    };
    for (size_t i = 0; i < NG_COUNT(inputs); i++)
        l->values.of[inputs[i].input] = lf_clues_wants(scene, inputs[i].input) ? inputs[i].plane : NULL;
    return NG_OK;
}

ng_result lf_clues_view(const struct lf_clues_scene *scene, const struct lf_pixel_clues *pixels,
                        struct lf_light_clues *light)
{
    struct view_planes planes;
    uint64_t begin = ng_clock_ns();
    NG_TRY(lf_memory_begin(&light->memory[LF_LIGHT_VIEW], lf_clues_view_bytes(pixels->width, pixels->height),
                           "the view of a light"));
    NG_TRY(lf_memory_begin(&light->memory[LF_LIGHT_HITS],
                           lf_clues_hits_bytes(pixels->width, pixels->height, pixels->reflection_rays),
                           "the view of a light"));
    NG_TRY(lay_out(scene, (size_t)pixels->width * pixels->height, light, &planes));
    const struct lf_interleaved rays = {planes.rays[0], planes.rays[1], planes.rays[2]};
    if (wants_shadow(scene, light))
        lf_shadow_distance_find(scene, pixels, light, planes.shadow);
    NG_TRY(end_part(scene, &begin, &light->ms[LF_CLUES_SHADOW_DISTANCE]));
    if (wants_direct(scene))
        lf_direct_view(scene, pixels, light, planes.diffuse, planes.glossy);
    NG_TRY(end_part(scene, &begin, &light->ms[LF_CLUES_DIRECT]));
    if (wants_visibility(scene))
        lf_visibility_find(scene, pixels, light, planes.shadow, &rays, planes.visibility_diffuse[0]);
    NG_TRY(end_part(scene, &begin, &light->ms[LF_CLUES_VISIBILITY]));
    if (lf_clues_wants(scene, LF_INPUT_VIEW_VISIBILITY_SPECULAR))
        lf_specular_visibility_find(scene, pixels, light, planes.glossy, planes.visibility_diffuse[0], &rays,
                                    planes.visibility_specular[0]);
    NG_TRY(end_part(scene, &begin, &light->ms[LF_CLUES_SPECULAR_VISIBILITY]));
    light->reaching = -1;
    if (wants_direct(scene))
        light->reaching = mean_reaching(scene, pixels, &planes);
    if (lf_clues_wants(scene, LF_INPUT_VIEW_IRRADIANCE_RSM))
        NG_TRY(lf_rsm_gather(scene, pixels, light, planes.irradiance_rsm));
    NG_TRY(end_part(scene, &begin, &light->ms[LF_CLUES_RSM_GATHER]));
    if (lf_clues_wants(scene, LF_INPUT_PIXEL_GATHERED))
        NG_TRY(lf_hemisphere_light(scene, pixels, light));
    NG_TRY(end_part(scene, &begin, &light->ms[LF_CLUES_HEMISPHERE_GATHER]));
    if (lf_clues_wants(scene, LF_INPUT_PIXEL_REFLECTED))
        NG_TRY(lf_reflections_light(scene, pixels, light));
    light->ms[LF_CLUES_REFLECTED_LIGHT] = lf_clues_lap(&begin);
    return NG_OK;
}

ng_result lf_light_clues_keep(struct lf_light_clues *light, uint64_t set)
{
    struct lf_memory *memory = &light->memory[LF_LIGHT_KEPT];
    size_t count = light->pixel_count;
    light->kept = light->values;
    NG_TRY(lf_memory_begin(memory, lf_clues_kept_bytes((uint32_t)count, 1, set), "the view of a light"));
    for (int i = 0; i < LF_INPUT_COUNT; i++) {
        const float *from = light->values.of[i];
        LF_PART(float) copy;
        if (lf_net_inputs[i].domain != LF_DOMAIN_VIEW)
            continue;
        light->kept.of[i] = NULL;
        if (!from || !(set >> i & 1))
            continue;
        if (!lf_take(memory, &copy, lf_net_inputs[i].channels * count))
            return ng_out_of_memory("the view of a light");
        memcpy(copy.items, from, copy.count * sizeof *from);
        light->kept.of[i] = copy.items;
    }
    return NG_OK;
}

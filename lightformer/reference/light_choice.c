#include "lightformer/reference/light_choice.h"

#include "base/log.h"
#include "lightformer/trace/vec.h"

#include <string.h>

#define POINTS 64

static float distance2(const float a[3], const float b[3])
{
    float d[3];
    lf_mad(a, b, -1, d);
    return lf_dot(d, d);
}

// The shape of a light that is one of the uniform ones.
static void find_form(const struct ng_light_source *source, struct lf_light_entry *out)
{
    static const enum lf_light_form forms[] = {[NG_LIGHT_SHAPE_RECTANGLE] = LF_LIGHT_SQUARE,
                                               [NG_LIGHT_SHAPE_DISK] = LF_LIGHT_DISK,
                                               [NG_LIGHT_SHAPE_SPHERE] = LF_LIGHT_SPHERE,
                                               [NG_LIGHT_SHAPE_MESH] = LF_LIGHT_OTHER};
    struct ng_light_surface surface = {0};
    if (!source->type->surface || source->image.width)
        return;
    source->type->surface(source, &surface);
    ng_light_sample_at(source, (const float[2]){0.5f, 0.5f}, &out->sample);
    if (!(out->sample.pdf > 0))
        return;
    out->form = forms[surface.shape];
    memcpy(out->center, &surface.matrix[12], sizeof out->center);
    memcpy(out->axes[0], &surface.matrix[0], sizeof out->axes[0]);
    memcpy(out->axes[1], &surface.matrix[4], sizeof out->axes[1]);
}

// Where the light is and how far it reaches, from its own VPLs, whatever its type.
static void describe(const struct ng_snapshot_light *light, float scene_radius, struct lf_light_entry *out)
{
    struct ng_light_sample vpls[POINTS];
    *out = (struct lf_light_entry){.infinite = light->source.type->infinite};
    if (!(light->power > 0))
        return;
    float disk = NG_PI * scene_radius * scene_radius;
    out->strength = light->power / (out->infinite ? fmaxf(disk, 1e-20f) : 4 * NG_PI);
    ng_light_vpls(&light->source, POINTS, vpls);
    for (int i = 0; i < POINTS; i++)
        lf_mad(out->position, vpls[i].position, 1.0f / POINTS, out->position);
    for (int i = 0; i < POINTS; i++)
        out->radius2 += distance2(vpls[i].position, out->position) / POINTS;
    find_form(&light->source, out);
    out->radius2 = fmaxf(out->radius2, fmaxf(1e-6f * scene_radius * scene_radius, 1e-12f));
}

ng_result lf_light_choice_update(struct lf_light_choice *c, const struct ng_snapshot *snapshot)
{
    c->count = c->lit = 0;
    if (!ng_array_resize(&c->memory, (size_t)snapshot->light_count + 1)) // never null
        return ng_out_of_memory("lights");
    c->entries = c->memory.items;
    c->snapshot = snapshot;
    c->count = snapshot->light_count;
    for (uint32_t i = 0; i < c->count; i++) {
        describe(&snapshot->lights[i], snapshot->scene_radius, &c->memory.items[i]);
        c->lit += c->entries[i].strength > 0;
    }
    return NG_OK;
}

void lf_light_choice_finish(struct lf_light_choice *c)
{
    ng_array_finish(&c->memory);
    *c = (struct lf_light_choice){0};
}

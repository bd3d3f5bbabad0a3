#include "lightformer/reference/light_choice.h"

#include "base/log.h"
#include "lightformer/trace/vec.h"

#include <stdlib.h>
#include <string.h>

#define EVEN_SHARE 0.1f // of the probability that all lights share evenly
#define POINTS     64

struct lf_light_entry {
    float position[3];
    float radius2;  // squared, of the emitter around position: nearer is no brighter
    float strength; // irradiance at one metre; of lights at infinity anywhere; 0: the light is off
    bool infinite;
};

static float distance2(const float a[3], const float b[3])
{
    float d[3];
    lf_mad(a, b, -1, d);
    return lf_dot(d, d);
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
    out->radius2 = fmaxf(out->radius2, fmaxf(1e-6f * scene_radius * scene_radius, 1e-12f));
}

ng_result lf_light_choice_update(struct lf_light_choice *c, const struct ng_snapshot *snapshot)
{
    lf_light_choice_finish(c);
    c->entries = calloc(snapshot->light_count ? snapshot->light_count : 1, sizeof *c->entries);
    if (!c->entries)
        return ng_out_of_memory("lights");
    c->snapshot = snapshot;
    c->count = snapshot->light_count;
    for (uint32_t i = 0; i < c->count; i++) {
        describe(&snapshot->lights[i], snapshot->scene_radius, &c->entries[i]);
        c->lit += c->entries[i].strength > 0;
    }
    return NG_OK;
}

void lf_light_choice_finish(struct lf_light_choice *c)
{
    free(c->entries);
    *c = (struct lf_light_choice){0};
}

static float weight(const struct lf_light_entry *e, const float position[3])
{
    float square = lf_max(distance2(e->position, position), e->radius2);
    return e->strength / (e->infinite ? 1 : square);
}

float lf_light_choice_total(const struct lf_light_choice *c, const float position[3])
{
    float total = 0;
    for (uint32_t i = 0; c->lit > 1 && i < c->count; i++)
        total += weight(&c->entries[i], position);
    return total;
}

float lf_light_choice_probability(const struct lf_light_choice *c, const float position[3], float total,
                                  uint32_t light)
{
    if (!(c->entries[light].strength > 0))
        return 0;
    if (c->lit == 1)
        return 1;
    float even = 1.0f / (float)c->lit;
    float own = total > 0 ? weight(&c->entries[light], position) / total : even;
    return EVEN_SHARE * even + (1 - EVEN_SHARE) * own;
}

uint32_t lf_light_choice_pick(const struct lf_light_choice *c, const float position[3], float total, float *u,
                              float *probability)
{
    uint32_t last = NG_NONE;
    float below = 0; // probability of the lights before
    for (uint32_t i = 0; i < c->count; i++) {
        if (!(c->entries[i].strength > 0))
            continue;
        last = i;
        *probability = lf_light_choice_probability(c, position, total, i);
        if (*u < below + *probability) {
            *u = lf_min((*u - below) / *probability, 0x1.fffffep-1f);
            break;
        }
        below += *probability;
    }
    return last;
}

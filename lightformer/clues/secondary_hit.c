// Each hit is lit by all of a light's unshadowed direct light, as far as rays to points of the light say that
// it arrives: one ray, but to an environment several.
#include "lightformer/clues/clues_internal.h"

#include <string.h>

#define TRIES           4 // direct VPLs that may be hidden by the surface itself
#define LARGEST         65504.0f
// Of what is seen: a highlight there that one of many rays meets would be a firefly.
#define LEAST_ROUGHNESS 0.7f

bool lf_secondary_continues(const struct lf_secondary_hit *hit)
{
    return hit->met && lf_max3(hit->f0) > LF_METAL;
}

static void set_surface(const struct lf_space *space, const struct lf_surface *s, float roughness,
                        struct lf_secondary_hit *out)
{
    lf_to_scene(space, s->position, out->position);
    memcpy(out->normal, s->normal, sizeof out->normal);
    memcpy(out->flat, s->flat_normal, sizeof out->flat);
    lf_scale(out->direction, -1, out->view);
    out->roughness = fmaxf(s->roughness, fmaxf(roughness, LEAST_ROUGHNESS));
    if (lf_surface_is_black(s))
        return;
    for (int c = 0; c < 3; c++) { // reflectances as far as the G-buffer's halfs reach
        out->albedo[c] = fminf(fmaxf(s->albedo[c], 0), LARGEST);
        out->f0[c] = fminf(fmaxf(s->f0[c], 0), LARGEST);
        out->emission[c] = lf_finite(fmaxf(s->emission[c], 0));
    }
}

void lf_secondary_cast(const struct lf_clues_scene *scene, const struct lf_space *space,
                       const float position[3], const float flat[3], float roughness,
                       struct lf_secondary_hit *hit)
{
    struct lf_ray ray = {.near = 0, .far = INFINITY};
    struct lf_hit met;
    struct lf_surface surface;
    float world[3];
    lf_to_world(space, position, world);
    memcpy(ray.direction, hit->direction, sizeof ray.direction);
    lf_trace_origin(scene->tracer, world, flat, ray.direction, ray.origin);
    lf_count_rays(scene, 1);
    hit->met = lf_trace_closest(scene->tracer, &ray, LF_RAY_PAST_LAMPS, &met);
    if (!hit->met)
        return;
    lf_surface_seen_at(scene->tracer, &met, ray.direction, &surface);
    hit->distance = met.distance / space->radius;
    set_surface(space, &surface, roughness, hit);
}

// ---- lights ----------------------------------------------------------------------------------------------

struct lighting {
    const struct lf_clues_scene *scene;
    const struct lf_light_clues *light;
    const struct lf_secondary_hit *hits;
    uint32_t count, going_on;
    float *out; // [count][LF_HIT_CHANNELS]
};

static void set_lane(const struct lf_secondary_hit *hit, int lane, struct lf_shading_points *out)
{
    for (int c = 0; c < 3; c++) {
        out->position[c][lane] = hit->position[c];
        out->normal[c][lane] = hit->normal[c];
        out->flat[c][lane] = hit->flat[c];
        out->view[c][lane] = hit->view[c];
        out->albedo[c][lane] = hit->albedo[c];
        out->f0[c][lane] = hit->f0[c];
    }
    out->roughness[lane] = hit->roughness;
}

// The light of a direct VPL at a hit, W/m2 in the mean; 0 where the hit's surface itself hides it.
static float light_of(const struct lighting *l, const struct lf_secondary_hit *hit,
                      const struct ng_light_sample *vpl, const float position[3],
                      struct ng_light_incident *in)
{
    ng_light_incident_at(&l->light->unit, vpl, position, in);
    float weight = ng_light_mean(in->irradiance) * lf_dot(hit->normal, in->direction);
    return weight > 0 && lf_dot(hit->flat, in->direction) > 0 ? weight : 0;
}

static bool arrives(const struct lighting *l, const struct lf_secondary_hit *hit,
                    const struct ng_light_sample *vpl, const float position[3],
                    const struct ng_light_incident *in)
{
    const struct lf_light_clues *light = l->light;
    struct lf_ray ray = {.near = 0};
    lf_trace_origin(l->scene->tracer, position, hit->flat, in->direction, ray.origin);
    memcpy(ray.direction, in->direction, sizeof ray.direction);
    ray.far = lf_max(in->distance * LF_LIGHT_RAY_PART - lf_skin_along(light, vpl, in->direction), 0);
    lf_count_rays(l->scene, 1);
    return !lf_trace_shadowed(l->scene->tracer, &ray, light->light);
}

// How much of the light is visible from a hit, by rays to some of its direct VPLs. One, and another one for
// each hit of a block; but an environment is around everything, and one direction of it says nothing of the
// others: what a mirror shows would be dotted.
static float visible_part(const struct lighting *l, const struct lf_secondary_hit *hit)
{
    const struct lf_light_clues *light = l->light;
    const struct ng_light_type *type = light->unit.type;
    uint32_t count =
        light->vpl_count < LF_INTERLEAVE * LF_INTERLEAVE ? light->vpl_count : LF_INTERLEAVE * LF_INTERLEAVE;
    bool around = type->infinite && !type->delta;
    float position[3], open = 0, all = 0;
    lf_to_world(&light->space, hit->position, position);
    for (uint32_t i = 0; i < (around ? count : TRIES) && (around || !(all > 0)); i++) {
        const struct ng_light_sample *vpl = &light->vpls.items[(hit->interleave_index + i) % count];
        struct ng_light_incident in;
        float weight = light_of(l, hit, vpl, position, &in);
        all += weight;
        open += weight > 0 && arrives(l, hit, vpl, position, &in) ? weight : 0;
    }
    return all > 0 ? open / all : 0;
}

static void light_lanes(const struct lighting *l, size_t first)
{
    size_t left = l->count - first, count = left < LF_LANES ? left : LF_LANES;
    const struct lf_secondary_hit *hits = l->hits + first;
    struct lf_shading_points points;
    struct lf_lit lit;
    float indirect[3][LF_LANES];
    for (size_t i = 0; i < LF_LANES; i++)
        set_lane(&hits[i < count ? i : 0], (int)i, &points);
    bool far = true;
    for (size_t i = 0; i < count; i++)
        far = far && (!hits[i].met || lf_direct_is_far(l->light, hits[i].position, hits[i].normal));
    lf_direct_at(l->scene, l->light, &points, (uint32_t)count, far ? LF_SAMPLE_FAR : LF_SAMPLE_LIGHT, &lit);
    lf_kernels_of(0)->rsm_gather(l->light->sources_of_hits.items, (uint32_t)l->light->sources_of_hits.count,
                                 &points, indirect);
    for (size_t i = 0; i < count; i++) {
        float *out = l->out + (first + i) * LF_HIT_CHANNELS, lit_sum = 0;
        float f0 =
            first + i < l->going_on && lf_secondary_continues(&hits[i]) ? 0 : 1; // has it a ray to see that?
        for (int c = 0; c < 3; c++) {
            out[c] = hits[i].met ? lf_finite(lit.diffuse[c][i] + lit.glossy[c][i]) : 0;
            lit_sum += out[c];
        }
        lf_scale(out, lit_sum > 0 ? visible_part(l, &hits[i]) : 0, out);
        out[3] = 0;
        for (int c = 0; c < 3 && hits[i].met; c++)
            out[c] += lf_finite(indirect[c][i] * (hits[i].albedo[c] + f0 * hits[i].f0[c]));
    }
}

static void light_hits(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    for (size_t block = begin; block < end; block++)
        light_lanes(user, block * LF_LANES);
}

void lf_secondary_light(const struct lf_clues_scene *scene, const struct lf_light_clues *light,
                        const struct lf_secondary_hit *hits, uint32_t count, uint32_t going_on, float *out)
{
    struct lighting l = {scene, light, hits, count, going_on, out};
    ng_jobs_for(scene->jobs, (count + LF_LANES - 1) / LF_LANES, 4, light_hits, &l);
}

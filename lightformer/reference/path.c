// The path is walked surface by surface. `throughput` is what is left of light that the path carries to the
// camera; a surface's own light is added as soon as it is met.
#include "lightformer/reference/path.h"

#include "lightformer/reference/scatter.h"
#include "lightformer/trace/vec.h"

#include <string.h>

#define FIRST_ROULETTE 3     // bounces that are always taken
#define MOST_SURVIVAL  0.95f // so that paths end in a white room, too

// A surface on the way, with what multiple importance sampling has to remember of it.
struct vertex {
    struct lf_surface surface;
    struct lf_scatter scatter;
    float choice_total; // lf_light_choice_total
};

static void count_ray(const struct lf_path_scene *scene)
{
    if (scene->rays)
        ++*scene->rays;
}

static float power_heuristic(float a, float b)
{
    // Divided first: densities of tiny lights overflow when squared.
    if (!(a > 0))
        return 0;
    float r = b / a;
    return 1 / (1 + r * r);
}

static void add_product(float sum[3], const float a[3], const float b[3], float t)
{
    for (int i = 0; i < 3; i++)
        sum[i] += a[i] * b[i] * t;
}

static void arrive(struct vertex *v, const struct lf_path_scene *scene, const float direction[3])
{
    const float toward[3] = {-direction[0], -direction[1], -direction[2]};
    lf_scatter_at(&v->surface, toward, &v->scatter);
    v->choice_total = lf_light_choice_total(scene->lights, v->surface.position);
}

// ---- meeting emitters ------------------------------------------------------------------------------------
static struct ng_light_hit light_hit(const float from[3], const float direction[3], const struct lf_hit *hit)
{
    struct ng_light_hit h = {.triangle = hit->triangle,
                             .barycentric = {hit->barycentric[0], hit->barycentric[1]}};
    float way[3];
    memcpy(h.position, hit->position, sizeof h.position);
    memcpy(h.direction, direction, sizeof h.direction);
    lf_mad(hit->position, from, -1, way);
    h.distance = sqrtf(lf_dot(way, way));
    return h;
}

// What a light sends along a direction that the BRDF chose with density `pdf` at a vertex, weighted.
static void add_met_light(const struct lf_path_scene *scene, const struct vertex *from, uint32_t light,
                          const struct ng_light_hit *hit, float pdf, float sum[3])
{
    const struct ng_light_source *source = &scene->lights->snapshot->lights[light].source;
    float seen[3];
    ng_light_seen_at(source, hit, seen);
    if (!(lf_max3(seen) > 0))
        return;
    float chosen =
        lf_light_choice_probability(scene->lights, from->surface.position, from->choice_total, light);
    lf_mad(sum, seen, power_heuristic(pdf, chosen * ng_light_pdf_at(source, hit)), sum);
}

// All lights at infinity; `sum` is what they send.
static void add_met_environments(const struct lf_path_scene *scene, const struct vertex *from,
                                 const float direction[3], float pdf, float sum[3])
{
    const struct ng_snapshot *snapshot = scene->lights->snapshot;
    struct ng_light_hit hit = {.distance = INFINITY};
    memcpy(hit.direction, direction, sizeof hit.direction);
    for (uint32_t i = 0; i < snapshot->light_count; i++)
        if (snapshot->lights[i].source.type->infinite && !snapshot->lights[i].source.type->delta)
            add_met_light(scene, from, i, &hit, pdf, sum);
}

struct unshadowed {
    const struct lf_path_scene *scene;
    const struct vertex *from;
    const float *direction;
    float pdf;
    float *sum;
};

static void add_unshadowed(void *user, const struct lf_hit *hit)
{
    const struct unshadowed *u = user;
    struct ng_light_hit h = light_hit(u->from->surface.position, u->direction, hit);
    uint32_t light = u->scene->lights->snapshot->instances[hit->instance].light;
    add_met_light(u->scene, u->from, light, &h, u->pdf, u->sum);
}

// ---- one step --------------------------------------------------------------------------------------------
// Whether nothing stands between a vertex and the point of a light that was sampled.
static bool sees(const struct lf_path_scene *scene, const struct vertex *v,
                 const struct ng_light_sample *sample, const struct ng_light_incident *incident)
{
    struct lf_ray ray = {.near = 0, .far = INFINITY};
    const float *d = incident->direction;
    lf_trace_origin(scene->tracer, v->surface.position, v->surface.flat_normal, d, ray.origin);
    memcpy(ray.direction, d, sizeof ray.direction);
    if (isfinite(incident->distance)) {
        // To just before the emitter's own surface.
        const float back[3] = {-d[0], -d[1], -d[2]};
        float target[3], way[3];
        lf_trace_origin(scene->tracer, sample->position, sample->normal, back, target);
        lf_mad(target, ray.origin, -1, way);
        ray.far = sqrtf(lf_dot(way, way)) * (1 - 1e-6f);
        memcpy(ray.direction, way, sizeof way);
        if (!lf_normalize(ray.direction))
            return true;
    }
    count_ray(scene);
    return !lf_trace_occluded(scene->tracer, &ray);
}

// Light from one light at a vertex: `whole` as if nothing were in between; true if nothing is.
static bool sample_light(const struct lf_path_scene *scene, const struct vertex *v,
                         struct lf_sampler *sampler, float whole[3])
{
    struct ng_light_sample sample;
    struct ng_light_incident incident;
    float u[2], value[3], pdf;
    lf_sampler_2d(sampler, u);
    memset(whole, 0, 3 * sizeof(float));
    const float *position = v->surface.position;
    uint32_t light = lf_light_choice_pick(scene->lights, position, v->choice_total, &u[0]);
    if (light == NG_NONE)
        return false;
    const struct ng_light_source *source = &scene->lights->snapshot->lights[light].source;
    ng_light_sample_at(source, u, &sample);
    ng_light_incident_at(source, &sample, position, &incident);
    if (!(lf_max3(incident.irradiance) > 0))
        return false;
    lf_scatter_eval(&v->scatter, incident.direction, value, &pdf);
    if (!(lf_max3(value) > 0))
        return false;
    float chosen = lf_light_choice_probability(scene->lights, position, v->choice_total, light);
    float weight = incident.pdf > 0 ? power_heuristic(chosen * incident.pdf, pdf) : 1;
    add_product(whole, value, incident.irradiance, weight / chosen);
    return sees(scene, v, &sample, &incident);
}

// What is met in a chosen direction.
struct step {
    float direction[3], pdf;
    float weight[3]; // BRDF * cosine / pdf
    bool met;
    struct lf_hit hit;
};

static bool choose_direction(const struct vertex *v, struct lf_sampler *sampler, struct step *out)
{
    float u[2];
    lf_sampler_2d(sampler, u);
    if (!lf_scatter_sample(&v->scatter, u, out->direction))
        return false;
    lf_scatter_eval(&v->scatter, out->direction, out->weight, &out->pdf);
    if (!(out->pdf > 0) || !(lf_max3(out->weight) > 0))
        return false;
    lf_scale(out->weight, 1 / out->pdf, out->weight);
    return true;
}

static struct lf_ray leave(const struct lf_path_scene *scene, const struct vertex *v,
                           const float direction[3])
{
    struct lf_ray ray = {.near = 0, .far = INFINITY};
    lf_trace_origin(scene->tracer, v->surface.position, v->surface.flat_normal, direction, ray.origin);
    memcpy(ray.direction, direction, sizeof ray.direction);
    return ray;
}

// Light of lights that the step met, as seen from `v`; `next` becomes the surface that it met.
static void take_step(const struct lf_path_scene *scene, const struct vertex *v, struct step *step,
                      struct lf_surface *next, float seen[3])
{
    struct lf_ray ray = leave(scene, v, step->direction);
    memset(seen, 0, 3 * sizeof(float));
    count_ray(scene);
    step->met = lf_trace_closest(scene->tracer, &ray, LF_RAY_ALL, &step->hit);
    if (!step->met) {
        add_met_environments(scene, v, step->direction, step->pdf, seen);
        return;
    }
    lf_surface_at(scene->tracer, &step->hit, next);
    if (next->light == NG_NONE)
        return;
    struct ng_light_hit hit = light_hit(v->surface.position, step->direction, &step->hit);
    add_met_light(scene, v, next->light, &hit, step->pdf, seen);
}

static void see_unshadowed(const struct lf_path_scene *scene, const struct vertex *v, const struct step *step,
                           float seen[3])
{
    struct lf_ray ray = leave(scene, v, step->direction);
    memset(seen, 0, 3 * sizeof(float));
    add_met_environments(scene, v, step->direction, step->pdf, seen);
    struct unshadowed u = {
        .scene = scene, .from = v, .direction = step->direction, .pdf = step->pdf, .sum = seen};
    count_ray(scene);
    lf_trace_emitters(scene->tracer, &ray, add_unshadowed, &u);
}

// ---- paths -----------------------------------------------------------------------------------------------
void lf_path_begin(const struct lf_path_scene *scene, const struct lf_ray *ray, struct lf_primary *out)
{
    const struct ng_snapshot *snapshot = scene->lights->snapshot;
    struct lf_hit hit;
    *out = (struct lf_primary){.ray = *ray, .instance = NG_NONE};
    count_ray(scene);
    out->met = lf_trace_closest(scene->tracer, ray, LF_RAY_CAMERA, &hit);
    uint32_t light = snapshot->environment;
    struct ng_light_hit seen = {.distance = INFINITY};
    memcpy(seen.direction, ray->direction, sizeof seen.direction);
    if (out->met) {
        lf_surface_at(scene->tracer, &hit, &out->surface);
        out->distance = hit.distance;
        out->instance = hit.instance;
        light = out->surface.light;
        seen = light_hit(ray->origin, ray->direction, &hit);
        memcpy(out->emission, out->surface.emission, sizeof out->emission);
    }
    if (light != NG_NONE)
        ng_light_seen_at(&snapshot->lights[light].source, &seen, out->emission);
}

// False if the path ends here; survivors carry more.
static bool play_roulette(struct lf_sampler *sampler, uint32_t bounce, float throughput[3])
{
    if (!(lf_max3(throughput) > 0))
        return false;
    if (bounce < FIRST_ROULETTE)
        return true;
    float survival = fminf(lf_max3(throughput), MOST_SURVIVAL);
    lf_scale(throughput, 1 / survival, throughput);
    return lf_sampler_1d(sampler) < survival;
}

void lf_path_trace(const struct lf_path_scene *scene, const struct lf_primary *primary,
                   struct lf_sampler *sampler, struct lf_radiance *out)
{
    struct vertex v = {.surface = primary->surface};
    float throughput[3] = {1, 1, 1}, direction[3], seen[3];
    *out = (struct lf_radiance){0};
    memcpy(out->emission, primary->emission, sizeof out->emission);
    memcpy(direction, primary->ray.direction, sizeof direction);
    if (!primary->met)
        return;
    for (uint32_t bounce = 0; !scene->depth || bounce + 2 <= scene->depth; bounce++) {
        if (lf_surface_is_black(&v.surface))
            return;
        arrive(&v, scene, direction);
        bool first = bounce == 0;
        float *sum = first ? out->direct : out->indirect;
        bool lit = sample_light(scene, &v, sampler, seen);
        if (first)
            add_product(out->unshadowed, throughput, seen, 1);
        if (lit)
            add_product(sum, throughput, seen, 1);

        struct step step;
        struct lf_surface next;
        if (!choose_direction(&v, sampler, &step))
            return;
        for (int i = 0; i < 3; i++)
            throughput[i] *= step.weight[i];
        if (first) {
            see_unshadowed(scene, &v, &step, seen);
            add_product(out->unshadowed, throughput, seen, 1);
        }
        take_step(scene, &v, &step, &next, seen);
        add_product(sum, throughput, seen, 1);
        if (!step.met)
            return;
        add_product(out->indirect, throughput, next.emission, 1);
        if (!play_roulette(sampler, bounce, throughput))
            return;
        v.surface = next;
        memcpy(direction, step.direction, sizeof direction);
    }
}

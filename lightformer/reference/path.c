// A path is walked surface by surface. `throughput` is what is left of light that the path carries to the
// camera; a surface's own light is added as soon as it is met.
//
// Many paths walk in step: each does the same small thing before any does the next. One path is a chain in
// which every number waits for the one before; several fill the processor's waiting with one another's work.
#include "lightformer/reference/path.h"

#include "base/system.h"
#include "lightformer/reference/scatter.h"
#include "lightformer/trace/vec.h"

#include <string.h>

#define FIRST_ROULETTE 2     // the bounce after which it is first played: the third
#define MOST_SURVIVAL  0.95f // so that paths end in a white room, too

// A surface on the way, with what multiple importance sampling has to remember of it.
struct vertex {
    const struct lf_surface *surface;
    struct lf_scatter scatter;
    float choice_total; // lf_light_choice_total
};

static uint64_t start_clock(const struct lf_path_scene *scene)
{
    return scene->timed ? ng_clock_ns() : 0;
}

static void stop_clock(const struct lf_path_scene *scene, uint64_t begin, uint64_t *ns)
{
    if (scene->timed)
        *ns += ng_clock_ns() - begin;
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

static void arrive(const struct lf_path_scene *scene, const struct lf_surface *surface,
                   const float direction[3], struct vertex *v)
{
    const float toward[3] = {-direction[0], -direction[1], -direction[2]};
    v->surface = surface;
    lf_scatter_at(surface, toward, &v->scatter);
    v->choice_total = lf_light_choice_total(scene->lights, v->surface->position);
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
        lf_light_choice_probability(scene->lights, from->surface->position, from->choice_total, light);
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
    struct ng_light_hit h = light_hit(u->from->surface->position, u->direction, hit);
    uint32_t light = u->scene->lights->snapshot->instances[hit->instance].light;
    add_met_light(u->scene, u->from, light, &h, u->pdf, u->sum);
}

// ---- one step --------------------------------------------------------------------------------------------
static void leave(const struct lf_path_scene *scene, const struct vertex *v, const float direction[3],
                  struct lf_ray *out)
{
    lf_trace_origin(scene->tracer, v->surface->position, v->surface->flat_normal, direction, out->origin);
    lf_scale(direction, 1, out->direction);
    out->near = 0;
    out->far = INFINITY;
}

// The ray from a vertex to the point of a light that was sampled; false if they are in one place.
static bool aim_at(const struct lf_path_scene *scene, const struct vertex *v,
                   const struct ng_light_sample *sample, const struct ng_light_incident *incident,
                   struct lf_ray *out)
{
    const float *d = incident->direction;
    leave(scene, v, d, out);
    if (!isfinite(incident->distance))
        return true;
    // To just before the emitter's own surface.
    const float back[3] = {-d[0], -d[1], -d[2]};
    float target[3], way[3];
    lf_trace_origin(scene->tracer, sample->position, sample->normal, back, target);
    lf_mad(target, out->origin, -1, way);
    float length = sqrtf(lf_dot(way, way));
    if (!(length > 0))
        return false;
    lf_scale(way, 1 / length, out->direction);
    out->far = length * (1 - 1e-6f);
    return true;
}

// What a sampled light would send to a vertex if nothing were in between.
struct connection {
    float whole[3];
    bool asks; // a ray has to tell whether there is
    struct lf_ray ray;
};

static void sample_light(const struct lf_path_scene *scene, const struct vertex *v,
                         struct lf_sampler *sampler, struct connection *out)
{
    struct ng_light_sample sample;
    struct ng_light_incident incident;
    struct lf_scatter_value scattered;
    float u[2], chosen;
    lf_sampler_2d(sampler, u);
    out->whole[0] = out->whole[1] = out->whole[2] = 0;
    out->asks = false;
    const float *position = v->surface->position;
    uint32_t light = lf_light_choice_pick(scene->lights, position, v->choice_total, &u[0], &chosen);
    if (light == NG_NONE)
        return;
    const struct ng_light_source *source = &scene->lights->snapshot->lights[light].source;
    ng_light_sample_at(source, u, &sample);
    ng_light_incident_at(source, &sample, position, &incident);
    if (!(lf_max3(incident.irradiance) > 0) || !lf_scatter_eval(&v->scatter, incident.direction, &scattered))
        return;
    float weight = incident.pdf > 0 ? power_heuristic(chosen * incident.pdf, scattered.pdf) : 1;
    for (int i = 0; i < 3; i++)
        out->whole[i] = scattered.value[i] * incident.irradiance[i] * (weight / chosen);
    out->asks = aim_at(scene, v, &sample, &incident, &out->ray);
}

static bool is_lit(const struct lf_path_scene *scene, const struct connection *c)
{
    if (!c->asks)
        return true;
    scene->stats->shadow_rays++;
    return !lf_trace_occluded(scene->tracer, &c->ray);
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
    struct lf_scatter_value scattered;
    float u[2];
    lf_sampler_2d(sampler, u);
    if (!lf_scatter_sample(&v->scatter, u, out->direction, &scattered))
        return false;
    out->pdf = scattered.pdf;
    lf_scale(scattered.value, 1 / scattered.pdf, out->weight);
    return true;
}

static void take_step(const struct lf_path_scene *scene, const struct vertex *v, struct step *step)
{
    struct lf_ray ray;
    leave(scene, v, step->direction, &ray);
    step->met = lf_trace_closest(scene->tracer, &ray, LF_RAY_ALL, &step->hit);
    if (step->met)
        lf_surface_prefetch(scene->tracer, &step->hit);
}

// Light of lights that a step met, as seen from `v`; `next` becomes the surface that it met.
static void look_at_step(const struct lf_path_scene *scene, const struct vertex *v, const struct step *step,
                         struct lf_surface *next, float seen[3])
{
    seen[0] = seen[1] = seen[2] = 0;
    if (!step->met) {
        add_met_environments(scene, v, step->direction, step->pdf, seen);
        return;
    }
    lf_surface_at(scene->tracer, &step->hit, next);
    if (next->light == NG_NONE)
        return;
    struct ng_light_hit hit = light_hit(v->surface->position, step->direction, &step->hit);
    add_met_light(scene, v, next->light, &hit, step->pdf, seen);
}

static void see_unshadowed(const struct lf_path_scene *scene, const struct vertex *v, const struct step *step,
                           float seen[3])
{
    struct lf_ray ray;
    leave(scene, v, step->direction, &ray);
    memset(seen, 0, 3 * sizeof(float));
    add_met_environments(scene, v, step->direction, step->pdf, seen);
    struct unshadowed u = {
        .scene = scene, .from = v, .direction = step->direction, .pdf = step->pdf, .sum = seen};
    scene->stats->emitter_rays += lf_trace_emitters(scene->tracer, &ray, add_unshadowed, &u);
}

// ---- paths -----------------------------------------------------------------------------------------------
void lf_path_begin(const struct lf_path_scene *scene, const struct lf_ray *ray, struct lf_primary *out)
{
    const struct ng_snapshot *snapshot = scene->lights->snapshot;
    *out = (struct lf_primary){.ray = *ray};
    scene->stats->path_rays++;
    out->met = lf_trace_closest(scene->tracer, ray, LF_RAY_CAMERA, &out->hit);
    uint32_t light = snapshot->environment;
    struct ng_light_hit seen = {.distance = INFINITY};
    memcpy(seen.direction, ray->direction, sizeof seen.direction);
    if (out->met) {
        lf_surface_at(scene->tracer, &out->hit, &out->surface);
        light = out->surface.light;
        seen = light_hit(ray->origin, ray->direction, &out->hit);
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
    float survival = lf_min(sqrtf(lf_max3(throughput)), MOST_SURVIVAL); // README.md: why the root
    lf_scale(throughput, 1 / survival, throughput);
    return lf_sampler_1d(sampler) < survival;
}

// A path under way.
struct walker {
    struct lf_path *path;
    const struct lf_surface *here;
    const float *direction; // in which it came
    float throughput[3];
    const struct vertex *at; // own, or that of a neighbour which begins with the same surface
    struct vertex vertex;
    struct connection connection;
    struct step steps[2];          // this bounce's and the last one's
    struct lf_surface surfaces[2]; // likewise: met by them
};

struct walk {
    const struct lf_path_scene *scene;
    uint32_t bounce, count; // walkers that go on
    struct walker *going[LF_PATHS];
    struct walker walkers[LF_PATHS];
};

static void start_walk(struct walk *w, const struct lf_path_scene *scene, struct lf_path *paths,
                       uint32_t count)
{
    w->scene = scene;
    w->bounce = w->count = 0;
    for (uint32_t i = 0; i < count; i++) {
        struct lf_path *path = &paths[i];
        struct walker *walker = &w->walkers[i];
        path->radiance = (struct lf_radiance){0};
        memcpy(path->radiance.emission, path->primary->emission, sizeof path->radiance.emission);
        if (!path->primary->met)
            continue;
        walker->path = path;
        walker->here = &path->primary->surface;
        walker->direction = path->primary->ray.direction;
        for (int c = 0; c < 3; c++)
            walker->throughput[c] = 1;
        w->going[w->count++] = walker;
    }
}

static void arrive_all(struct walk *w)
{
    uint32_t count = 0;
    const struct walker *before = NULL;
    for (uint32_t i = 0; i < w->count; i++) {
        struct walker *walker = w->going[i];
        if (lf_surface_is_black(walker->here))
            continue;
        walker->at = &walker->vertex;
        if (before && before->here == walker->here)
            walker->at = before->at;
        else
            arrive(w->scene, walker->here, walker->direction, &walker->vertex);
        before = walker;
        w->going[count++] = walker;
    }
    w->count = count;
}

static void sample_lights(struct walk *w)
{
    for (uint32_t i = 0; i < w->count; i++)
        sample_light(w->scene, w->going[i]->at, &w->going[i]->path->sampler, &w->going[i]->connection);
    uint64_t begin = start_clock(w->scene);
    for (uint32_t i = 0; i < w->count; i++) {
        struct walker *walker = w->going[i];
        struct lf_radiance *radiance = &walker->path->radiance;
        const struct connection *c = &walker->connection;
        if (w->bounce == 0)
            add_product(radiance->unshadowed, walker->throughput, c->whole, 1);
        if (is_lit(w->scene, c))
            add_product(w->bounce ? radiance->indirect : radiance->direct, walker->throughput, c->whole, 1);
    }
    stop_clock(w->scene, begin, &w->scene->stats->shadow_ns);
}

static void choose_directions(struct walk *w)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < w->count; i++) {
        struct walker *walker = w->going[i];
        struct step *step = &walker->steps[w->bounce % 2];
        if (!choose_direction(walker->at, &walker->path->sampler, step))
            continue;
        for (int c = 0; c < 3; c++)
            walker->throughput[c] *= step->weight[c];
        w->going[count++] = walker;
    }
    w->count = count;
}

static void see_all_unshadowed(struct walk *w)
{
    for (uint32_t i = 0; i < w->count; i++) {
        struct walker *walker = w->going[i];
        float seen[3];
        see_unshadowed(w->scene, walker->at, &walker->steps[w->bounce % 2], seen);
        add_product(walker->path->radiance.unshadowed, walker->throughput, seen, 1);
    }
}

// False if the walker ends there.
static bool look_around(struct walk *w, struct walker *walker)
{
    const struct step *step = &walker->steps[w->bounce % 2];
    struct lf_surface *next = &walker->surfaces[w->bounce % 2];
    struct lf_radiance *radiance = &walker->path->radiance;
    float seen[3];
    look_at_step(w->scene, walker->at, step, next, seen);
    add_product(w->bounce ? radiance->indirect : radiance->direct, walker->throughput, seen, 1);
    if (!step->met)
        return false;
    add_product(radiance->indirect, walker->throughput, next->emission, 1);
    walker->here = next;
    walker->direction = step->direction;
    return play_roulette(&walker->path->sampler, w->bounce, walker->throughput);
}

static void take_steps(struct walk *w)
{
    uint32_t count = 0;
    uint64_t begin = start_clock(w->scene);
    for (uint32_t i = 0; i < w->count; i++)
        take_step(w->scene, w->going[i]->at, &w->going[i]->steps[w->bounce % 2]);
    stop_clock(w->scene, begin, &w->scene->stats->path_ns);
    w->scene->stats->path_rays += w->count;
    for (uint32_t i = 0; i < w->count; i++) {
        struct walker *walker = w->going[i];
        if (look_around(w, walker))
            w->going[count++] = walker;
    }
    w->count = count;
}

void lf_paths_trace(const struct lf_path_scene *scene, struct lf_path *paths, uint32_t count)
{
    struct walk w;
    uint64_t begin = start_clock(scene);
    start_walk(&w, scene, paths, count < LF_PATHS ? count : LF_PATHS);
    for (; w.count && (!scene->depth || w.bounce + 2 <= scene->depth); w.bounce++) {
        arrive_all(&w);
        sample_lights(&w);
        choose_directions(&w);
        if (w.bounce == 0)
            see_all_unshadowed(&w);
        take_steps(&w);
    }
    stop_clock(scene, begin, &scene->stats->total_ns);
}

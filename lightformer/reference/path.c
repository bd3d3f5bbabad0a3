// A path is walked surface by surface. `throughput` is what is left of light that the path carries to the
// camera; a surface's own light is added as soon as it is met.
//
// Many paths walk in step, each in a lane of a wave (wave.h): arithmetic is done for all of them at once, and
// in between each does the same small thing that waits for memory before any does the next. Lanes of paths
// that have ended are closed up, so that arithmetic is not wasted.
#include "lightformer/reference/path.h"

#include "base/system.h"
#include "lightformer/trace/vec.h"

#include <string.h>

#define FIRST_ROULETTE 2 // the bounce after which it is first played: the third

struct walk {
    const struct lf_path_scene *scene;
    struct lf_path *paths;
    uint32_t bounce;
    bool environment;        // rays that meet nothing may meet light
    uint32_t path[LF_PATHS]; // by lane
    // Rays in the chosen directions: whose lane, and what they met.
    uint32_t ray_count, lanes[LF_PATHS];
    bool met[LF_PATHS];
    struct lf_hit hits[LF_PATHS];
    struct lf_wave wave;
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

static void take_lane(const lf_lanes3 from, uint32_t lane, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = from[i][lane];
}

static void put_lane(const float v[3], uint32_t lane, lf_lanes3 to)
{
    for (int i = 0; i < 3; i++)
        to[i][lane] = v[i];
}

// sum += what the path of a lane carries * light
static void carry(const struct lf_wave *w, uint32_t lane, const float light[3], float sum[3])
{
    for (int i = 0; i < 3; i++)
        sum[i] += w->throughput[i][lane] * light[i];
}

static struct lf_radiance *radiance_of(const struct walk *walk, uint32_t lane)
{
    return &walk->paths[walk->path[lane]].radiance;
}

// ---- meeting emitters ------------------------------------------------------------------------------------
static struct ng_light_hit light_hit(const struct ng_snapshot *snapshot, const float from[3],
                                     const float direction[3], const struct lf_hit *hit)
{
    struct ng_light_hit h;
    float way[3];
    lf_hit_on_light(snapshot, hit, &h);
    memcpy(h.position, hit->position, sizeof h.position);
    memcpy(h.direction, direction, sizeof h.direction);
    lf_mad(hit->position, from, -1, way);
    h.distance = sqrtf(lf_dot(way, way));
    return h;
}

// A direction that the BRDF chose at a surface, and what all lights along it send.
struct look {
    const struct lf_light_choice *lights;
    const struct ng_snapshot *snapshot;
    float position[3], direction[3], pdf, light_total;
    float seen[3];
};

static struct look look_from(const struct walk *walk, uint32_t lane)
{
    const struct lf_wave *w = &walk->wave;
    struct look look = {.lights = w->lights,
                        .snapshot = w->lights->snapshot,
                        .pdf = w->pdf[lane],
                        .light_total = w->light_total[lane]};
    take_lane(w->position, lane, look.position);
    take_lane(w->direction, lane, look.direction);
    return look;
}

static float choice_probability(const struct look *look, uint32_t light)
{
    const struct lf_light_entry *e = &look->lights->entries[light];
    float weight = lf_light_weight(e, look->position[0], look->position[1], look->position[2]);
    return e->strength > 0 ? lf_light_probability(weight, look->light_total, look->lights->lit) : 0;
}

// By the power heuristic.
static void add_met_light(struct look *look, uint32_t light, const struct ng_light_hit *hit)
{
    const struct ng_light_source *source = &look->snapshot->lights[light].source;
    float light_seen[3];
    ng_light_seen_at(source, hit, light_seen);
    if (!(lf_max3(light_seen) > 0))
        return;
    float ratio = choice_probability(look, light) * ng_light_pdf_at(source, hit) / look->pdf;
    lf_mad(look->seen, light_seen, 1 / (1 + ratio * ratio), look->seen);
}

static bool is_environment(const struct ng_light_source *source)
{
    return source->type->infinite && !source->type->delta;
}

static void add_met_environments(struct look *look)
{
    struct ng_light_hit hit = {.distance = INFINITY};
    memcpy(hit.direction, look->direction, sizeof hit.direction);
    for (uint32_t i = 0; i < look->snapshot->light_count; i++)
        if (is_environment(&look->snapshot->lights[i].source))
            add_met_light(look, i, &hit);
}

static void add_met_surface(void *user, const struct lf_hit *hit)
{
    struct look *look = user;
    struct ng_light_hit h = light_hit(look->snapshot, look->position, look->direction, hit);
    add_met_light(look, look->snapshot->instances[hit->instance].light, &h);
}

// In place: what is written number by number and then copied as a whole waits for the stores.
static void set_ray(const struct lf_wave *w, uint32_t lane, float far, struct lf_ray *out)
{
    take_lane(w->origin, lane, out->origin);
    take_lane(w->direction, lane, out->direction);
    out->near = 0;
    out->far = far;
    out->sample = w->reversed[lane] ^ (uint32_t)w->rng_state[lane];
}

// Of surfaces in one place a ray meets any one: the light of all of them is seen.
static void add_coinciding(const struct walk *walk, uint32_t lane, const struct lf_hit *hit,
                           struct look *look)
{
    struct lf_ray ray;
    set_ray(&walk->wave, lane, INFINITY, &ray);
    lf_trace_coinciding(walk->scene->tracer, &ray, hit, add_met_surface, look);
}

// ---- one bounce ------------------------------------------------------------------------------------------
static void arrive(struct lf_wave *w, uint32_t lane, const struct lf_surface *surface, const float came[3])
{
    put_lane(surface->position, lane, w->position);
    put_lane(surface->flat_normal, lane, w->flat_normal);
    put_lane(surface->normal, lane, w->normal);
    put_lane(surface->albedo, lane, w->albedo);
    put_lane(surface->f0, lane, w->f0);
    put_lane(came, lane, w->came);
    w->roughness[lane] = surface->roughness;
}

// Which connections something stands in the way of.
static void trace_shadows(const struct walk *walk, bool dark[LF_PATHS])
{
    const struct lf_wave *w = &walk->wave;
    struct lf_ray rays[LF_PATHS];
    bool met[LF_PATHS];
    uint32_t lanes[LF_PATHS], count = 0;
    uint64_t begin = start_clock(walk->scene);
    for (uint32_t i = 0; i < w->count; i++) {
        dark[i] = false;
        if (!(w->far[i] > 0))
            continue;
        lanes[count] = i;
        set_ray(w, i, w->far[i], &rays[count++]);
    }
    lf_trace_occluded_many(walk->scene->tracer, rays, count, met);
    for (uint32_t i = 0; i < count; i++)
        dark[lanes[i]] = met[i];
    walk->scene->stats->shadow_rays += count;
    stop_clock(walk->scene, begin, &walk->scene->stats->shadow_ns);
}

static void add_connections(struct walk *walk)
{
    const struct lf_wave *w = &walk->wave;
    bool dark[LF_PATHS];
    trace_shadows(walk, dark);
    for (uint32_t i = 0; i < w->count; i++) {
        struct lf_radiance *radiance = radiance_of(walk, i);
        float whole[3];
        take_lane(w->whole, i, whole);
        if (walk->bounce == 0)
            carry(w, i, whole, radiance->unshadowed);
        if (!dark[i])
            carry(w, i, whole, walk->bounce ? radiance->indirect : radiance->direct);
    }
}

// What every light along the chosen direction would send if nothing else were there.
static void see_unshadowed(struct walk *walk)
{
    const struct lf_wave *w = &walk->wave;
    for (uint32_t i = 0; i < w->count; i++) {
        if (!w->goes[i])
            continue;
        struct look look = look_from(walk, i);
        struct lf_ray ray;
        set_ray(w, i, INFINITY, &ray);
        add_met_environments(&look);
        walk->scene->stats->emitter_rays +=
            lf_trace_emitters(walk->scene->tracer, &ray, add_met_surface, &look);
        carry(w, i, look.seen, radiance_of(walk, i)->unshadowed);
    }
}

// Paths that end here need a ray only for the light that they might meet.
static void trace_rays(struct walk *walk)
{
    const struct lf_wave *w = &walk->wave;
    const struct lf_tracer *tracer = walk->scene->tracer;
    struct lf_ray rays[LF_PATHS];
    uint64_t begin = start_clock(walk->scene);
    walk->ray_count = 0;
    for (uint32_t i = 0; i < w->count; i++) {
        struct lf_ray *ray = &rays[walk->ray_count];
        if (!w->goes[i])
            continue;
        set_ray(w, i, INFINITY, ray);
        if (w->survives[i] || walk->environment || lf_trace_may_shine(tracer, ray))
            walk->lanes[walk->ray_count++] = i;
    }
    lf_trace_closest_many(tracer, rays, walk->ray_count, walk->met, walk->hits);
    for (int stage = 0; stage < 2; stage++)
        for (uint32_t k = 0; k < walk->ray_count; k++)
            if (walk->met[k] && w->survives[walk->lanes[k]])
                lf_surface_prefetch(tracer, &walk->hits[k], stage);
    walk->scene->stats->path_rays += walk->ray_count;
    stop_clock(walk->scene, begin, &walk->scene->stats->path_ns);
}

// Light of lights that a ray met; `next` becomes the surface that it met. False if the path ends there.
static bool look_around(struct walk *walk, uint32_t ray, struct lf_surface *next)
{
    uint32_t lane = walk->lanes[ray];
    bool met = walk->met[ray];
    const struct lf_wave *w = &walk->wave;
    const struct lf_tracer *tracer = walk->scene->tracer;
    const struct lf_hit *hit = &walk->hits[ray];
    struct lf_radiance *radiance = radiance_of(walk, lane);
    struct look look = look_from(walk, lane);
    if (met)
        add_coinciding(walk, lane, hit, &look);
    else
        add_met_environments(&look);
    carry(w, lane, look.seen, walk->bounce ? radiance->indirect : radiance->direct);
    if (!met || (!w->survives[lane] && !lf_surface_may_shine(tracer, hit)))
        return false;
    lf_surface_seen_at(tracer, hit, look.direction, next);
    if (!next->unlit)
        carry(w, lane, next->emission, radiance->indirect);
    return w->survives[lane] && !lf_surface_is_black(next);
}

// Where a path stays in the wave, now that those before it have closed up.
static void move_lane(struct walk *walk, uint32_t from, uint32_t to)
{
    struct lf_wave *w = &walk->wave;
    walk->path[to] = walk->path[from];
    w->pixel[to] = w->pixel[from];
    w->reversed[to] = w->reversed[from];
    w->rng_state[to] = w->rng_state[from];
    w->rng_stream[to] = w->rng_stream[from];
    for (int c = 0; c < 3; c++)
        w->throughput[c][to] = w->throughput[c][from] * w->boost[from];
}

static void arrive_all(struct walk *walk)
{
    struct lf_wave *w = &walk->wave;
    uint32_t count = 0;
    for (uint32_t k = 0; k < walk->ray_count; k++) {
        struct lf_surface next;
        float came[3];
        if (!look_around(walk, k, &next))
            continue;
        take_lane(w->direction, walk->lanes[k], came);
        move_lane(walk, walk->lanes[k], count);
        arrive(w, count++, &next, came);
    }
    w->count = count;
}

// ---- paths -----------------------------------------------------------------------------------------------
// What a camera ray sees of lights.
struct sight {
    const struct ng_snapshot *snapshot;
    const struct lf_ray *ray;
    float *emission;
};

static void see_light(const struct sight *sight, uint32_t light, const struct ng_light_hit *hit)
{
    float seen[3];
    ng_light_seen_at(&sight->snapshot->lights[light].source, hit, seen);
    lf_mad(sight->emission, seen, 1, sight->emission);
}

static void see_emitter(void *user, const struct lf_hit *hit)
{
    const struct sight *sight = user;
    struct ng_light_hit seen = light_hit(sight->snapshot, sight->ray->origin, sight->ray->direction, hit);
    see_light(sight, sight->snapshot->instances[hit->instance].light, &seen);
}

void lf_path_begin(const struct lf_path_scene *scene, const struct lf_ray *ray, const uint32_t pixel[2],
                   struct lf_primary *out)
{
    const struct ng_snapshot *snapshot = scene->lights->snapshot;
    struct sight sight = {snapshot, ray, out->emission};
    struct ng_light_hit nothing = {.distance = INFINITY};
    *out = (struct lf_primary){.ray = *ray};
    scene->stats->path_rays++;
    out->met = lf_trace_pixel(scene->tracer, ray, LF_RAY_CAMERA, pixel, &out->hit);
    if (out->met) {
        lf_surface_seen_at(scene->tracer, &out->hit, ray->direction, &out->surface);
        memcpy(out->emission, out->surface.emission, sizeof out->emission);
        lf_trace_coinciding(scene->tracer, ray, &out->hit, see_emitter, &sight);
    } else if (snapshot->environment != NG_NONE) {
        memcpy(nothing.direction, ray->direction, sizeof nothing.direction);
        see_light(&sight, snapshot->environment, &nothing);
    }
}

static void start_lane(struct walk *walk, uint32_t path)
{
    struct lf_wave *w = &walk->wave;
    const struct lf_primary *primary = walk->paths[path].primary;
    const struct lf_sampler *sampler = &walk->paths[path].sampler;
    uint32_t lane = w->count++;
    walk->path[lane] = path;
    w->sampler = sampler->kind;
    w->draw = sampler->draw;
    w->pixel[lane] = sampler->pixel;
    w->reversed[lane] = sampler->reversed;
    w->rng_state[lane] = sampler->rng.state;
    w->rng_stream[lane] = sampler->rng.stream;
    for (int c = 0; c < 3; c++)
        w->throughput[c][lane] = 1;
    arrive(w, lane, &primary->surface, primary->ray.direction);
}

static void start_walk(struct walk *walk, const struct lf_path_scene *scene, struct lf_path *paths,
                       uint32_t count)
{
    const struct ng_snapshot *snapshot = scene->lights->snapshot;
    memset(walk, 0, sizeof *walk);
    walk->scene = scene;
    walk->paths = paths;
    walk->wave.lights = scene->lights;
    walk->wave.scene_radius = snapshot->scene_radius;
    walk->wave.place_size = snapshot->place_size;
    for (uint32_t i = 0; i < snapshot->light_count; i++)
        walk->environment |= is_environment(&snapshot->lights[i].source);
    for (uint32_t i = 0; i < count; i++) {
        const struct lf_primary *primary = paths[i].primary;
        paths[i].radiance = (struct lf_radiance){0};
        memcpy(paths[i].radiance.emission, primary->emission, sizeof primary->emission);
        if (primary->met && !lf_surface_is_black(&primary->surface))
            start_lane(walk, i);
    }
}

void lf_paths_trace(const struct lf_path_scene *scene, struct lf_path *paths, uint32_t count)
{
    const struct lf_wave_kernels *kernels = scene->kernels ? scene->kernels : lf_wave_kernels_of(0);
    struct walk walk;
    struct lf_wave *w = &walk.wave;
    uint64_t begin = start_clock(scene);
    start_walk(&walk, scene, paths, count < LF_PATHS ? count : LF_PATHS);
    for (; w->count && (!scene->depth || walk.bounce + 2 <= scene->depth); walk.bounce++) {
        kernels->connect(w);
        add_connections(&walk);
        kernels->scatter(w);
        if (walk.bounce == 0)
            see_unshadowed(&walk);
        if (walk.bounce >= FIRST_ROULETTE)
            kernels->play_roulette(w);
        if (walk.bounce + 2 == scene->depth)
            memset(w->survives, 0, sizeof w->survives);
        trace_rays(&walk);
        arrive_all(&walk);
    }
    stop_clock(scene, begin, &scene->stats->total_ns);
}

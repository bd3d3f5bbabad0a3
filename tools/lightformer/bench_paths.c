// Clues are computed as the passes of a frame compute them, light after light, with the inputs that the
// network reads. The network runs by itself, on made-up inputs of two lights. Bare loops come last.
#include "bench_paths.h"

#include "bench_neural.h"
#include "bench_pace.h"
#include "opening.h"

#include "app/stage.h"
#include "base/jobs.h"
#include "base/log.h"
#include "base/rng.h"
#include "base/system.h"
#include "lightformer/dataset/capture.h"
#include "lightformer/neural/neural.h"
#include "lightformer/reference/reference.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define SHARE        0.08 // of the time that is given
#define MOST_ROUNDS  5u
#define NET_LIGHTS   2u // as many as lights of Chess
#define BARE_SECONDS 0.25
#define RAYS         65536u
#define COPY_BYTES   ((size_t)64 << 20) // more than a cache holds
#define COPY_PART    ((uint32_t)1 << 20)

// What a pixel's planes take: position, normal, diffuse and specular of the G-buffer, and what is written.
#define PIXEL_BYTES (16 + 3 * 8 + 29 * 4)

struct session {
    const struct bench_neural_params *params;
    struct ng_stage *stage;
    struct lf_capture *capture;
    struct lf_captured_frame seen;
    struct lf_tracer *tracer;
    struct lf_net *net;
    struct lf_pixel_clues *pixels;
    struct lf_light_clues *light;
    atomic_uint_fast64_t rays;
    double ms[LF_CLUES_STAGES], amount[LF_CLUES_STAGES]; // sums over lights and rounds
};

static const struct {
    const char *name;
    enum bench_bound bound;
} stages[LF_CLUES_STAGES] = {
    [LF_CLUES_PIXELS] = {"planes of the G-buffer", BENCH_BYTES},
    [LF_CLUES_REFLECTION_RAYS] = {"rays of reflections", BENCH_LONE_RAYS},
    [LF_CLUES_TEXELS] = {"RSM", BENCH_RAY_PACKETS},
    [LF_CLUES_SHADOW_DISTANCE] = {"shadow distances", BENCH_RAY_PACKETS},
    [LF_CLUES_DIRECT] = {"unshadowed direct light", BENCH_BOUNDS},
    [LF_CLUES_VISIBILITY] = {"visibility", BENCH_RAY_PACKETS},
    [LF_CLUES_SPECULAR_VISIBILITY] = {"specular visibility", BENCH_RAY_PACKETS},
    [LF_CLUES_RSM_GATHER] = {"RSM gather", BENCH_BOUNDS},
    [LF_CLUES_HEMISPHERE_GATHER] = {"hemisphere gather", BENCH_LONE_RAYS},
    [LF_CLUES_REFLECTED_LIGHT] = {"reflections lit", BENCH_LONE_RAYS},
};

// ---- The scene -------------------------------------------------------------------------------------------

static ng_result load_net(struct session *s)
{
    char found[4096];
    const char *weights = s->params->weights;
    if (!weights && lf_neural_find_weights(s->params->scene, found, sizeof found))
        weights = found;
    NG_REQUIRE(weights, "the frames before this had weights");
    return lf_net_load(weights, &s->net);
}

static ng_result open_session(struct session *s)
{
    struct ng_stage_params stage = {
        .scene = s->params->scene, .device = s->params->device, .threads = s->params->threads};
    opening_apply(s->params->opening, &stage);
    NG_TRY(load_net(s));
    NG_TRY(ng_stage_create(&stage, &s->stage));
    NG_TRY(ng_stage_seek(s->stage, 0, NULL));
    NG_TRY(lf_capture_create(s->stage->gpu, s->stage->jobs, &s->capture));
    NG_TRY(lf_capture_frame(s->capture,
                            &(struct lf_capture_params){.snapshot = s->stage->snapshot,
                                                        .width = s->params->width,
                                                        .height = s->params->height,
                                                        .pixels_only = true},
                            &s->seen));
    NG_TRY(lf_tracer_create(&s->tracer));
    NG_TRY(lf_tracer_update(s->tracer, s->stage->snapshot));
    NG_TRY(lf_pixel_clues_create(&s->pixels));
    return lf_light_clues_create(&s->light);
}

static void close_session(struct session *s)
{
    lf_light_clues_destroy(&s->light);
    lf_pixel_clues_destroy(&s->pixels);
    lf_tracer_destroy(&s->tracer);
    lf_capture_destroy(&s->capture);
    ng_stage_destroy(&s->stage);
    lf_net_destroy(&s->net);
}

// ---- Clues -----------------------------------------------------------------------------------------------

// A part of the clues is over when it asks whether to go on: what was cast since the last time is its own.
struct counting {
    struct session *session;
    enum lf_clues_stage order[LF_CLUES_STAGES];
    uint32_t stage;
};

static void count_rays(void *user, uint32_t rays)
{
    struct counting *c = user;
    atomic_fetch_add_explicit(&c->session->rays, rays, memory_order_relaxed);
}

static void end_part(struct counting *c)
{
    if (c->stage < LF_CLUES_STAGES)
        c->session->amount[c->order[c->stage++]] += (double)atomic_exchange(&c->session->rays, 0);
}

static bool part_is_over(const void *user)
{
    end_part(*(struct counting *const *)user);
    return false;
}

static void add_times(struct session *s, double (*ms)(const struct session *s, enum lf_clues_stage stage))
{
    for (int i = 0; i < LF_CLUES_STAGES; i++)
        s->ms[i] += ms(s, (enum lf_clues_stage)i);
}

static double pixels_ms(const struct session *s, enum lf_clues_stage stage)
{
    return lf_pixel_clues_ms(s->pixels, stage);
}

static double light_ms(const struct session *s, enum lf_clues_stage stage)
{
    return lf_light_clues_ms(s->light, stage);
}

static ng_result encode_light(struct session *s, struct lf_clues_scene *scene, struct counting *c,
                              uint32_t light)
{
    *c = (struct counting){.session = s,
                           .order = {LF_CLUES_SHADOW_DISTANCE, LF_CLUES_DIRECT, LF_CLUES_VISIBILITY,
                                     LF_CLUES_SPECULAR_VISIBILITY, LF_CLUES_RSM_GATHER,
                                     LF_CLUES_HEMISPHERE_GATHER, LF_CLUES_REFLECTED_LIGHT}};
    NG_TRY(lf_clues_light(scene, light, NULL, s->light));
    s->amount[LF_CLUES_TEXELS] += (double)atomic_exchange(&s->rays, 0);
    NG_TRY(lf_clues_view(scene, s->pixels, s->light));
    end_part(c);
    add_times(s, light_ms);
    return NG_OK;
}

static ng_result encode(struct session *s)
{
    struct counting counting = {
        .session = s, .order = {LF_CLUES_PIXELS, LF_CLUES_REFLECTION_RAYS, LF_CLUES_HEMISPHERE_GATHER}};
    struct counting *c = &counting;
    struct lf_clues_scene scene = {.tracer = s->tracer,
                                   .jobs = s->stage->jobs,
                                   .reads = lf_clues_reads(s->net),
                                   .abandon = part_is_over,
                                   .abandon_user = &c,
                                   .count_rays = count_rays,
                                   .count_user = c};
    NG_TRY(lf_clues_pixels(&scene,
                           &(struct lf_clues_pixels_params){.gbuffer = s->seen.gbuffer,
                                                            .width = s->params->width,
                                                            .height = s->params->height},
                           s->pixels));
    add_times(s, pixels_ms);
    for (uint32_t i = 0; i < s->stage->snapshot->light_count; i++)
        if (s->stage->snapshot->lights[i].power > 0)
            NG_TRY(encode_light(s, &scene, c, i));
    return NG_OK;
}

static void add_path(struct bench_paths *out, const char *name, enum bench_bound bound, double ms,
                     double amount)
{
    out->paths[out->count++] = (struct bench_path){name, bound, ms, amount};
}

static ng_result measure_clues(struct session *s, struct bench_paths *out)
{
    struct bench_pace pace;
    uint32_t most = s->params->frames < MOST_ROUNDS ? s->params->frames : MOST_ROUNDS;
    NG_TRY(encode(s)); // memory grows once
    memset(s->ms, 0, sizeof s->ms);
    memset(s->amount, 0, sizeof s->amount);
    bench_pace_begin(&pace, "clues", most, SHARE * s->params->seconds);
    for (uint32_t round = 0; bench_pace_next(&pace, round); round++)
        NG_TRY(encode(s));
    s->amount[LF_CLUES_PIXELS] = (double)PIXEL_BYTES * s->params->width * s->params->height * pace.done;
    for (int i = 0; i < LF_CLUES_STAGES; i++)
        if (stages[i].name) // what is of all lights together is a pass of the frame's budget
            add_path(out, stages[i].name, stages[i].bound, s->ms[i] / pace.done, s->amount[i] / pace.done);
    return NG_OK;
}

// ---- Bare loops ------------------------------------------------------------------------------------------

struct bare {
    const struct lf_tracer *tracer;
    struct lf_ray *rays; // of neighbouring pixels: to what they see; or of random ones, off it
    unsigned char *from, *to;
};

static void trace_alone(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct bare *b = user;
    lf_trace_bare(b->tracer, b->rays + begin, end - begin);
}

static void trace_packets(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct bare *b = user;
    for (uint32_t at = begin * LF_PACKET; at < end * LF_PACKET; at += LF_PACKET) {
        struct lf_packet packet = {.passes = UINT32_MAX};
        for (int i = 0; i < LF_PACKET; i++) {
            const struct lf_ray *ray = &b->rays[at + (uint32_t)i];
            for (int c = 0; c < 3; c++) {
                packet.origin[c][i] = ray->origin[c];
                packet.direction[c][i] = ray->direction[c];
            }
            packet.far[i] = ray->far;
        }
        lf_trace_packet(b->tracer, &packet, NULL);
    }
}

static void copy_parts(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct bare *b = user;
    for (uint32_t i = begin; i < end; i++)
        memcpy(b->to + (size_t)i * COPY_PART, b->from + (size_t)i * COPY_PART, COPY_PART);
}

// How often a second `work` over `count` is done, times `amount`.
static double speed_of(struct ng_jobs *jobs, struct bare *b, ng_jobs_fn work, uint32_t count, uint32_t grain,
                       double amount)
{
    uint64_t begin = ng_clock_ns();
    double done = 0, seconds;
    do {
        ng_jobs_for(jobs, count, grain, work, b);
        done += amount;
        seconds = (double)(ng_clock_ns() - begin) * 1e-9;
    } while (seconds < BARE_SECONDS);
    return done / seconds;
}

// From the eye through a pixel to what it shows.
static void aim_at(const struct session *s, uint32_t pixel, struct lf_ray *ray)
{
    const float *at = s->seen.gbuffer.position + (size_t)pixel * 4;
    float length = 0;
    for (int c = 0; c < 3; c++) {
        ray->origin[c] = s->seen.eye[c];
        ray->direction[c] = at[c] - s->seen.eye[c];
        length += ray->direction[c] * ray->direction[c];
    }
    for (int c = 0; c < 3; c++)
        ray->direction[c] /= sqrtf(length);
    ray->far = at[3] > 0 || at[3] < 0 ? INFINITY : 0;
}

// Blocks of 4 x 4 pixels, from the middle of the picture on.
static void make_packets(const struct session *s, struct lf_ray *rays)
{
    uint32_t width = s->params->width, height = s->params->height, columns = width / 4 ? width / 4 : 1,
             rows = height / 4 ? height / 4 : 1;
    for (uint32_t i = 0; i < RAYS; i++) {
        uint32_t block = (i / LF_PACKET + rows / 2 * columns) % (columns * rows), lane = i % LF_PACKET;
        uint32_t x = block % columns * 4 + lane % 4, y = block / columns * 4 + lane / 4;
        aim_at(s, (y < height ? y : height - 1) * width + (x < width ? x : width - 1), &rays[i]);
    }
}

static void make_lone(const struct session *s, struct lf_ray *rays)
{
    struct ng_rng rng = ng_rng_make(1, 2);
    uint32_t pixels = s->params->width * s->params->height;
    const float *normal = lf_pixel_clues_values(s->pixels)->of[LF_INPUT_PIXEL_NORMAL];
    for (uint32_t i = 0; i < RAYS; i++) {
        size_t pixel = ng_rng_below(&rng, pixels);
        const float *at = s->seen.gbuffer.position + pixel * 4;
        float z = ng_rng_range(&rng, -1, 1), phi = ng_rng_range(&rng, 0, 6.2831853f), r = sqrtf(1 - z * z);
        const float d[3] = {r * cosf(phi), r * sinf(phi), z};
        float n[3], side = 0;
        for (size_t c = 0; c < 3; c++) {
            n[c] = normal ? normal[c * pixels + pixel] : 0;
            side += n[c] * d[c];
        }
        for (int c = 0; c < 3; c++)
            rays[i].direction[c] = side < 0 ? -d[c] : d[c];
        lf_trace_origin(s->tracer, at, n, rays[i].direction, rays[i].origin);
        rays[i].far = INFINITY;
    }
}

static ng_result measure_bounds(const struct session *s, struct bench_paths *out)
{
    struct ng_jobs *jobs = s->stage->jobs;
    struct bare b = {.tracer = s->tracer,
                     .rays = calloc(RAYS, sizeof *b.rays),
                     .from = calloc(COPY_BYTES, 1),
                     .to = malloc(COPY_BYTES)};
    ng_result result = NG_OK;
    if (b.rays && b.from && b.to) {
        make_packets(s, b.rays);
        out->bounds[BENCH_RAY_PACKETS] = speed_of(jobs, &b, trace_packets, RAYS / LF_PACKET, 64, RAYS);
        make_lone(s, b.rays);
        out->bounds[BENCH_LONE_RAYS] = speed_of(jobs, &b, trace_alone, RAYS, 1024, RAYS);
        memset(b.to, 1, COPY_BYTES);
        memset(b.from, 1, COPY_BYTES);
        out->bounds[BENCH_BYTES] =
            speed_of(jobs, &b, copy_parts, (uint32_t)(COPY_BYTES / COPY_PART), 1, 2.0 * (double)COPY_BYTES);
    } else {
        result = ng_out_of_memory("measurements");
    }
    free(b.rays);
    free(b.from);
    free(b.to);
    return result;
}

// ---- The network -----------------------------------------------------------------------------------------

static ng_result measure_network(const struct session *s, struct bench_paths *out)
{
    static const char *const names[BENCH_NET_STAGES] = {"network on lights", "network on views", "gather"};
    char found[4096];
    const struct bench_neural_params *p = s->params;
    struct bench_net_params net = {.network = p->weights,
                                   .size = {p->width, p->height},
                                   .lights = NET_LIGHTS,
                                   .frames = p->frames < MOST_ROUNDS ? p->frames : MOST_ROUNDS,
                                   .threads = p->threads};
    if (!net.network && lf_neural_find_weights(p->scene, found, sizeof found))
        net.network = found;
    NG_TRY(bench_net_measure_shares(&net, &out->products));
    out->bounds[BENCH_PRODUCTS] = out->products.peak * 1e9;
    for (int i = 0; i < BENCH_NET_STAGES; i++)
        add_path(out, names[i], BENCH_PRODUCTS, out->products.stages[i].ms,
                 out->products.stages[i].gflop * 1e9);
    return NG_OK;
}

ng_result bench_paths_measure(const struct bench_neural_params *params, struct bench_paths *out)
{
    struct session s = {.params = params};
    *out = (struct bench_paths){0};
    ng_result result = open_session(&s);
    if (result == NG_OK)
        result = measure_clues(&s, out);
    if (result == NG_OK)
        result = measure_bounds(&s, out);
    if (result == NG_OK)
        result = measure_network(&s, out);
    close_session(&s);
    return result;
}

// ---- Telling ---------------------------------------------------------------------------------------------

static const struct {
    const char *name, *unit;
    double scale;
} bounds[BENCH_BOUNDS] = {
    [BENCH_LONE_RAYS] = {"rays one by one", "Mrays/s", 1e-6},
    [BENCH_RAY_PACKETS] = {"packets of rays", "Mrays/s", 1e-6},
    [BENCH_PRODUCTS] = {"multiplications", "GFLOP/s", 1e-9},
    [BENCH_BYTES] = {"copying", "GB/s", 1e-9},
};

static double speed(const struct bench_path *p)
{
    return p->ms > 0 ? p->amount / p->ms * 1e3 : 0;
}

void bench_paths_print(const struct bench_paths *b)
{
    printf("\n%-28s %10s %10s %8s   %-24s %8s\n", "work by itself", "ms", "a second", "",
           "bound: the bare loop of", "share");
    for (uint32_t i = 0; i < b->count; i++) {
        const struct bench_path *p = &b->paths[i];
        printf("%-28s %10.2f", p->name, p->ms);
        if (p->bound < BENCH_BOUNDS)
            printf(" %10.2f %8s   %-16s %7.1f %7.0f%%", speed(p) * bounds[p->bound].scale,
                   bounds[p->bound].unit, bounds[p->bound].name, b->bounds[p->bound] * bounds[p->bound].scale,
                   100 * speed(p) / b->bounds[p->bound]);
        putchar('\n');
    }
}

void bench_paths_write(const struct bench_paths *b, struct json *j)
{
    json_array(j, "work");
    for (uint32_t i = 0; i < b->count; i++) {
        const struct bench_path *p = &b->paths[i];
        json_object(j, NULL);
        json_text(j, "name", p->name);
        json_number(j, "ms", p->ms);
        if (p->bound < BENCH_BOUNDS) {
            json_text(j, "bound", bounds[p->bound].name);
            json_number(j, "a_second", speed(p));
            json_number(j, "bound_a_second", b->bounds[p->bound]);
        }
        json_end(j);
    }
    json_end(j);
}

// The i-th kernel that this CPU has.
bool bench_paths_ratio(const struct bench_paths *b, uint32_t index, char *name, size_t size, double *value)
{
    for (int i = LF_KERNEL_PLAIN; i <= LF_KERNEL_AMX; i++) {
        if (b->products.of[i] <= 0 || index-- > 0)
            continue;
        snprintf(name, size, "neural:products to the peak of %s", lf_net_kernel_name((enum lf_net_kernel)i));
        *value = b->products.of[i];
        return true;
    }
    return false;
}

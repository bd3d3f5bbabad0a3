// A picture is made in passes: every pass adds some samples to all pixels, tile by tile over the jobs.
// Between passes the picture is whole, so that this is where it is looked at, kept in a checkpoint, or
// stopped. Passes are sized to take about a second.
#include "lightformer/reference/reference.h"

#include "base/file.h"
#include "base/jobs.h"
#include "base/log.h"
#include "base/system.h"
#include "lightformer/reference/reference_internal.h"
#include "lightformer/trace/vec.h"
#include "render/subpixel.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define TILE         8 // small, so that at the end of a pass no thread waits long for the others
#define PASS_SECONDS 1.0
#define MAX_SIDE     16384

// A square of pixels, and what happened in its last pass.
struct lf_tile {
    struct lf_path_stats stats;
    bool failed; // a sample was not a number:
    uint32_t x, y, sample;
};

static uint32_t tiles_along(uint32_t pixels)
{
    return (pixels + TILE - 1) / TILE;
}

static bool region_fits(const struct lf_region *r, uint32_t width, uint32_t height)
{
    return r->width && r->height && r->x < width && r->y < height && r->width <= width - r->x &&
           r->height <= height - r->y;
}

// The layers and the file that are made of the sums take about as much as these.
static ng_result check_memory(const struct lf_region *region)
{
    uint64_t need = 2 * (uint64_t)region->width * region->height * sizeof(struct lf_sums);
    uint64_t available = ng_system_available_memory();
    if (need <= available)
        return NG_OK;
    ng_log_error("reference: %u x %u pixels need %" PRIu64 " MiB of memory, of which %" PRIu64
                 " MiB are left; make the picture smaller",
                 region->width, region->height, need >> 20, available >> 20);
    return NG_ERROR_MEMORY;
}

ng_result lf_reference_create(const struct lf_reference_params *params, struct lf_reference **out)
{
    *out = NULL;
    NG_REQUIRE(params->width && params->height && params->width <= MAX_SIDE && params->height <= MAX_SIDE,
               "a picture has 1 to %d pixels a side", MAX_SIDE);
    struct lf_region region = params->region;
    if (!region.width && !region.height)
        region = (struct lf_region){.width = params->width, .height = params->height};
    NG_REQUIRE(region_fits(&region, params->width, params->height), "the region lies in the picture");
    NG_TRY(check_memory(&region));
    struct lf_reference *r = calloc(1, sizeof *r);
    if (!r)
        return ng_out_of_memory("reference");
    r->params = *params;
    r->params.region = region;
    r->tile_count = tiles_along(region.width) * tiles_along(region.height);
    r->sums = calloc(lf_pixel_count(r), sizeof *r->sums);
    r->tiles = calloc(r->tile_count, sizeof *r->tiles);
    if (!r->sums || !r->tiles) {
        ng_log_error("reference: out of memory for %u x %u pixels (%zu MiB)", region.width, region.height,
                     lf_pixel_count(r) * sizeof *r->sums >> 20);
        lf_reference_destroy(&r);
        return NG_ERROR_MEMORY;
    }
    *out = r;
    return NG_OK;
}

void lf_reference_destroy(struct lf_reference **reference)
{
    struct lf_reference *r = *reference;
    *reference = NULL;
    if (!r)
        return;
    lf_light_choice_finish(&r->lights);
    free(r->sums);
    free(r->tiles);
    free(r);
}

ng_result lf_reference_begin(struct lf_reference *r, const struct lf_tracer *tracer)
{
    const struct ng_snapshot *snapshot = lf_tracer_snapshot(tracer);
    NG_REQUIRE(snapshot, "the tracer has been updated");
    r->tracer = tracer;
    r->samples = 0;
    r->stats = (struct lf_path_stats){0};
    r->seconds = 0;
    memset(r->sums, 0, lf_pixel_count(r) * sizeof *r->sums);
    r->camera = ng_camera_rays_of(&snapshot->camera, (float)r->params.width / (float)r->params.height);
    return lf_light_choice_update(&r->lights, snapshot);
}

static uint64_t count_rays(const struct lf_reference *r)
{
    return r->stats.path_rays + r->stats.shadow_rays;
}

struct lf_reference_stats lf_reference_stats_of(const struct lf_reference *r)
{
    return (struct lf_reference_stats){r->samples, r->unsaved, count_rays(r), r->seconds, r->stats};
}

struct lf_ray lf_reference_ray(const struct lf_reference *r, float x, float y)
{
    const struct ng_snapshot_camera *camera = &lf_tracer_snapshot(r->tracer)->camera;
    struct lf_ray ray = {.far = INFINITY};
    float right = 2 * x / (float)r->params.width - 1, down = 2 * y / (float)r->params.height - 1;
    memcpy(ray.origin, camera->position, sizeof ray.origin);
    memcpy(ray.direction, r->camera.forward, sizeof ray.direction);
    float *moved = camera->orthographic ? ray.origin : ray.direction;
    lf_mad(moved, r->camera.right, right, moved);
    lf_mad(moved, r->camera.down, down, moved);
    lf_normalize(ray.direction);
    ray.near = camera->near_plane / lf_dot(ray.direction, r->camera.forward);
    return ray;
}

struct lf_path_scene lf_reference_scene(const struct lf_reference *r, struct lf_path_stats *stats)
{
    return (struct lf_path_scene){.tracer = r->tracer,
                                  .lights = &r->lights,
                                  .depth = r->params.depth,
                                  .timed = r->params.timed,
                                  .stats = stats};
}

// ---- samples ---------------------------------------------------------------------------------------------
struct pass {
    struct lf_reference *reference;
    uint32_t first, count; // samples
};

static void clamp_to(float limit, float rgb[3])
{
    float most = lf_max3(rgb);
    if (limit > 0 && most > limit)
        lf_scale(rgb, limit / most, rgb);
}

static bool add_sample(struct lf_sums *sums, const struct lf_radiance *l)
{
    bool finite = true;
    for (int i = 0; i < 3; i++) {
        double beauty = (double)l->direct[i] + (double)l->indirect[i] + (double)l->emission[i];
        finite &= isfinite(beauty) && isfinite(l->unshadowed[i]);
        sums->direct[i] += (double)l->direct[i];
        sums->unshadowed[i] += (double)l->unshadowed[i];
        sums->indirect[i] += (double)l->indirect[i];
        sums->emission[i] += (double)l->emission[i];
        sums->square[i] += beauty * beauty;
    }
    return finite;
}

// Paths of a tile that wait to be traced together.
struct batch {
    const struct pass *pass;
    struct lf_path_scene scene;
    struct lf_tile *tile;
    uint32_t count;
    struct lf_path paths[LF_PATHS];
    struct lf_primary primaries[LF_PATHS];
    struct {
        uint32_t x, y, sample;
        struct lf_sums *sums;
    } places[LF_PATHS];
};

static void flush(struct batch *b)
{
    lf_paths_trace(&b->scene, b->paths, b->count);
    for (uint32_t i = 0; i < b->count; i++) {
        struct lf_radiance *radiance = &b->paths[i].radiance;
        clamp_to(b->pass->reference->params.clamp, radiance->indirect);
        if (add_sample(b->places[i].sums, radiance) || b->tile->failed)
            continue;
        b->tile->failed = true;
        b->tile->x = b->places[i].x;
        b->tile->y = b->places[i].y;
        b->tile->sample = b->places[i].sample;
    }
    b->count = 0;
}

// The camera's ray of the path, from its own place in the pixel, or the pixel's, which the path before may
// have found already.
static void find_primary(struct batch *b, uint32_t x, uint32_t y, const struct lf_primary *before,
                         struct lf_path *path)
{
    const struct lf_reference *r = b->pass->reference;
    float place[2] = {(float)x + 0.5f, (float)y + 0.5f};
    path->primary = before;
    if (before && !r->params.antialias)
        return;
    if (r->params.antialias) {
        float u[2];
        lf_sampler_2d(&path->sampler, u);
        place[0] += ng_subpixel_tent(u[0]);
        place[1] += ng_subpixel_tent(u[1]);
    }
    struct lf_primary *primary = &b->primaries[b->count];
    struct lf_ray ray = lf_reference_ray(r, place[0], place[1]);
    const uint32_t pixel[2] = {x, y};
    lf_path_begin(&b->scene, &ray, r->params.antialias ? NULL : pixel, primary);
    path->primary = primary;
}

static void sample_pixel(struct batch *b, uint32_t x, uint32_t y, struct lf_sums *sums)
{
    const struct lf_reference_params *p = &b->pass->reference->params;
    const struct lf_primary *primary = NULL;
    for (uint32_t i = b->pass->first; i < b->pass->first + b->pass->count; i++) {
        struct lf_path *path = &b->paths[b->count];
        path->sampler = lf_sampler_start(p->sampler, p->seed, x, y, i);
        find_primary(b, x, y, primary, path);
        primary = path->primary;
        b->places[b->count].x = x;
        b->places[b->count].y = y;
        b->places[b->count].sample = i;
        b->places[b->count].sums = sums;
        if (++b->count < LF_PATHS)
            continue;
        flush(b);
        b->primaries[0] = *primary; // stays for the pixel's other samples
        primary = &b->primaries[0];
    }
}

static void sample_tiles(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    NG_UNUSED(worker);
    const struct pass *pass = user;
    const struct lf_region *region = &pass->reference->params.region;
    uint32_t across = tiles_along(region->width);
    for (uint32_t t = begin; t < end; t++) {
        struct lf_tile *tile = &pass->reference->tiles[t];
        struct batch batch = {.pass = pass, .tile = tile};
        batch.scene = lf_reference_scene(pass->reference, &tile->stats);
        uint32_t x0 = t % across * TILE, y0 = t / across * TILE;
        *tile = (struct lf_tile){0};
        for (uint32_t y = y0; y < y0 + TILE && y < region->height; y++)
            for (uint32_t x = x0; x < x0 + TILE && x < region->width; x++)
                sample_pixel(&batch, region->x + x, region->y + y,
                             &pass->reference->sums[(size_t)y * region->width + x]);
        flush(&batch);
    }
}

static void add_stats(const struct lf_path_stats *from, struct lf_path_stats *to)
{
    to->path_rays += from->path_rays;
    to->shadow_rays += from->shadow_rays;
    to->emitter_rays += from->emitter_rays;
    to->total_ns += from->total_ns;
    to->path_ns += from->path_ns;
    to->shadow_ns += from->shadow_ns;
}

static ng_result run_pass(struct lf_reference *r, uint32_t count)
{
    struct pass pass = {.reference = r, .first = r->samples, .count = count};
    ng_jobs_for(r->params.jobs, r->tile_count, 1, sample_tiles, &pass);
    r->samples += count;
    for (uint32_t i = 0; i < r->tile_count; i++) {
        const struct lf_tile *t = &r->tiles[i];
        add_stats(&t->stats, &r->stats);
        if (t->failed) {
            ng_log_error("reference: radiance is not a number at pixel %u, %u, sample %u, seed %" PRIu64
                         "; look for lights or materials with absurd values",
                         t->x, t->y, t->sample, r->params.seed);
            return NG_ERROR_FORMAT;
        }
    }
    return NG_OK;
}

// ---- runs ------------------------------------------------------------------------------------------------
struct clock {
    uint64_t begin_ns, saved_ns;
    uint32_t first; // samples at the beginning
};

static double seconds_since(uint64_t ns)
{
    return (double)(ng_clock_ns() - ns) * 1e-9;
}

// As many samples as take about a second, by what the run has seen so far; all, if nobody looks in between.
static uint32_t choose_pass(const struct lf_reference *r, const struct lf_reference_run_params *p,
                            const struct clock *clock)
{
    uint32_t left = p->samples - r->samples;
    if (!p->progress && !p->checkpoint && !(p->time_limit > 0))
        return left;
    uint32_t done = r->samples - clock->first;
    if (!done)
        return 1;
    double wanted = PASS_SECONDS * done / fmax(seconds_since(clock->begin_ns), 1e-9);
    uint32_t most = done < UINT32_MAX / 2 ? 2 * done : done; // the first passes are poor clocks
    uint32_t count = wanted < 1 ? 1 : wanted < most ? (uint32_t)wanted : most;
    return count < left ? count : left;
}

static bool report(const struct lf_reference *r, const struct lf_reference_run_params *p,
                   const struct clock *clock)
{
    if (!p->progress)
        return true;
    double seconds = seconds_since(clock->begin_ns);
    double each = seconds / (r->samples - clock->first);
    struct lf_reference_progress progress = {.samples = r->samples,
                                             .target = p->samples,
                                             .seconds = seconds,
                                             .seconds_left = each * (p->samples - r->samples),
                                             .rays = count_rays(r)};
    return p->progress(p->user, &progress);
}

// A disk that is full now may have room again at the next time.
static void save_when_due(struct lf_reference *r, const struct lf_reference_run_params *p,
                          struct clock *clock, bool last)
{
    double interval = p->checkpoint_interval > 0 ? p->checkpoint_interval : 60;
    if (!p->checkpoint || (!last && seconds_since(clock->saved_ns) < interval))
        return;
    clock->saved_ns = ng_clock_ns();
    r->unsaved = lf_checkpoint_write(r, p->checkpoint, p->picture) != NG_OK;
}

ng_result lf_reference_run(struct lf_reference *r, const struct lf_reference_run_params *p)
{
    NG_REQUIRE(r->tracer, "lf_reference_begin comes first");
    if (p->checkpoint && ng_file_exists(p->checkpoint))
        NG_TRY(lf_checkpoint_read(r, p->checkpoint, p->picture));
    uint64_t now = ng_clock_ns();
    struct clock clock = {.begin_ns = now, .saved_ns = now, .first = r->samples};
    bool more = r->samples < p->samples;
    r->unsaved = false;
    while (more) {
        NG_TRY(run_pass(r, choose_pass(r, p, &clock)));
        more = report(r, p, &clock) && r->samples < p->samples &&
               !(p->time_limit > 0 && seconds_since(clock.begin_ns) >= p->time_limit);
        save_when_due(r, p, &clock, !more);
    }
    r->seconds += seconds_since(clock.begin_ns);
    return NG_OK;
}

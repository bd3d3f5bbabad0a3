// What a display shows of a picture, as engine/render/display.h and meter.h do it on the GPU.
#include "base/log.h"
#include "lightformer/reference/reference_internal.h"
#include "render/subpixel.h"
#include "shaders/shared/meter.h"
#include "shaders/shared/tonemap.h"

#include <stdlib.h>
#include <string.h>

#define EDGE       4 // rays a side of a filtered pixel, by which its share of background is found
#define SEEN_LEAST (1.0f / (EDGE * EDGE))

static float luminance_of(const struct lf_sums *s, uint32_t samples, bool whole)
{
    float rgb[3];
    for (int i = 0; i < 3; i++)
        rgb[i] = (float)((s->direct[i] + s->emission[i] + (whole ? s->indirect[i] : 0)) / samples);
    return ng_meter_luminance(rgb[0], rgb[1], rgb[2]);
}

// A part of a pixel, and how much light comes from there.
struct part {
    float share, luminance;
};

// Parts that are no lit surface: where none is seen, but perhaps an environment, and where one is unlit.
struct shares {
    struct part open, unlit;
};

static void add_sight(const struct lf_reference *r, struct lf_path_scene *scene, const float at[2],
                      const uint32_t pixel[2], float weight, struct shares *sum)
{
    struct lf_primary primary;
    struct lf_ray ray = lf_reference_ray(r, at[0], at[1]);
    lf_path_begin(scene, &ray, pixel, &primary);
    struct part *part = !primary.met ? &sum->open : primary.surface.unlit ? &sum->unlit : NULL;
    if (!part)
        return;
    part->share += weight;
    part->luminance +=
        weight * ng_meter_luminance(primary.emission[0], primary.emission[1], primary.emission[2]);
}

// All or nothing, unless a filter goes over the pixel.
static struct shares find_shares(const struct lf_reference *r, struct lf_path_scene *scene, uint32_t x,
                                 uint32_t y)
{
    const uint32_t pixel[2] = {x, y};
    const float center[2] = {(float)x + 0.5f, (float)y + 0.5f};
    struct shares sum = {0};
    if (!r->params.antialias)
        add_sight(r, scene, center, pixel, 1, &sum);
    for (int i = 0; r->params.antialias && i < EDGE * EDGE; i++) {
        const int column = i % EDGE, row = i / EDGE;
        float u = ((float)column + 0.5f) / EDGE, v = ((float)row + 0.5f) / EDGE;
        const float at[2] = {center[0] + ng_subpixel_tent(u), center[1] + ng_subpixel_tent(v)};
        add_sight(r, scene, at, NULL, 1.0f / (EDGE * EDGE), &sum);
    }
    return sum;
}

// Whether pixels are looked at once more.
static bool needs_shares(const struct lf_reference *r)
{
    const struct ng_snapshot *snapshot = lf_tracer_snapshot(r->tracer);
    const struct ng_snapshot_camera *camera = &snapshot->camera;
    const float *background = camera->background;
    if (background[0] > 0 || background[1] > 0 || background[2] > 0 || ng_snapshot_has_unlit(snapshot))
        return true;
    return camera->auto_exposure && (r->params.antialias || snapshot->environment != NG_NONE);
}

// Of every pixel; NULL if each is whole.
static ng_result find_all_shares(const struct lf_reference *r, struct shares **out)
{
    const struct lf_region *region = &r->params.region;
    struct lf_path_stats stats = {0};
    struct lf_path_scene scene = lf_reference_scene(r, &stats);
    *out = NULL;
    if (!needs_shares(r))
        return NG_OK;
    *out = malloc(lf_pixel_count(r) * sizeof **out);
    if (!*out)
        return ng_out_of_memory("what is seen through the pixels");
    for (size_t i = 0; i < lf_pixel_count(r); i++)
        (*out)[i] = find_shares(r, &scene, region->x + (uint32_t)(i % region->width),
                                region->y + (uint32_t)(i / region->width));
    return NG_OK;
}

// What a meter counts of a pixel (NG_METER_*): a part of one, as bright as it would be alone. So thin things
// have the exposure that they have unfiltered.
static struct part find_metered(const struct lf_reference *r, const struct shares *shares, size_t pixel,
                                int which)
{
    struct shares s = shares ? shares[pixel] : (struct shares){0};
    struct part part = s.open;
    if (which != NG_METER_SKY) {
        part.share = 1 - s.open.share - s.unlit.share;
        part.luminance = luminance_of(&r->sums[pixel], r->samples, which == NG_METER_WHOLE) -
                         s.open.luminance - s.unlit.luminance;
    }
    if (part.share < SEEN_LEAST)
        return (struct part){0};
    return (struct part){part.share, part.luminance / part.share};
}

struct metered {
    float exposure, total; // pixels
};

static struct metered measure(const struct lf_reference *r, const struct shares *shares, int which)
{
    float counts[NG_METER_BINS] = {0};
    float total = 0, before = 0, sum = 0, counted = 0;
    for (size_t i = 0; r->samples && i < lf_pixel_count(r); i++) {
        struct part part = find_metered(r, shares, i, which);
        if (part.luminance > 0)
            counts[(uint32_t)ng_meter_bin(part.luminance)] += part.share;
    }
    for (int i = 0; i < NG_METER_BINS; i++)
        total += counts[i];
    for (int i = 0; i < NG_METER_BINS; i++) {
        float share = ng_meter_share(before, counts[i], total);
        before += counts[i];
        counted += share;
        sum += share * (float)i;
    }
    return (struct metered){ng_meter_exposure(sum, counted), total};
}

static float find_exposure(const struct lf_reference *r, const struct shares *shares)
{
    const struct ng_snapshot_camera *camera = &lf_tracer_snapshot(r->tracer)->camera;
    if (!camera->auto_exposure)
        return camera->exposure;
    struct metered direct = measure(r, shares, NG_METER_DIRECT), whole = measure(r, shares, NG_METER_WHOLE),
                   sky = measure(r, shares, NG_METER_SKY);
    return camera->exposure * ng_meter_picture(ng_meter_both(direct.exposure, whole.exposure), sky.exposure,
                                               whole.total / fmaxf(whole.total + sky.total, 1));
}

// Linear light of a display.
static void tone_map(const float rgb[3], float exposure, float out[3])
{
    float x[3], peak = 0, toe = INFINITY;
    for (int i = 0; i < 3; i++) {
        x[i] = fmaxf(rgb[i] * exposure, 0);
        peak = fmaxf(peak, x[i]);
        toe = fminf(toe, x[i]);
    }
    for (int i = 0; i < 3; i++)
        out[i] = ng_tonemap(x[i], peak, toe);
}

static void show(const struct lf_reference *r, const struct shares *shares, const float *beauty, uint8_t *out)
{
    const float *background = lf_tracer_snapshot(r->tracer)->camera.background;
    float exposure = find_exposure(r, shares);
    for (size_t i = 0; i < lf_pixel_count(r); i++, beauty += 3, out += 4) {
        float shown[3];
        struct shares part = shares ? shares[i] : (struct shares){0};
        tone_map(beauty, exposure + (1 - exposure) * part.unlit.share, shown);
        for (int c = 0; c < 3; c++) {
            shown[c] += (beauty[c] - shown[c]) * part.unlit.share; // as it is, where all of it is unlit
            out[c] = (uint8_t)(ng_srgb_encode(shown[c] + part.open.share * background[c]) * 255.0f + 0.5f);
        }
        out[3] = 255;
    }
}

ng_result lf_reference_display(const struct lf_reference *r, uint8_t **rgba)
{
    struct lf_layer beauty;
    struct shares *shares;
    *rgba = NULL;
    NG_TRY(lf_reference_layer(r, "beauty", &beauty));
    ng_result result = find_all_shares(r, &shares);
    uint8_t *out = result == NG_OK ? malloc(lf_pixel_count(r) * 4) : NULL;
    if (result == NG_OK && !out)
        result = ng_out_of_memory("what a display shows");
    if (out)
        show(r, shares, beauty.pixels, out);
    free(shares);
    free(beauty.pixels);
    *rgba = out;
    return result;
}

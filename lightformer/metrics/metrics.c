// Everything is checked first; then one walk over the pixels gives the means, and a second one the errors.
#include "lightformer/metrics/metrics.h"

#include "base/log.h"
#include "shaders/shared/tonemap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RSE_EPSILON 0.01
#define MIDDLE_GREY 0.18 // where the exposure puts the reference's mean

// ---- Checks

static size_t pixel_count(const struct lf_picture *p)
{
    return (size_t)p->width * p->height;
}

static bool counts(const struct lf_picture *mask, size_t pixel)
{
    if (!mask)
        return true;
    const float *m = &mask->pixels[pixel * 3];
    return m[0] != 0.0f || m[1] != 0.0f || m[2] != 0.0f;
}

static ng_result check_size(const struct lf_picture *p, const struct lf_picture *reference)
{
    if (p->width == reference->width && p->height == reference->height)
        return NG_OK;
    ng_log_error("%s is %u x %u pixels, but %s is %u x %u: only pictures of one size can be compared",
                 p->name, p->width, p->height, reference->name, reference->width, reference->height);
    return NG_ERROR_FORMAT;
}

static ng_result check_kind(const struct lf_picture *p, const struct lf_picture *reference)
{
    if (p->display == reference->display)
        return NG_OK;
    const struct lf_picture *png = p->display ? p : reference, *exr = p->display ? reference : p;
    ng_log_error("%s is tone-mapped and %s is radiance: compare two PNG or two OpenEXR files", png->name,
                 exr->name);
    return NG_ERROR_FORMAT;
}

static ng_result check_finite(const struct lf_picture *p, const struct lf_picture *mask)
{
    size_t bad = 0, first = 0;
    for (size_t i = 0; i < pixel_count(p); i++) {
        const float *x = &p->pixels[i * 3];
        if (counts(mask, i) && !(isfinite(x[0]) && isfinite(x[1]) && isfinite(x[2])) && bad++ == 0)
            first = i;
    }
    if (bad == 0)
        return NG_OK;
    const float *x = &p->pixels[first * 3];
    ng_log_error("%s: pixel (%zu, %zu) is %g %g %g; pixels that are not finite: %zu", p->name,
                 first % p->width, first / p->width, (double)x[0], (double)x[1], (double)x[2], bad);
    return NG_ERROR_FORMAT;
}

static ng_result check_picture(const struct lf_metrics_params *params, const struct lf_picture *p)
{
    NG_TRY(check_size(p, params->b));
    NG_TRY(check_kind(p, params->b));
    return check_finite(p, params->mask);
}

static ng_result count_pixels(const struct lf_metrics_params *params, uint64_t *out)
{
    *out = 0;
    for (size_t i = 0; i < pixel_count(params->b); i++)
        *out += counts(params->mask, i);
    if (*out > 0)
        return NG_OK;
    ng_log_error("%s: the mask is 0 everywhere, so that no pixel is left to compare", params->mask->name);
    return NG_ERROR_FORMAT;
}

// ---- Means

struct means {
    double a, b;
};

// One value of the reference: the mean of both where there are two.
static double reference_value(const struct lf_metrics_params *params, size_t i)
{
    double b = (double)params->b->pixels[i];
    return params->b2 ? 0.5 * (b + (double)params->b2->pixels[i]) : b;
}

static ng_result compute_means(const struct lf_metrics_params *params, uint64_t pixels, struct means *out)
{
    *out = (struct means){0};
    for (size_t i = 0; i < pixel_count(params->b) * 3; i++) {
        if (!counts(params->mask, i / 3))
            continue;
        out->a += (double)params->a->pixels[i];
        out->b += reference_value(params, i);
    }
    out->a /= (double)pixels * 3.0;
    out->b /= (double)pixels * 3.0;
    if (out->b > 0.0)
        return NG_OK;
    ng_log_error("%s: the mean is %g, but errors are relative to a reference's light, which must be positive",
                 params->b->name, out->b);
    return NG_ERROR_FORMAT;
}

// ---- Errors

// Radiance as a display shows it, 0..1.
static void show(const double rgb[3], double exposure, bool display, double out[3])
{
    float x[3], peak = 0.0f, toe = INFINITY;
    for (int c = 0; c < 3; c++) {
        x[c] = fmaxf((float)(rgb[c] * exposure), 0.0f);
        peak = fmaxf(peak, x[c]);
        toe = fminf(toe, x[c]);
    }
    for (int c = 0; c < 3; c++)
        out[c] = (double)ng_srgb_encode(display ? x[c] : ng_tonemap(x[c], peak, toe));
}

// Squared difference of one pixel as shown, summed over the channels.
static double shown_error(const double a[3], const double b[3], double exposure, bool display)
{
    double x[3], y[3], sum = 0;
    show(a, exposure, display, x);
    show(b, exposure, display, y);
    for (int c = 0; c < 3; c++)
        sum += (x[c] - y[c]) * (x[c] - y[c]);
    return sum;
}

// (A - B)^2 / (B^2 + epsilon) of one channel over the reference's mean; of two references each takes one of
// the factors, so that the expected product has none of their variance.
static double relative_error(const struct lf_metrics_params *params, size_t i, double mean)
{
    double a = (double)params->a->pixels[i] / mean, b = reference_value(params, i) / mean;
    double b1 = (double)params->b->pixels[i] / mean;
    double b2 = params->b2 ? (double)params->b2->pixels[i] / mean : b1;
    return (a - b1) * (a - b2) / (b * b + RSE_EPSILON);
}

static void compute_errors(const struct lf_metrics_params *params, const struct means *means,
                           struct lf_metrics *out)
{
    bool display = params->b->display;
    double exposure = display ? 1.0 : MIDDLE_GREY / means->b;
    double rse = 0, l1 = 0, shown = 0, n = (double)out->pixels * 3.0;
    for (size_t i = 0; i < pixel_count(params->b); i++) {
        if (!counts(params->mask, i))
            continue;
        double a[3], b[3];
        for (size_t c = 0; c < 3; c++) {
            a[c] = (double)params->a->pixels[i * 3 + c];
            b[c] = reference_value(params, i * 3 + c);
            rse += relative_error(params, i * 3 + c, means->b);
            l1 += fabs(a[c] - b[c]);
        }
        shown += shown_error(a, b, exposure, display);
    }
    out->rse = rse / n;
    out->l1 = l1 / n / means->b;
    out->psnr = -10.0 * log10(shown / n);
    out->mean_ratio = means->a / means->b;
}

// One reference given twice: its noise stays in the RSE, which looks like one that is free of it.
static void check_independent(const struct lf_metrics_params *params)
{
    const struct lf_picture *b = params->b, *b2 = params->b2;
    if (memcmp(b->pixels, b2->pixels, pixel_count(b) * 3 * sizeof *b->pixels) == 0)
        ng_log_warn(
            "%s: equals the other reference, so the RSE is not free of noise; make it with another seed",
            b2->name);
}

ng_result lf_metrics_compute(const struct lf_metrics_params *params, struct lf_metrics *out)
{
    NG_REQUIRE(params && params->a && params->b && out,
               "two pictures and a place for the result must be given");
    *out = (struct lf_metrics){0};
    if (params->mask)
        NG_TRY(check_size(params->mask, params->b));
    NG_TRY(count_pixels(params, &out->pixels));
    NG_TRY(check_picture(params, params->a));
    NG_TRY(check_picture(params, params->b));
    if (params->b2) {
        NG_TRY(check_picture(params, params->b2));
        check_independent(params);
    }
    struct means means;
    NG_TRY(compute_means(params, out->pixels, &means));
    compute_errors(params, &means, out);
    return NG_OK;
}

// How far a picture is from its reference: RSE, L1, PSNR and the ratio of means. README.md defines each.
//
// Source: the relative squared error of image synthesis, as in Rousselle et al. 2011 with epsilon 0.01; the
// product of two independent references in place of a square, so that their noise has no share in it.
#ifndef LF_METRICS_METRICS_H
#define LF_METRICS_METRICS_H

#include "base/extern_c.h"
#include "lightformer/metrics/picture.h"

NG_EXTERN_C_BEGIN

// Pictures are borrowed and of one size. Either all are of a display (PNG) or none is.
struct lf_metrics_params {
    const struct lf_picture *a;    // what is judged
    const struct lf_picture *b;    // the reference
    const struct lf_picture *b2;   // a second reference with noise of its own, or null
    const struct lf_picture *mask; // pixels where a channel is not 0 count; null: every pixel
};

struct lf_metrics {
    double rse;        // 0: equal. With two references the noise can make it slightly negative
    double l1;         // mean |A - B| / mean B
    double psnr;       // dB, of tone-mapped pictures; infinite where they are equal
    double mean_ratio; // mean A / mean B: 1 without bias
    uint64_t pixels;   // how many counted
};

// Logged in one line and returned: sizes that differ, a PNG against radiance, a mask that leaves no pixel, a
// value that is not finite (with its pixel), a reference without light. A second reference
// equal to the first is a warning: it has no noise of its own. Any thread.
NG_NODISCARD ng_result lf_metrics_compute(const struct lf_metrics_params *params, struct lf_metrics *out);

NG_EXTERN_C_END

#endif

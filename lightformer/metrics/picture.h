// Pictures to be measured: three linear channels, read from a layer of an OpenEXR file or from a PNG.
#ifndef LF_METRICS_PICTURE_H
#define LF_METRICS_PICTURE_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

#define LF_PICTURE_NAME_SIZE 256

// Zero is empty.
struct lf_picture {
    uint32_t width, height;
    bool display;  // of a PNG: light of a display in 0..1, with exposure and tone map applied already
    float *pixels; // [height][width][3], linear Rec. 709, row 0 at the top; owned
    char name[LF_PICTURE_NAME_SIZE]; // for messages: "a.exr" or "a.exr, layer indirect"
};

// Reads a PNG, or `layer` of an OpenEXR file; a null layer means R, G, B at the root. A layer is what its
// channels have before their last dot, and consists of R, G, B, of X, Y, Z, or of one channel, which is then
// repeated; alpha is left out. What is wrong is logged in one line; a missing layer with those there are.
// On success the caller owns `*out` and calls lf_picture_finish.
NG_NODISCARD ng_result lf_picture_load(const char *path, const char *layer, struct lf_picture *out);
void lf_picture_finish(struct lf_picture *picture); // frees the pixels, zeroes the struct

NG_EXTERN_C_END

#endif

// Texels of the engine's images as the graphics device would filter them at level 0: bilinear or not and
// wrapped as the image says, sRGB decoded before the filter.
#ifndef LF_TRACE_TEXTURE_H
#define LF_TRACE_TEXTURE_H

#include "base/extern_c.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_image;

// sRGB bytes to linear.
struct lf_srgb {
    float linear[256];
};
void lf_srgb_make(struct lf_srgb *table);

// `image` may be null: white.
void lf_texture_at(const struct lf_srgb *srgb, const struct ng_image *image, const float uv[2],
                   float rgba[4]);

NG_EXTERN_C_END

#endif

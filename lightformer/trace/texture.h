// Texels of the engine's images as the graphics device filters them: bilinear or not, between levels or not,
// and wrapped as the image says, sRGB decoded before the filter.
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

// At level 0. `image` may be null: white.
void lf_texture_at(const struct lf_srgb *srgb, const struct ng_image *image, const float uv[2],
                   float rgba[4]);
// The same as a pixel sees it, from whose neighbours to the right and below `uv` differs by `dx` and `dy`:
// where texels are smaller than pixels, from smaller levels. Returns the level, a fraction between two
// (Vulkan 1.3, "Texel Filtering", without anisotropy, as devices that draw on the CPU filter).
float lf_texture_seen(const struct lf_srgb *srgb, const struct ng_image *image, const float uv[2],
                      const float dx[2], const float dy[2], float rgba[4]);

NG_EXTERN_C_END

#endif

// What the decoders share.
#ifndef NG_ASSET_IMAGE_INTERNAL_H
#define NG_ASSET_IMAGE_INTERNAL_H

#include "asset/image.h"

// Checks a picture's size against the limits and allocates its pixels, of which level 0 is there: unless
// params->no_mips there is room behind them for the mips. The message names the picture.
NG_NODISCARD ng_result ng_image_allocate(const char *name, uint32_t width, uint32_t height,
                                         enum ng_pixel_format format, const struct ng_image_params *params,
                                         struct ng_image *out);

// Linear values of sRGB's codes, and the code that is nearest to a linear value.
void ng_image_linear_values(float linear[256]);
unsigned char ng_image_srgb_code(float v);

#define NG_IMAGE_MAX_SIDE   16384u
#define NG_IMAGE_MAX_MEMORY ((uint64_t)512 << 20)

#endif

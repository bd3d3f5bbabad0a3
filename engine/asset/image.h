// Picture files into struct ng_image: PNG, JPEG, WebP, OpenEXR and Radiance HDR, told apart by their first
// bytes.
#ifndef NG_ASSET_IMAGE_H
#define NG_ASSET_IMAGE_H

#include "asset/assets.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

// Zero means default.
struct ng_image_params {
    bool srgb; // 8-bit content is colour, decoded to linear when sampled (NG_PIXEL_RGBA8_SRGB)
    struct ng_sampling sampling;
    bool no_mips;        // level 0 alone
    uint32_t max_side;   // pixels; 16,384. Checked in the header, before anything is allocated
    uint64_t max_memory; // bytes of the decoded image with its mips; 512 MiB
    const char *limit;   // what that limit is, for messages: "the 512 that are left"; may be null
    bool repair;         // pixels that are not finite are moved to 0 .. 65504, with a warning; else an error
};

// On success the caller owns `out->pixels` (malloc), or gives the struct to ng_assets_take_image.
// `name` is for messages. EXR and HDR give NG_PIXEL_RGBA32F, the others 8 bits a channel.
NG_NODISCARD ng_result ng_image_decode(const char *name, const void *data, size_t size,
                                       const struct ng_image_params *params, struct ng_image *out);
void ng_image_finish(struct ng_image *image); // frees the pixels, zeroes the struct

// Pixel (0, 0) of a level; its size in pixels through w and h (either may be null).
void *ng_image_level(const struct ng_image *image, uint32_t level, uint32_t *w, uint32_t *h);
uint32_t ng_pixel_size(enum ng_pixel_format format); // bytes

// Replaces a single-level image by one with all mips down to 1x1: a box filter in linear light, with texels
// of odd sizes weighted by the area they cover.
NG_NODISCARD ng_result ng_image_make_mips(struct ng_image *image);
// The same for the levels that an image has, from its level 0.
void ng_image_update_mips(struct ng_image *image);

NG_EXTERN_C_END

#endif

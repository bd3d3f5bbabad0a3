// Pictures as bytes: PNG without compression (so that its bytes depend on no library) and Radiance RGBE.
#ifndef CONTENT_IMAGE_H
#define CONTENT_IMAGE_H

#include "base/array.h"
#include "base/result.h"

#include <stdint.h>

struct bytes {
    unsigned char *items;
    size_t count, capacity;
};

// Appends; false when out of memory. The arrays of base/array.h work on struct bytes too.
bool bytes_append(struct bytes *b, const void *data, size_t size);
void bytes_finish(struct bytes *b);

// 8 bits a channel, row 0 at the top. channels: 1 grey, 3 RGB, 4 RGBA.
NG_NODISCARD ng_result image_png(uint32_t width, uint32_t height, uint32_t channels,
                                 const unsigned char *pixels, struct bytes *out);
// One byte a pixel into a palette of up to 256 RGB colours.
NG_NODISCARD ng_result image_png_indexed(uint32_t width, uint32_t height, const unsigned char *pixels,
                                         const unsigned char (*palette)[3], uint32_t colors,
                                         struct bytes *out);
// Linear RGB, row 0 at the top, run-length encoded; 8 <= width < 32768.
NG_NODISCARD ng_result image_hdr(uint32_t width, uint32_t height, const float *rgb, struct bytes *out);

#endif

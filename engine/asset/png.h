// PNG files: 8-bit colour in and out, with text chunks (what made this picture). Source: PNG specification,
// third edition.
#ifndef NG_ASSET_PNG_H
#define NG_ASSET_PNG_H

#include "asset/image.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

struct ng_png_text {
    const char *key, *value; // key: 1 to 79 Latin-1 characters; value: UTF-8
};

struct ng_png_params {
    uint32_t width, height;
    uint32_t channels;  // 3: RGB, 4: RGBA; 0: 4
    const void *pixels; // sRGB, 8 bits, rows from the top, tightly packed
    const struct ng_png_text *texts;
    uint32_t text_count;
};

// Marked as sRGB. Written beside the path and renamed when complete. The bytes depend on the parameters
// alone.
NG_NODISCARD ng_result ng_png_write(const char *path, const struct ng_png_params *params);
// The file's bytes alone, from malloc. `name` is for messages.
NG_NODISCARD ng_result ng_png_encode(const char *name, const struct ng_png_params *params, void **data,
                                     size_t *size);

// Any PNG as RGBA8 (16 bits are rounded, palettes and grey expanded, interlacing undone), without mips.
NG_NODISCARD ng_result ng_png_decode(const char *name, const void *data, size_t size,
                                     const struct ng_image_params *params, struct ng_image *out);
// The value of the first text chunk with this key, from malloc, or null.
NG_NODISCARD char *ng_png_text(const void *data, size_t size, const char *key);

NG_EXTERN_C_END

#endif

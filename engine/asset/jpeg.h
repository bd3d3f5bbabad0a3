// JPEG files: baseline and progressive, grey or colour. Source: ITU-T T.81.
#ifndef NG_ASSET_JPEG_H
#define NG_ASSET_JPEG_H

#include "asset/image.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

// As RGBA8 with alpha 255, without mips. CMYK is refused.
NG_NODISCARD ng_result ng_jpeg_decode(const char *name, const void *data, size_t size,
                                      const struct ng_image_params *params, struct ng_image *out);

NG_EXTERN_C_END

#endif

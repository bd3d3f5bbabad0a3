// WebP files: one picture, lossy or lossless, with or without alpha. Source: RFC 9649.
#ifndef NG_ASSET_WEBP_H
#define NG_ASSET_WEBP_H

#include "asset/image.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

// As RGBA8, without mips. Animations are refused.
NG_NODISCARD ng_result ng_webp_decode(const char *name, const void *data, size_t size,
                                      const struct ng_image_params *params, struct ng_image *out);

NG_EXTERN_C_END

#endif

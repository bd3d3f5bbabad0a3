// Radiance .hdr pictures (RGBE), run-length coded in the old or the new way, or flat.
// Source: Ward, "Real Pixels", Graphics Gems II; Radiance file formats (ray.lbl.gov).
#ifndef NG_ASSET_HDR_H
#define NG_ASSET_HDR_H

#include "asset/image.h"
#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

// Gives NG_PIXEL_RGBA32F in linear radiance (EXPOSURE lines divided out), rows from the top, without mips.
// XYZE files and orientations other than -Y +X are refused.
NG_NODISCARD ng_result ng_hdr_decode(const char *name, const void *data, size_t size,
                                     const struct ng_image_params *params, struct ng_image *out);

NG_EXTERN_C_END

#endif

// Small procedural pictures that tile: PNG in sRGB unless said otherwise, and the sky in Radiance.
#ifndef CONTENT_TEXTURE_H
#define CONTENT_TEXTURE_H

#include "image.h"

// Value noise on a lattice of nx by ny cells that wraps around; 0 to 1. x and y in [0, 1).
double texture_noise(double x, double y, uint32_t nx, uint32_t ny, uint64_t seed);

// 256 x 256 of light and dark wood, the grain along v.
NG_NODISCARD ng_result texture_maple(struct bytes *out);
NG_NODISCARD ng_result texture_walnut(struct bytes *out);
// 64 x 64: four panes of coloured glass behind dark bars.
NG_NODISCARD ng_result texture_panes(struct bytes *out);
// 64 x 64 checker of 8 x 8 fields in two colours: what mip maps must turn into an even tone far away.
NG_NODISCARD ng_result texture_checker(struct bytes *out);
// 64 x 64 RGBA: a lattice of round holes, alpha 0 inside, soft at the rim.
NG_NODISCARD ng_result texture_holes(struct bytes *out);
// 64 x 64 tangent-space normals (linear) of a field of domes.
NG_NODISCARD ng_result texture_domes(struct bytes *out);
// 64 x 64, linear: G roughness in stripes along u, B metallic in stripes along v.
NG_NODISCARD ng_result texture_metal_stripes(struct bytes *out);
// 64 x 32 latitude-longitude sky with a sun, linear radiance, Radiance HDR.
NG_NODISCARD ng_result texture_sky(struct bytes *out);

#endif

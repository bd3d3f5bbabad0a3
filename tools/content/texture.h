// Small procedural pictures, all of value noise that wraps around, so that they tile.
#ifndef CONTENT_TEXTURE_H
#define CONTENT_TEXTURE_H

#include "image.h"

enum texture_wood { TEXTURE_MAPLE, TEXTURE_WALNUT };

// 256 x 256 wood with its grain along v, sRGB.
NG_NODISCARD ng_result texture_wood(enum texture_wood wood, struct bytes *out);

#endif

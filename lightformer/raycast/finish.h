// The arithmetic of a tile's pixels, sixteen at once. Plain C that the compiler vectorizes, built for several
// instruction sets; all give the same bytes.
#ifndef LF_RAYCAST_FINISH_H
#define LF_RAYCAST_FINISH_H

#include "base/extern_c.h"
#include "lightformer/trace/tracer.h"

NG_EXTERN_C_BEGIN

// Surfaces by lane. Lanes that show none hold any finite numbers.
struct lf_finish {
    uint32_t shown[LF_PACKET];  // 1, or 0
    float side[LF_PACKET];      // 1, or -1 where the back is seen
    float normal[3][LF_PACKET]; // shading, of the front, of any length; zero: there is none
    float flat[3][LF_PACKET];   // geometric, of the front, unit
    float roughness[LF_PACKET], albedo[3][LF_PACKET], f0[3][LF_PACKET];
    float before[3][LF_PACKET]; // where the point was in the frame before, world
};

// Where the camera of the frame before saw a point: in pixels from the middle of the picture.
struct lf_finish_view {
    float previous[16]; // world to camera, as in struct ng_snapshot_camera
    float pixels[2];    // that a length of 1 at distance 1 has; parallel: that it has
    float middle[2];    // of the picture, from the middle of the tile's first pixel
    bool parallel;
};

// Four halfs each, as the images have them.
struct lf_finished {
    uint64_t normal[LF_PACKET], diffuse[LF_PACKET], specular[LF_PACKET];
    float motion[2][LF_PACKET];
};

struct lf_finish_kernels {
    // As settle_normals, turn_over and lift of lightformer/trace/surface.c, for whoever looks along
    // `direction`.
    void (*finish)(const struct lf_finish *tile, const float direction[3][LF_PACKET],
                   const struct lf_finish_view *view, struct lf_finished *out);
};

// The sets that this CPU has, the fastest first; null past the end.
const struct lf_finish_kernels *lf_finish_kernels_of(uint32_t index);

NG_EXTERN_C_END

#endif

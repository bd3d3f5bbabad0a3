// What a camera sees, by rays through the middles of its pixels: tiles of them in packets.
//
//     const struct lf_view view = lf_view_of(&snapshot->camera, width, height);
//     struct lf_tile tile;
//     lf_trace_tile(tracer, &view, x, y, false, &tile); // pixels (x, y) to (x + 3, y + 3)
//     for (int i = 0; i < LF_PACKET; i++)
//         if (tile.met[i]) ... tile.hits[i] ...
//
// Holes and what blends are cut as the rasterizer cuts them (engine/shaders/cut.glsl). A tile is the same
// whatever lies around it and whoever traces it: so a picture is, for any number of threads.
#ifndef LF_TRACE_VIEW_H
#define LF_TRACE_VIEW_H

#include "base/extern_c.h"
#include "lightformer/trace/tracer.h"

NG_EXTERN_C_BEGIN

struct ng_snapshot_camera;

#define LF_TILE 4 // pixels a side: LF_PACKET of them, row by row

struct lf_view {
    float position[3], right[3], down[3], forward[3]; // as in struct ng_camera_rays of render/camera.h
    float near_plane;
    bool parallel;
    uint32_t width, height;
    uint32_t subpixel; // as in struct ng_snapshot_camera
    float shift[2];    // of rays from the middles of pixels, in halves of the picture
};
struct lf_view lf_view_of(const struct ng_snapshot_camera *camera, uint32_t width, uint32_t height);

// The ray of a pixel's middle.
struct lf_ray lf_view_ray(const struct lf_view *view, uint32_t x, uint32_t y);
// From a point that a pixel shows to those that its neighbours to the right and below show of the plane
// through it; `normal` need not be unit.
void lf_view_steps(const struct lf_view *view, const float position[3], const float normal[3], float right[3],
                   float down[3]);

struct lf_tile {
    float origin[3][LF_PACKET], direction[3][LF_PACKET]; // by axis; of pixels outside of the picture, too
    bool met[LF_PACKET];                                 // never outside
    struct lf_hit hits[LF_PACKET];
};
// Closest hits with fronts and with what is double-sided. `lamps`: with lamps alone (render/snapshot.h); else
// with all but them.
void lf_trace_tile(const struct lf_tracer *tracer, const struct lf_view *view, uint32_t x, uint32_t y,
                   bool lamps, struct lf_tile *out);

NG_EXTERN_C_END

#endif

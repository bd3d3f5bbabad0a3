// The camera of a snapshot as rays: what the rasterizer, the path tracer and the clues agree on.
#ifndef NG_RENDER_CAMERA_H
#define NG_RENDER_CAMERA_H

#include "base/extern_c.h"
#include "render/snapshot.h"

NG_EXTERN_C_BEGIN

// The ray through (x, y), from -1 to 1 to the right and down: perspective cameras send it from their position
// along forward + x * right + y * down, orthographic ones along forward from position + x * right + y * down.
struct ng_camera_rays {
    float right[3], down[3], forward[3]; // world; forward is unit
};
struct ng_camera_rays ng_camera_rays_of(const struct ng_snapshot_camera *c, float aspect);

// From where surfaces are seen: a place, or one direction for all of them.
struct ng_camera_eye {
    bool parallel;
    float at[3];    // the place; parallel: unit, towards the viewer
    float distance; // parallel: from which a lens of `fov_y` sees as much, metres
    float fov_y;
};
struct ng_camera_eye ng_camera_eye_of(const struct ng_snapshot_camera *c);

NG_EXTERN_C_END

#endif

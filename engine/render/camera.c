#include "render/camera.h"

#include <math.h>
#include <string.h>

#define LENS 0.7f // the usual one, whose picture a parallel view's is compared with; rad

struct ng_camera_rays ng_camera_rays_of(const struct ng_snapshot_camera *c, float aspect)
{
    struct ng_camera_rays out;
    float half = c->orthographic ? 0.5f * c->height : tanf(c->fov_y * 0.5f);
    for (int i = 0; i < 3; i++) {
        out.right[i] = c->view[i * 4] * half * aspect;
        out.down[i] = -c->view[i * 4 + 1] * half;
        out.forward[i] = -c->view[i * 4 + 2];
    }
    return out;
}

struct ng_camera_eye ng_camera_eye_of(const struct ng_snapshot_camera *c)
{
    struct ng_camera_eye out = {.parallel = c->orthographic, .fov_y = c->orthographic ? LENS : c->fov_y};
    memcpy(out.at, c->position, sizeof out.at);
    if (!out.parallel)
        return out;
    for (int i = 0; i < 3; i++)
        out.at[i] = c->view[i * 4 + 2];
    out.distance = 0.5f * c->height / tanf(0.5f * LENS);
    return out;
}

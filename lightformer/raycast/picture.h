// The pixels of a G-buffer, from the hits of the camera's rays.
#ifndef LF_RAYCAST_PICTURE_H
#define LF_RAYCAST_PICTURE_H

#include "base/extern_c.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

struct lf_tracer;
struct ng_jobs;

// [height][width] of each; layouts as struct ng_gbuffer of render/frame.h.
struct lf_raycast_picture {
    uint32_t width, height;
    float *position, *emission;            // [4]
    uint16_t *normal, *diffuse, *specular; // [4], halfs
    float *motion;                         // [2]
    uint32_t *entity;
};

struct lf_raycast_job {
    const struct lf_tracer *tracer; // at the snapshot whose camera looks
    struct ng_jobs *jobs;           // null: this thread
    struct lf_raycast_picture picture;
};

// Writes every pixel: surfaces but lamps, and the environment where there is none.
void lf_raycast_draw(const struct lf_raycast_job *job);
// Writes the pixels in which a lamp is nearer than what is there.
void lf_raycast_draw_lamps(const struct lf_raycast_job *job);

NG_EXTERN_C_END

#endif

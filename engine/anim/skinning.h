// Linear blend skinning on the CPU: joint palettes, and vertices into world space.
//
// Pure functions over the caller's memory; thread-safe. The same bytes for any number of threads.
#ifndef NG_ANIM_SKINNING_H
#define NG_ANIM_SKINNING_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_jobs;

// One joint of a palette: the columns x, y, z and translation of world * inverse bind, padded to four floats.
struct ng_joint_matrix {
    float column[4][4];
};

// joint_world and inverse_bind: [count][16] column-major.
void ng_skin_palette(uint32_t count, const float *joint_world, const float *inverse_bind,
                     struct ng_joint_matrix *palette);

// Buffers are plain packed floats, which Vulkan and a ray tracer read as they are. Weights should sum to 1.
struct ng_skin_params {
    uint32_t vertex_count, joint_count;
    const struct ng_joint_matrix *palette; // [joint_count]
    const uint16_t *joints;                // [vertex_count][4]; below joint_count (checked when loaded)
    const float *weights;                  // [vertex_count][4]
    const uint16_t *joints1;               // four more of each vertex, or null
    const float *weights1;
    const float *positions; // [vertex_count][3]
    const float *normals;   // [vertex_count][3], or null
    const float *tangents;  // [vertex_count][4], or null
    // Out. Normals by the inverse transpose of the blended matrix, so that non-uniform scale is right;
    // normals and tangents are unit (zero stays zero).
    float *out_positions, *out_normals, *out_tangents;
    uint32_t first_chunk; // set by ng_skin_batch
};

void ng_skin_vertices(struct ng_jobs *jobs, const struct ng_skin_params *p);
// Several meshes at once, so that many small characters fill all threads.
void ng_skin_batch(struct ng_jobs *jobs, struct ng_skin_params *meshes, uint32_t count);

NG_EXTERN_C_END

#endif

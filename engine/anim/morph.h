// Morph targets on the CPU: weighted sums of what targets add to vertices (glTF 2.0, 3.7.2.2).
//
// Pure functions over the caller's memory; thread-safe. The same bytes for any number of threads.
#ifndef NG_ANIM_MORPH_H
#define NG_ANIM_MORPH_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_jobs;

// Deltas of target t are those from target_ends[t - 1] (0 for the first) to target_ends[t].
struct ng_morph_params {
    uint32_t vertex_count, target_count;
    const float *weights;           // [target_count]
    const uint32_t *target_ends;    // [target_count]
    const uint32_t *delta_vertices; // [deltas] each below vertex_count
    const float *delta_positions;   // [deltas][3]
    const float *delta_normals;     // [deltas][3], or null
    const float *delta_tangents;    // [deltas][3], or null
    const float *positions;         // [vertex_count][3]
    const float *normals;           // [vertex_count][3], unit; or null, as its deltas are then
    const float *tangents;          // [vertex_count][4], or null
    // Out. What no target of a weight other than 0 moves is as it was, bit for bit; what is turned is unit.
    float *out_positions, *out_normals, *out_tangents;
};

// Several meshes at once, each on one thread.
void ng_morph_batch(struct ng_jobs *jobs, const struct ng_morph_params *meshes, uint32_t count);

NG_EXTERN_C_END

#endif

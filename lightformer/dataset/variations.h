// The variations of a world (components/variation.h), checked, and drawn by seed.
//
//     NG_TRY(lf_variations_create(world, &variations));
//     NG_TRY(lf_variations_apply(variations, &params, &time));   // one transaction: ng_world_undo restores
//
// A seed gives the same values wherever the scene is the same file: variation i (by entity index) draws from
// stream i of the seed, so that how many numbers one needs does not move the others. Values are computed in
// double precision and rounded, so that a mathematics library's last bit does not show.
//
// One thread, that of the world.
#ifndef LF_DATASET_VARIATIONS_H
#define LF_DATASET_VARIATIONS_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/entity.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct ng_world;
struct lf_variations;

// Finds and checks all variations of the world. A world may have none. Errors, logged with the variation's
// name: NG_ERROR_NOT_FOUND (unknown field, a target that is gone or lacks the component), NG_ERROR_FORMAT
// (empty range, no choices, a kind that does not suit the field, a value that the field refuses, a camera
// below a transform, two variations of one field).
NG_NODISCARD ng_result lf_variations_create(struct ng_world *world, struct lf_variations **out);
void lf_variations_destroy(struct lf_variations **variations);
uint32_t lf_variations_count(const struct lf_variations *v);

struct lf_variations_apply_params {
    uint64_t seed;
    double time; // of the sample, where no variation draws it; seconds
    // Asked for cameras, after everything else has been set and the world's systems have run: whether a view
    // from `eye` along the unit vector `forward` is one to take. `candidate` counts from 0 for each camera;
    // at 0 the world has just changed. Null: every view is.
    ng_result (*judge)(void *user, double time, uint32_t candidate, const float eye[3],
                       const float forward[3], bool *good);
    void *user;
};

// Sets the world to the sample, as one transaction with an undo entry, and runs its systems; `*time` (may be
// null) is the sample's. On failure the world is as before. Errors, logged: NG_ERROR_FORMAT (a field that an
// animation overwrites; an offset that leaves the field's range), NG_ERROR_NOT_FOUND (no good view in 256
// tries).
NG_NODISCARD ng_result lf_variations_apply(struct lf_variations *variations,
                                           const struct lf_variations_apply_params *params, double *time);

NG_EXTERN_C_END

#endif

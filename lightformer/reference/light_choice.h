// Which light a path connects to: one of them, with a probability that follows the irradiance it might give
// at the point, so that far and dim lights cost little. Never zero for a light that is on.
#ifndef LF_REFERENCE_LIGHT_CHOICE_H
#define LF_REFERENCE_LIGHT_CHOICE_H

#include "render/snapshot.h"

struct lf_light_entry;

struct lf_light_choice {
    const struct ng_snapshot *snapshot; // borrowed
    struct lf_light_entry *entries;     // of all lights of the snapshot
    uint32_t count, lit;
};

// Reusable: a second call follows another snapshot. Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_light_choice_update(struct lf_light_choice *c, const struct ng_snapshot *snapshot);
void lf_light_choice_finish(struct lf_light_choice *c);

// The sum that the two functions below take, at a point.
float lf_light_choice_total(const struct lf_light_choice *c, const float position[3]);
// By u in [0, 1), which becomes a number to sample the light with; `probability` is that of the light.
// NG_NONE if no light is on.
uint32_t lf_light_choice_pick(const struct lf_light_choice *c, const float position[3], float total, float *u,
                              float *probability);
float lf_light_choice_probability(const struct lf_light_choice *c, const float position[3], float total,
                                  uint32_t light);

#endif

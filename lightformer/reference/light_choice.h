// Which light a path connects to: one of them, with a probability that follows the irradiance it might give
// at the point, so that far and dim lights cost little. Never zero for a light that is on.
#ifndef LF_REFERENCE_LIGHT_CHOICE_H
#define LF_REFERENCE_LIGHT_CHOICE_H

#include "base/array.h"
#include "base/extern_c.h"
#include "render/snapshot.h"

NG_EXTERN_C_BEGIN

// Lights whose samples are points of a uniform unit shape under a matrix, and all others.
enum lf_light_form { LF_LIGHT_OTHER, LF_LIGHT_SQUARE, LF_LIGHT_DISK, LF_LIGHT_SPHERE };

struct lf_light_entry {
    float position[3];
    float radius2;  // squared, of the emitter around position: nearer is no brighter
    float strength; // irradiance at one metre; of lights at infinity anywhere; 0: the light is off
    bool infinite;
    enum lf_light_form form;
    // Of all forms but OTHER: a place (x, y) of the shape is at center + x * axes[0] + y * axes[1]; spheres
    // have their radius in axes[0][0]. `sample` is one of the light's, which all share normal (spheres: not),
    // radiance and density with.
    float center[3], axes[2][3];
    struct ng_light_sample sample;
};

struct lf_light_choice {
    const struct ng_snapshot *snapshot;   // borrowed
    const struct lf_light_entry *entries; // of all lights of the snapshot
    uint32_t count, lit;
    NG_ARRAY(struct lf_light_entry) memory; // of entries, grown as needed
};

// Reusable: a second call follows another snapshot. Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_light_choice_update(struct lf_light_choice *c, const struct ng_snapshot *snapshot);
void lf_light_choice_finish(struct lf_light_choice *c);

// A light's part in the choice at a point.
static inline float lf_light_weight(const struct lf_light_entry *e, float x, float y, float z)
{
    float dx = e->position[0] - x, dy = e->position[1] - y, dz = e->position[2] - z;
    float square = dx * dx + dy * dy + dz * dz;
    square = square > e->radius2 ? square : e->radius2;
    return e->strength / (e->infinite ? 1.0f : square);
}

#define LF_LIGHT_EVEN_SHARE 0.1f // of the probability that all lights share evenly

// Probability of one of `lit` lights that are on, where the weights of all sum up to `total`.
static inline float lf_light_probability(float weight, float total, uint32_t lit)
{
    float even = 1.0f / (float)lit;
    return LF_LIGHT_EVEN_SHARE * even + (1 - LF_LIGHT_EVEN_SHARE) * (total > 0 ? weight / total : even);
}

NG_EXTERN_C_END

#endif

// Secondary hits: what rays from the surfaces of pixels meet, and how a light lights it.
#ifndef LF_CLUES_SECONDARY_HIT_H
#define LF_CLUES_SECONDARY_HIT_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct lf_clues_scene;
struct lf_light_clues;
struct lf_space;

#define LF_METAL 0.2f // F0 above which a surface shows mostly something else

// Lengths are in radii of the scene's sphere, relative to its centre.
struct lf_secondary_hit {
    uint32_t pixel;            // where the ray began
    uint32_t interleave_index; // among the rays of a block (interleaved.h)
    uint32_t direction_index;  // which direction it takes (lf_interleave_direction)
    uint32_t through;          // index + 1 of the hit from which this one goes on; 0: from the pixel
    bool met;
    float distance;     // along the ray
    float direction[3]; // of the ray
    float density;      // per steradian, with which the ray was chosen
    float position[3], normal[3], flat[3], view[3];
    float albedo[3], f0[3], roughness;
    float emission[3]; // W/(sr m2), not of lights
};

// Whether what is seen there asks for another ray.
bool lf_secondary_continues(const struct lf_secondary_hit *hit);

// Casts a ray in `hit->direction`, which is otherwise zero but for what says which ray it is, from a surface,
// and sets what it meets. `roughness`: of that surface; what is seen is no smoother.
void lf_secondary_cast(const struct lf_clues_scene *scene, const struct lf_space *space,
                       const float position[3], const float flat[3], float roughness,
                       struct lf_secondary_hit *hit);

// What a hit shows: radiance toward where the ray came from, and room, since loops of a round number
// vectorize.
#define LF_HIT_CHANNELS 4

// What all of `hits` show of a light, direct light and a bounce, as of `view.diffuse`:
// [count][LF_HIT_CHANNELS]. Of the first `going_on` those that go on leave the bounce's F0 to the rays that
// do.
void lf_secondary_light(const struct lf_clues_scene *scene, const struct lf_light_clues *light,
                        const struct lf_secondary_hit *hits, uint32_t count, uint32_t going_on, float *out);

NG_EXTERN_C_END

#endif

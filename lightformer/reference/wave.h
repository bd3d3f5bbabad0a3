// The arithmetic of many paths that walk in step, lane by lane: plain C that the compiler vectorizes, built
// for several instruction sets, all of which give the same bytes. path.c does what waits for memory (rays,
// surfaces, emitters) in between.
//
// Light passes only between directions above both the shading and the geometric normal. Where the shading
// normal still turns away from the viewer (surface.h), the viewer counts as grazing (cosine 1e-4), as in the
// raster method.
#ifndef LF_REFERENCE_WAVE_H
#define LF_REFERENCE_WAVE_H

#include "base/extern_c.h"
#include "lightformer/reference/light_choice.h"
#include "lightformer/reference/sampler.h"

NG_EXTERN_C_BEGIN

#define LF_WAVE_LANES 128 // a multiple of 16, which is what instructions take at a time

typedef float lf_lanes[LF_WAVE_LANES];
typedef lf_lanes lf_lanes3[3]; // by axis or channel

// Lanes that are not in use hold any numbers that were there before, or zero.
struct lf_wave {
    uint32_t count; // lanes in use: the first
    const struct lf_light_choice *lights;
    float scene_radius;
    float place_size; // snapshot.h

    // Random numbers: of one kind and as many draws in all lanes.
    enum lf_sampler_kind sampler;
    uint32_t draw;
    uint64_t pixel[LF_WAVE_LANES], rng_state[LF_WAVE_LANES], rng_stream[LF_WAVE_LANES];
    uint32_t reversed[LF_WAVE_LANES];

    // The surface that a path has come to (surface.h), and the direction in which it came.
    lf_lanes3 position, flat_normal, normal, came, albedo, f0;
    lf_lanes roughness;
    lf_lanes3 throughput; // what is left of light that the path carries to the camera

    // Made of them by `arrive`: frame, direction towards the viewer in it (tangent, bitangent, normal),
    // probability of the specular lobe, sum of all lights' weights.
    lf_lanes3 tangent, bitangent, view;
    lf_lanes specular_share, light_total;

    // One sample of one light, by `sample_lights`.
    lf_lanes u[2];
    uint32_t light[LF_WAVE_LANES];
    lf_lanes chosen, below; // the light's probability; that of all before it
    lf_lanes3 light_position, light_normal;
    lf_lanes3 incident, irradiance; // struct ng_light_incident
    lf_lanes light_distance, light_pdf;

    // A direction and the BRDF there, by `connect` and `scatter`.
    lf_lanes3 direction, local, value; // local: in the frame; value: BRDF times cosine
    lf_lanes pdf, lobe, vh;
    // A ray along it, off the surface. `connect`: to the light; far is 0 where no ray is needed.
    lf_lanes3 origin;
    lf_lanes far;
    lf_lanes3 whole; // what the sampled light would send if nothing were in between
    // `scatter`: whether the path has a direction. Then, or by `play_roulette`: whether it goes on after what
    // it meets there, and how much more it carries then.
    uint32_t goes[LF_WAVE_LANES], survives[LF_WAVE_LANES];
    lf_lanes boost;
};

struct lf_wave_kernels {
    const char *name;
    // Samples one light at every surface. Draws 2.
    void (*connect)(struct lf_wave *w);
    // Chooses a direction by the BRDF: visible normals or cosine; after `connect`. Draws 2.
    void (*scatter)(struct lf_wave *w);
    // Paths that carry little end, survivors carry more. Draws 1.
    void (*play_roulette)(struct lf_wave *w);
};

// The sets that this CPU has, the fastest first; null past the end.
const struct lf_wave_kernels *lf_wave_kernels_of(uint32_t index);

NG_EXTERN_C_END

#endif

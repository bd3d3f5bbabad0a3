// The path tracer as a method of the renderer, "reference": a picture that gets better while one looks at it.
//
//     struct lf_progressive *p;
//     NG_TRY(lf_progressive_create(&(struct lf_progressive_params){.jobs = jobs}, &p));
//     NG_TRY(lf_progressive_join(p, ng_renderer_composer(renderer)));
//     ... frames with .method = "reference" ...
//     lf_progressive_leave(p);
//     lf_progressive_destroy(&p);
//
// A frame that wants the method gives it a slice of time, on the jobs, in the pass "reference/trace". Slices
// add up to passes of one sample a pixel; when something changes (scene, camera, size) the picture begins
// again, with a coarse preview until the first pass is through. After N passes it equals what lf_reference
// makes of N samples, byte for byte, however the slices fell. One thread.
#ifndef LF_PROGRESSIVE_PROGRESSIVE_H
#define LF_PROGRESSIVE_PROGRESSIVE_H

#include "base/extern_c.h"
#include "graph/provider.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct lf_progressive;
struct ng_jobs;

struct lf_progressive_params {
    struct ng_jobs *jobs; // borrowed; null: the caller's thread alone
    uint32_t samples;     // a pixel; there it rests; 0: never
    uint64_t seed;        // of the random numbers
    double slice; // seconds of tracing in a frame, exceeded by at most one region; 0: as long as the rest
                  // of a frame takes, 0.03 to 0.25
};

NG_NODISCARD ng_result lf_progressive_create(const struct lf_progressive_params *params,
                                             struct lf_progressive **out);
// Leaves its composer, if it is in one, which must still exist.
void lf_progressive_destroy(struct lf_progressive **progressive);

// Registers a provider that publishes ng_radiance_item (render/frame.h) in frames that want "reference". What
// goes wrong while tracing is logged, and the last good picture stays until something changes. Once; the
// composer is borrowed until lf_progressive_leave.
NG_NODISCARD ng_result lf_progressive_join(struct lf_progressive *progressive, struct ng_composer *composer);
void lf_progressive_leave(struct lf_progressive *progressive);

// Of the picture under way.
struct lf_progressive_stats {
    uint32_t samples; // a pixel, of passes that are through
    double seconds;   // of tracing
    uint64_t rays;
    bool resting; // has all samples that it was to have, or went wrong
};
struct lf_progressive_stats lf_progressive_stats_of(const struct lf_progressive *progressive);

NG_EXTERN_C_END

#endif

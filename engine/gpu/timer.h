// GPU time per named scope, by timestamp queries.
//
// Scopes are recorded within a frame (gpu/frame.h); their times are published when the frame's slot comes
// round again, so results are NG_GPU_FRAMES frames old, or those of the frame just ended after
// ng_gpu_wait_idle.
#ifndef NG_GPU_TIMER_H
#define NG_GPU_TIMER_H

#include "base/extern_c.h"
#include "gpu/command.h"

NG_EXTERN_C_BEGIN

#define NG_GPU_MAX_SCOPES 512 // of one frame; more are not timed

// A scope of time; scopes may nest. Returns a token for the end.
uint32_t ng_timer_begin(struct ng_cmd *cmd, const char *name);
void ng_timer_end(struct ng_cmd *cmd, uint32_t token);

struct ng_gpu_timing {
    char name[64];
    double begin_ms; // since the frame's first timestamp
    double gpu_ms;
};
// Times of the newest frame that is done, in order of ng_timer_begin; null and 0 before there is one, and
// where the device has no timestamps. Borrowed until the next ng_frame_begin.
const struct ng_gpu_timing *ng_gpu_timings(const struct ng_gpu *gpu, uint32_t *count);
// Number of that frame (ng_frame_number at its recording, minus 1).
uint64_t ng_gpu_timings_frame(const struct ng_gpu *gpu);

NG_EXTERN_C_END

#endif

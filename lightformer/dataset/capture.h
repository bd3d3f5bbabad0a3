// Captures what the encoders of lights see: draws a frame with the renderer's own passes (G-buffer, light
// maps) and reads it back as lightformer/clues/captured.h has it. Nothing is computed a second time.
//
//     lf_capture_create(gpu, jobs, &observer);
//     struct lf_capture_params params = {.snapshot = snapshot, .width = 512, .height = 512};
//     NG_TRY(lf_capture_frame(observer, &params, &observation));
//
// An observer belongs to the thread of its device.
#ifndef LF_DATASET_CAPTURE_H
#define LF_DATASET_CAPTURE_H

#include "base/extern_c.h"
#include "lightformer/clues/captured.h"

NG_EXTERN_C_BEGIN

struct lf_capture;
struct ng_gpu;
struct ng_jobs;
struct ng_snapshot;

struct lf_captured_frame {
    uint32_t width, height, light_count, vpl_count;
    struct lf_gbuffer gbuffer;
    const struct lf_captured_light *lights;
    float eye[3]; // of the camera, world
};

// `jobs` may be null. Both are borrowed.
NG_NODISCARD ng_result lf_capture_create(struct ng_gpu *gpu, struct ng_jobs *jobs, struct lf_capture **out);
void lf_capture_destroy(struct lf_capture **observer);

struct lf_capture_params {
    const struct ng_snapshot *snapshot; // needed
    uint32_t width, height;             // pixels
    uint32_t vpl_count;                 // of each light; 0: LF_VPL_COUNT
    bool pixels_only;                   // the G-buffer, no light: their maps are not drawn
};

// Waits for the GPU. `*out` is the observer's until its next call.
NG_NODISCARD ng_result lf_capture_frame(struct lf_capture *observer, const struct lf_capture_params *params,
                                        struct lf_captured_frame *out);

NG_EXTERN_C_END

#endif

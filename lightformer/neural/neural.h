// The method "neural": LightFormer in a frame of the engine.
//
//     struct lf_neural *neural;
//     NG_TRY(lf_neural_create(&(struct lf_neural_params){.weights =
//     "content/chess/chess.weights.safetensors",
//                                                        .jobs = jobs},
//                             &neural));
//     NG_TRY(lf_neural_join(neural, ng_renderer_composer(renderer)));
//     ... frames with .method = "neural" ...
//     lf_neural_leave(neural);
//     lf_neural_destroy(&neural);
//
// A network, its executor, the encoding passes of the lights (lightformer/encode/encoder.h) and the gather
// (lightformer/gather/gather.h), in one object. Belongs to the thread of the renderer.
#ifndef LF_NEURAL_NEURAL_H
#define LF_NEURAL_NEURAL_H

#include "base/extern_c.h"
#include "lightformer/encode/encoder.h"
#include "lightformer/net/net.h"
#include "lightformer/raycast/raycast.h"

NG_EXTERN_C_BEGIN

#define LF_NEURAL_METHOD "neural"

struct lf_neural;

struct lf_neural_params {
    const char *weights;       // path of a network's file (lightformer/net/README.md); needed
    struct ng_jobs *jobs;      // borrowed; null: the caller's thread alone
    enum lf_net_kernel kernel; // LF_KERNEL_AUTO: the fastest of this CPU
    // As in struct lf_encoder_params:
    enum lf_rsm_source rsm;
    uint32_t reflection_rays;
    uint64_t memory_limit;
    enum lf_raycast_use gbuffer; // of frames of the method
};

// Errors, logged: those of lf_net_load and lf_net_executor_create.
NG_NODISCARD ng_result lf_neural_create(const struct lf_neural_params *params, struct lf_neural **out);
// Leaves its composer, if it is in one, which must still exist.
void lf_neural_destroy(struct lf_neural **neural);

// Registers the providers. Once; the composer is borrowed until lf_neural_leave.
NG_NODISCARD ng_result lf_neural_join(struct lf_neural *neural, struct ng_composer *composer);
void lf_neural_leave(struct lf_neural *neural);

const struct lf_net *lf_neural_net(const struct lf_neural *neural);

// As lf_encoder_clue (lightformer/encode/encoder.h).
NG_NODISCARD ng_result lf_neural_clue(const struct lf_neural *neural, const char *clue, struct lf_clue *out);

struct lf_neural_counters {
    struct lf_encoder_counters encoder;
    uint64_t gather;
};
struct lf_neural_counters lf_neural_counters_of(const struct lf_neural *neural);

// Where a scene's weights are if it has its own: "dir/chess.weights.safetensors" for "dir/chess.glb". False
// if there is no such file, if it is a link out of that folder, or the path is too long.
bool lf_neural_find_weights(const char *scene, char *out, size_t size);

NG_EXTERN_C_END

#endif

// The method "reference" of lightformer render: the path tracer where the other methods have the renderer.
#ifndef LIGHTFORMER_RENDER_REFERENCE_H
#define LIGHTFORMER_RENDER_REFERENCE_H

#include "output.h"

#include "lightformer/reference/reference.h"

struct ng_snapshot;
struct ng_world;
struct render_reference;

struct render_reference_params {
    const char *scene;            // for messages
    const struct ng_world *world; // what the snapshots are of
    bool strict;                  // a part that cannot be seen, or cannot shine, refuses the scene
    struct lf_reference_params reference;
    uint32_t samples;       // a pixel
    double time_limit;      // seconds; 0: none
    const char *checkpoint; // file; may be null
    uint64_t picture;       // hash of all that the picture follows from besides `reference`
};

NG_NODISCARD ng_result render_reference_create(const struct render_reference_params *params,
                                               struct render_reference **out);
void render_reference_destroy(struct render_reference **reference);
// Makes the picture of a snapshot; `*samples` says how many it got. The snapshot must stay until the picture
// is fetched. With a checkpoint, a signal that asks the process to end (base/interrupt.h) does so after the
// samples at hand are kept.
NG_NODISCARD ng_result render_reference_draw(struct render_reference *reference,
                                             const struct ng_snapshot *snapshot, uint32_t *samples);
// Whether the samples of the last picture could not be kept in the checkpoint, which was logged. Null has
// none.
bool render_reference_unsaved(const struct render_reference *reference);
// The last picture's layers, and what a display shows if `display`. They belong to the reference until the
// next call.
NG_NODISCARD ng_result render_reference_fetch(struct render_reference *reference, const char *const *layers,
                                              uint32_t layer_count, bool display, struct output_picture *out);

#endif

// Antialiased pictures of the renderer's methods (render --aa): beauty is the mean of several frames, and all
// other layers are those of the middles of pixels.
#ifndef LIGHTFORMER_RENDER_ANTIALIAS_H
#define LIGHTFORMER_RENDER_ANTIALIAS_H

#include "output.h"

#include "app/stage.h"
#include "base/array.h"

#define RENDER_ANTIALIAS_SAMPLES 17 // if not asked for: the middle and pairs on both sides of it

// Layers that the last frames no longer have. Zero to begin with.
struct render_middles {
    struct output_layer layers[OUTPUT_MAX_LAYERS];
    NG_ARRAY(uint8_t) pixels[OUTPUT_MAX_LAYERS];
    uint32_t count;
};
void render_middles_finish(struct render_middles *middles);
// Null: it is not among them.
const struct output_layer *render_middles_find(const struct render_middles *middles, const char *name);

// Draws so many frames, after which the renderer has "beauty" and "display" of their mean, if they were asked
// for.
NG_NODISCARD ng_result render_antialias_draw(struct ng_stage *stage, const struct ng_stage_frame *frame,
                                             uint32_t samples, struct render_middles *middles);

// A layer of the last frame.
NG_NODISCARD ng_result render_fetch_layer(struct ng_renderer *renderer, const char *name,
                                          struct output_layer *out, uint32_t *width, uint32_t *height);

#endif

// The G-buffer: what the camera sees (render/frame.h, struct ng_gbuffer). One pass over the scene, one over
// lamps where there are some, one over the background where an environment shows.
#ifndef NG_RENDER_GBUFFER_H
#define NG_RENDER_GBUFFER_H

#include "base/extern_c.h"
#include "graph/provider.h"
#include "render/frame.h"

NG_EXTERN_C_BEGIN

struct ng_gpu;
struct ng_gbuffer_provider;

NG_NODISCARD ng_result ng_gbuffer_create(struct ng_gpu *gpu, struct ng_gbuffer_provider **out);
void ng_gbuffer_destroy(struct ng_gbuffer_provider **provider);
#define NG_GBUFFER_PROVIDER "gbuffer"
// Publishes ng_gbuffer_behind_lamps_item, and to consumers after it ng_gbuffer_item, with
// ng_gbuffer_picture_item in guided frames: each where nobody before it has. So another provider takes its
// place in a frame by standing before it and publishing them. The
// provider is borrowed while registered.
struct ng_provider ng_gbuffer_provider(struct ng_gbuffer_provider *provider);

// The images but depth, of light or of the picture, in an order: whoever makes them uses the names and
// formats that layers know.
#define NG_GBUFFER_COLORS 7
void ng_gbuffer_colors(struct ng_gbuffer *gbuffer, struct ng_graph_ref *out[NG_GBUFFER_COLORS]);
struct ng_graph_ref ng_gbuffer_add_color(struct ng_graph *g, int color, const struct ng_frame_info *frame,
                                         bool picture);

NG_EXTERN_C_END

#endif

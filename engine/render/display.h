// From radiance to a picture: beauty = T_d + T_i + emission, then exposure and the tone map.
#ifndef NG_RENDER_DISPLAY_H
#define NG_RENDER_DISPLAY_H

#include "graph/provider.h"

struct ng_gpu;
struct ng_display;

// The picture as a display shows it: RGBA8, sRGB-encoded; named "display" in the graph.
struct ng_display_result {
    struct ng_graph_ref beauty; // RGBA32F: radiance
    struct ng_graph_ref color;  // RGBA8 UNORM
};
extern const struct ng_item_type ng_display_item;

NG_NODISCARD ng_result ng_display_create(struct ng_gpu *gpu, struct ng_display **out);
void ng_display_destroy(struct ng_display **display);
// Consumes ng_radiance_item and the G-buffer's emission, publishes ng_display_item: register it after the
// methods.
struct ng_provider ng_display_provider(struct ng_display *display);

#endif

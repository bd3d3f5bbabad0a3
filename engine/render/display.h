// From radiance to a picture: beauty = T_d + T_i + emission, then exposure and the tone map.
#ifndef NG_RENDER_DISPLAY_H
#define NG_RENDER_DISPLAY_H

#include "graph/provider.h"

struct ng_display;
struct ng_gpu;

struct ng_display_result {
    struct ng_graph_ref beauty; // RGBA32F: radiance
    struct ng_graph_ref color;  // RGBA8 UNORM: as a display shows it, sRGB-encoded
};

NG_NODISCARD ng_result ng_display_create(struct ng_gpu *gpu, struct ng_display **out);
void ng_display_destroy(struct ng_display **display);
// Declares the passes that turn the frame's radiance into a picture: after ng_composer_declare. An error,
// logged, if no method published radiance.
NG_NODISCARD ng_result ng_display_declare(struct ng_display *display, struct ng_composer *composer,
                                          struct ng_display_result *out);

#endif

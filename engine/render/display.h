// From radiance to a picture: beauty = T_d + T_i + emission, then exposure and the tone map. Or any other
// layer of any method, two of them side by side, or how they differ.
#ifndef NG_RENDER_DISPLAY_H
#define NG_RENDER_DISPLAY_H

#include "base/extern_c.h"
#include "graph/provider.h"
#include "shaders/shared/display.h"

NG_EXTERN_C_BEGIN

struct ng_display;
struct ng_gpu;

struct ng_radiance;

// What a person is shown of a frame. Zero: beauty of the frame's method, alone. Radiance goes through
// exposure and tone map; reflectances and ratios are shown as they are, normals as (n + 1) / 2. A difference
// is the relative error of the left to the right side: orange where the left is brighter, blue where it is
// darker, full colour at NG_DIFFERENCE_FULL.
struct ng_shown {
    const char *layer;                      // a name of ng_display_layer; null: "beauty"
    uint32_t comparison;                    // NG_COMPARE_* of shaders/shared/display.h
    const char *other_layer, *other_method; // of the right side; null: those of the left
    float divider;                          // of the split: 0 the left edge to 1 the right edge
    uint32_t cell; // of the difference: it is of means over so many pixels a side, for sides with noise; 0: 1
};

struct ng_display_result {
    struct ng_graph_ref beauty;         // RGBA32F: radiance
    struct ng_graph_ref color;          // RGBA8 UNORM: as a display shows it, sRGB-encoded
    const struct ng_radiance *radiance; // of the frame's method; lives as long as the frame's items
    bool shows[2];                      // whether each side has its layer; black if not
};

// The layers that can be shown; null past the end. Thread-safe.
const char *ng_display_layer(uint32_t index);

NG_NODISCARD ng_result ng_display_create(struct ng_gpu *gpu, struct ng_display **out);
void ng_display_destroy(struct ng_display **display);
// Declares the passes that turn the frame's radiance into a picture: after ng_composer_declare. Errors,
// logged: NG_ERROR_NOT_FOUND if a method of the frame published no radiance, or there is no such layer.
// `adaptation` and `averaged` are those of struct ng_render_params.
NG_NODISCARD ng_result ng_display_declare(struct ng_display *display, struct ng_composer *composer,
                                          const struct ng_shown *shown, float adaptation, uint32_t averaged,
                                          struct ng_display_result *out);

NG_EXTERN_C_END

#endif

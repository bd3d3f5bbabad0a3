// What `lightformer view` shows, in a person's hands: a method and a layer of it, alone or compared with
// another. Plain data.
#ifndef LIGHTFORMER_VIEW_PICTURE_H
#define LIGHTFORMER_VIEW_PICTURE_H

#include "app/input.h"
#include "render/display.h"

enum { VIEW_LEFT, VIEW_RIGHT, VIEW_SIDES };

struct view_side {
    uint32_t method; // index into the table of methods
    uint32_t layer;  // of ng_display_layer
};

struct view_picture {
    struct view_side sides[VIEW_SIDES]; // alone: the left one
    uint32_t active;                    // side that keys change
    uint32_t comparison;                // NG_COMPARE_*
    float divider;                      // 0 to 1
    bool held, dragging;                // the left button was down; it holds the divider
};

// The keys, for people.
#define VIEW_PICTURE_KEYS                                                                                    \
    "1, 2, ...     a method (F2 names them)\n"                                                               \
    "L             next layer (direct, shadow, ...); Shift+L: of this side alone\n"                          \
    "C             alone, split, difference\n"                                                               \
    "Tab           the side that keys change\n"                                                              \
    "X             swap the sides\n"                                                                         \
    ", .           move the divider; or drag it\n"

// "alone", "split", "difference": names of comparisons; null past the end.
const char *view_comparison_name(uint32_t comparison);

// Takes in what a person did since the last frame, in a picture of this width; 0: the pointer is on something
// else.
void view_picture_react(struct view_picture *picture, const struct ng_input *input, uint32_t width);
// For struct ng_render_params.
const char *view_picture_method(const struct view_picture *picture);
struct ng_shown view_picture_shown(const struct view_picture *picture);

#endif

// Text and windows over a picture: an immediate-mode user interface (Dear ImGui), drawn by a pass of the
// render graph.
//
//     ng_ui_begin(ui, &frame);
//     if (ng_ui_window_begin(ui, "keys")) ng_ui_text(ui, "%s", "F1: keys");
//     ng_ui_window_end(ui);
//     ng_ui_end(ui);
//     ...
//     picture = ng_ui_add_pass(ui, graph, picture);     // inside of a frame's declaration
//
// One thread at a time: what an ended frame draws may be drawn on another one, before the next is begun. One
// user interface a process at a time: Dear ImGui's context is global.
#ifndef NG_EDITOR_UI_H
#define NG_EDITOR_UI_H

#include "app/input.h"
#include "base/extern_c.h"
#include "graph/graph.h"

NG_EXTERN_C_BEGIN

struct ng_ui;

struct ng_ui_params {
    struct ng_gpu *gpu; // borrowed
    VkFormat format;    // of the pictures to draw on: 8-bit UNORM, already encoded for display
    float scale;        // of text and windows; 0: 1
};

NG_NODISCARD ng_result ng_ui_create(const struct ng_ui_params *params, struct ng_ui **out);
void ng_ui_destroy(struct ng_ui **ui);

struct ng_ui_frame {
    uint32_t width, height;       // of the picture in pixels
    float seconds;                // since the last frame
    const struct ng_input *input; // borrowed for the call; null: nobody is there
};

// Begins a frame; what the last one showed is gone.
void ng_ui_begin(struct ng_ui *ui, const struct ng_ui_frame *frame);
// Whether the person's pointer is on a window, so that the scene should not react to it.
bool ng_ui_has_pointer(const struct ng_ui *ui);

// A window that fits what is in it, where there is room beside those that are there already
// (editor/layout.h); what has no room in it is scrolled to. False if it is collapsed: skip its content, but
// end it.
bool ng_ui_window_begin(struct ng_ui *ui, const char *title);
void ng_ui_window_end(struct ng_ui *ui);
void ng_ui_text(struct ng_ui *ui, const char *fmt, ...) NG_PRINTF(2, 3);

// Continues the line of what came last.
void ng_ui_same_line(struct ng_ui *ui);
// One of several words to choose from; true if the person chose it now. `group` tells apart choices of the
// same name.
bool ng_ui_choice(struct ng_ui *ui, const char *group, const char *word, bool chosen);

// A number on a bar, from `from` to `to`; `format` as of printf, for one double. True if the person changed
// it.
bool ng_ui_slider(struct ng_ui *ui, const char *name, float *value, float from, float to, const char *format);
// True if the person pressed it.
bool ng_ui_button(struct ng_ui *ui, const char *word);

// A line of text on a dark ground, over everything and no window's: pointers pass through. (x, y) is its
// corner that is nearest to the picture's, in pixels from the left, or if negative from the right, and the
// same for y. What is too long for the picture takes more lines. Returns its height in pixels.
float ng_ui_caption(struct ng_ui *ui, float x, float y, const char *fmt, ...) NG_PRINTF(4, 5);

// Ends the frame. Windows that were begun must have been ended.
void ng_ui_end(struct ng_ui *ui);
// Declares the pass "ui" that draws the frame that was ended last over `target`; returns the new version.
struct ng_graph_ref ng_ui_add_pass(struct ng_ui *ui, struct ng_graph *graph, struct ng_graph_ref target);

NG_EXTERN_C_END

#endif

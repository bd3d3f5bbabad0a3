// Dear ImGui behind a plain C header: input in, triangles out. Knows nothing of Vulkan. One context a
// process.
#ifndef NG_EDITOR_IMGUI_INTERNAL_H
#define NG_EDITOR_IMGUI_INTERNAL_H

#include "base/extern_c.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_input;

// As in ui.vert.
struct ng_imgui_vertex {
    float position[2]; // pixels
    float uv[2];       // in the font image
    uint32_t color;    // RGBA8, red in the low byte
};

// Triangles under one clip rectangle.
struct ng_imgui_draw {
    uint32_t first_index, index_count;
    float clip_min[2], clip_max[2]; // pixels
};

struct ng_imgui_counts {
    uint32_t vertices, indices, draws;
};

void ng_imgui_create(float scale);
void ng_imgui_destroy(void);
// The font image: 8-bit coverage. Borrowed until ng_imgui_destroy.
const unsigned char *ng_imgui_font(uint32_t *width, uint32_t *height);

void ng_imgui_begin(float width, float height, float seconds, const struct ng_input *input);
bool ng_imgui_has_pointer(void);
bool ng_imgui_window_begin(const char *title);
void ng_imgui_window_end(void);
void ng_imgui_text(const char *fmt, va_list args);
void ng_imgui_same_line(void);
bool ng_imgui_choice(const char *group, const char *word, bool chosen);
bool ng_imgui_slider(const char *name, float *value, float from, float to, const char *format);
bool ng_imgui_button(const char *word);
float ng_imgui_caption(float x, float y, const char *text);

// Ends the frame.
struct ng_imgui_counts ng_imgui_end(void);
// Copies what the ended frame draws, into arrays of these counts. Indices count from the first vertex.
void ng_imgui_copy(struct ng_imgui_vertex *vertices, uint32_t *indices, struct ng_imgui_draw *draws);

NG_EXTERN_C_END

#endif

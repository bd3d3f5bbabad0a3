// The picture in a window, and what is drawn over it, however long the next picture takes.
//
//     ng_screen_create(&(struct ng_screen_params){.window = window}, &screen);
//     ng_screen_take(screen, pixels, width, height);      // whenever there is a new picture
//     ng_screen_show(screen, &showing);                   // whenever something over it has changed
//     ng_screen_destroy(&screen);                         // before the window
//
// A screen has a device of its own, so that neither a frame at work on another thread nor its queue makes a
// person wait. Pictures come as bytes of the host. Created and destroyed on the window's thread; shown on
// any, one at a time, for example on one that may wait for the display.
#ifndef NG_APP_SCREEN_H
#define NG_APP_SCREEN_H

#include "base/extern_c.h"
#include "graph/graph.h"

NG_EXTERN_C_BEGIN

struct ng_window;
struct ng_screen_internal;

struct ng_screen_params {
    struct ng_window *window; // borrowed, must outlive the screen
    const char *device;       // as in struct ng_gpu_params
};

// Read only for callers.
struct ng_screen {
    struct ng_gpu *gpu; // for what is drawn over the picture
    struct ng_screen_internal *internal;
};

NG_NODISCARD ng_result ng_screen_create(const struct ng_screen_params *params, struct ng_screen **out);
void ng_screen_destroy(struct ng_screen **screen);

// The picture from now on: [height][width][4], sRGB-encoded, borrowed until the next one is taken or the
// screen is destroyed. None: black.
void ng_screen_take(struct ng_screen *screen, const uint8_t *rgba, uint32_t width, uint32_t height);

struct ng_screen_showing {
    uint32_t width, height; // of the window; 0: it is minimised, and nothing is shown
    // Draws on `display` (RGBA8 UNORM, about as large as the window), and returns its new version.
    struct ng_graph_ref (*overlay)(void *user, struct ng_graph *graph, struct ng_graph_ref display);
    void *user;
};
// Shows the picture, scaled to the window, with the overlay.
NG_NODISCARD ng_result ng_screen_show(struct ng_screen *screen, const struct ng_screen_showing *showing);

NG_EXTERN_C_END

#endif

// A picture of a snapshot: the engine's own providers in one frame of the render graph.
//
//     ng_renderer_create(&params, &renderer);
//     ng_extract(extractor, &extract_params, &snapshot);
//     ng_renderer_frame(renderer, &(struct ng_render_params){.snapshot = snapshot, .width = 512, .height =
//     512,
//                                                            .layers = layers, .layer_count = 2});
//     ng_renderer_layer(renderer, "beauty", &layer);          // pixels on the host
//
// Other features join by registering providers (ng_renderer_composer): see render/frame.h for what they meet
// at. A renderer belongs to one thread. In the steady state a frame allocates nothing.
#ifndef NG_RENDER_RENDERER_H
#define NG_RENDER_RENDERER_H

#include "base/extern_c.h"
#include "graph/provider.h"
#include "render/display.h"
#include "render/light_maps.h"
#include "render/snapshot.h"

NG_EXTERN_C_BEGIN

struct ng_cmd;
struct ng_gpu;
struct ng_gpu_image;
struct ng_jobs;
struct ng_renderer;

struct ng_renderer_params {
    struct ng_gpu *gpu;    // needed; borrowed
    struct ng_jobs *jobs;  // borrowed; null: CPU passes run on the caller's thread
    uint64_t depth_budget; // bytes for all lights' depth maps; 0: 192 MiB
    float cascade_radius;  // metres; 0: 40 (light_maps.h)
    // For benchmarks and tests; pictures do not depend on them:
    bool no_culling, no_aliasing; // of the graph
    bool redraw_lights;           // draw every light's maps in every frame
    bool bare_passes; // adds "bare:camera" and "bare:<light>/depth": depth alone, to measure against
};

NG_NODISCARD ng_result ng_renderer_create(const struct ng_renderer_params *params, struct ng_renderer **out);
// Waits until the GPU is done with it.
void ng_renderer_destroy(struct ng_renderer **renderer);

struct ng_render_params {
    const struct ng_snapshot *snapshot; // needed; borrowed for the call
    uint32_t width, height;             // pixels, at least 1
    // Light is computed for so many pixels, and beauty is upsampled from them, guided by a G-buffer that has
    // all (render/upsample.h); other layers have only these. 0: for all.
    uint32_t light_width, light_height;
    const char *method;        // null: "raster"
    struct ng_shown shown;     // zero: beauty of this method
    const char *const *layers; // names to fetch with ng_renderer_layer, borrowed for the call
    uint32_t layer_count;
    // Any resources of the graph by name ("rsm:lamp/flux"), to fetch with ng_graph_readback_get; borrowed for
    // the call.
    const char *const *resources;
    uint32_t resource_count;
    // Draws over the picture before it is shown or fetched, inside of the frame's declaration; null: nothing.
    // Returns the new version of `display` (RGBA8 UNORM, sRGB-encoded).
    struct ng_graph_ref (*overlay)(void *user, struct ng_graph *graph, struct ng_graph_ref display);
    void *overlay_user;
    // Of cameras with auto_exposure: the part of the way from the last frame's exposure to this picture's, in
    // stops, for pictures that are seen one after the other; 0: all of it, whatever came before.
    float adaptation;
    // Antialiasing: beauty is the mean of this frame and of those before it, of which this is the nth; 1
    // begins a mean, the number of the last frame shows that mean again, and 0 is a picture of its own. The
    // frames' snapshots differ in `camera.subpixel` alone, which counts them from 0. Other layers are this
    // frame's, and so is a side that it is compared with.
    uint32_t averaged;
    // Whether to give the frame up, asked on this thread while it is made (ng_graph_abandon_when); null:
    // never.
    bool (*abandon)(void *user);
    void *abandon_user;
    // Where the picture goes, scaled to fit if sizes differ: a swapchain's image, left ready to present.
    // Null: nowhere.
    struct ng_gpu_image *target;
};

// Records one picture into the commands of a frame (gpu/frame.h: ng_frame_begin before, ng_frame_end after,
// which the caller does in every case). NG_ABANDONED if that was asked for: there is no picture, and the next
// frame is as right as if this one had never been. Does not wait for the GPU unless a CPU pass does; `*cmd`
// may then be another one.
NG_NODISCARD ng_result ng_renderer_frame(struct ng_renderer *renderer, struct ng_cmd **cmd,
                                         const struct ng_render_params *params);

// ---- Results ---------------------------------------------------------------------------------------------

// A layer of engine/README.md ("Layers of a picture"), or "display".
struct ng_layer_info {
    const char *name; // "beauty", "direct", "unshadowed", "shadow", ...
    const char
        *channels[4]; // EXR channel names within the layer: "R", "G", "B"; "X"; "Z"; "id"; null-terminated
    bool uint;        // 32-bit unsigned instead of float
    const char *doc;  // one line
};
// All layers, in order; null past the end.
const struct ng_layer_info *ng_renderer_layer_info(uint32_t index);
const struct ng_layer_info *ng_renderer_find_layer(const char *name);

struct ng_layer {
    const struct ng_layer_info *info;
    uint32_t width, height, channels;
    // [height][width][channels], row 0 on top; uint32_t for uint layers. Owned by the renderer, valid until
    // its next frame.
    const float *pixels;
    const uint32_t *ids;
};
// Waits for the last frame and converts. The layer must have been named in its ng_render_params. A layer that
// the frame's method does not compute (raster: "indirect") is an error that says so, NG_ERROR_UNSUPPORTED.
NG_NODISCARD ng_result ng_renderer_layer(struct ng_renderer *renderer, const char *name,
                                         struct ng_layer *out);
// The picture as shown: RGBA bytes, sRGB-encoded, [height][width][4]; "display" must have been named.
NG_NODISCARD ng_result ng_renderer_display(struct ng_renderer *renderer, const uint8_t **rgba,
                                           uint32_t *width, uint32_t *height);
// What is at a pixel of the last frame, in which "entity" must have been named: an index half of an entity's
// id, 0 where there is nothing.
NG_NODISCARD ng_result ng_renderer_pick(struct ng_renderer *renderer, uint32_t x, uint32_t y, ng_entity *out);

// Whether the last frame had what it was to show on a side (0: left or alone, 1: right); false: the method
// does not compute that layer, and black is shown.
bool ng_renderer_shows(const struct ng_renderer *renderer, uint32_t side);

// For providers of other features, pass times and dumps. Borrowed.
struct ng_composer *ng_renderer_composer(struct ng_renderer *renderer);
struct ng_graph *ng_renderer_graph(struct ng_renderer *renderer);

NG_EXTERN_C_END

#endif

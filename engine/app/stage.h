// A scene on a stage: everything between the name of a file and frames of it, in a window or without one.
//
//     struct ng_stage *stage;
//     NG_TRY(ng_stage_create(&(struct ng_stage_params){.scene = "content/chess/chess.glb"}, &stage));
//     NG_TRY(ng_stage_draw(stage, &(struct ng_stage_frame){.time = 0.5, .width = 512, .height = 512}));
//     ...
//     ng_stage_destroy(&stage);
//
// A stage is a convenience: it owns one of each part of the engine and calls them in the order that every
// program would. The parts are there for whoever wants more of them. One thread.
#ifndef NG_APP_STAGE_H
#define NG_APP_STAGE_H

#include "asset/gltf.h"
#include "base/extern_c.h"
#include "render/extract.h"
#include "render/renderer.h"

NG_EXTERN_C_BEGIN

struct ng_window;

struct ng_stage_params {
    const char *scene;        // as ng_gltf_load takes it
    struct ng_window *window; // where frames appear; borrowed, must outlive the stage; null: no window
    const char *device;       // as in struct ng_gpu_params
    uint32_t threads;         // as in struct ng_jobs_params
    bool no_device;           // nothing is drawn: ng_stage_seek and its snapshot are all there is
    bool no_default_light;    // a file without light stays dark
    enum ng_gltf_emitters emissive_lights; // as in struct ng_gltf_params
    const char *clip;                      // the same
    struct ng_exposure exposure;           // of all frames (render/extract.h)
    // As in struct ng_gltf_params:
    bool strict;
    uint64_t max_memory;
    void (*file)(void *user, const char *path);
    void *user;
    // As in struct ng_renderer_params, for benchmarks:
    bool redraw_lights, bare_passes;
};

struct ng_stage_internal;

// Read only for callers; what the parts do, their own headers say.
struct ng_stage {
    struct ng_jobs *jobs;
    struct ng_gpu *gpu;
    struct ng_assets *assets;
    struct ng_world *world;
    struct ng_gltf_scene scene;
    struct ng_renderer *renderer;
    const struct ng_snapshot *snapshot; // of the last frame
    double world_ms, extract_ms;        // of the last frame: systems (animation, ...); skinning and the rest
    struct ng_stage_internal *internal;
};

// Loads the scene and opens the device. Every failure was logged by the part that met it.
NG_NODISCARD ng_result ng_stage_create(const struct ng_stage_params *params, struct ng_stage **out);
void ng_stage_destroy(struct ng_stage **stage);

// Makes `next`, a stage without a device, this one's scene: what this one had is destroyed, and so is the
// rest of
// `*next`. For a scene that is opened while another is shown: if it cannot be loaded, nothing happens to
// that. Whoever joined the renderer has left it before, and joins the new one. After an error there is
// nothing to draw with any more.
NG_NODISCARD ng_result ng_stage_adopt(struct ng_stage *stage, struct ng_stage **next);

// From now on the scene is seen through a camera that is not in it, whatever else is asked for; null: through
// its own again.
void ng_stage_look(struct ng_stage *stage, const struct ng_free_camera *camera);

struct ng_stage_frame {
    double time;            // seconds: what the scene is evaluated at
    bool still;             // the time jumped: no motion since the last frame
    const char *camera;     // name of an entity; null: the scene's first camera
    uint32_t width, height; // of the picture, pixels; 0: the window's size
    // As in struct ng_render_params:
    uint32_t light_width, light_height;
    const char *method;
    struct ng_shown shown;
    const char *const *layers;
    uint32_t layer_count;
    const char *const *resources;
    uint32_t resource_count;
    struct ng_graph_ref (*overlay)(void *user, struct ng_graph *graph, struct ng_graph_ref display);
    void *overlay_user;
    float adaptation;
    uint32_t averaged; // its camera follows by itself
    bool (*abandon)(void *user);
    void *abandon_user;
};

// Moves the scene to a time without drawing: what the next frame's motion is measured from.
NG_NODISCARD ng_result ng_stage_seek(struct ng_stage *stage, double time, const char *camera);
// The same with motion since the frame or seek before: for methods that draw without a device.
NG_NODISCARD ng_result ng_stage_advance(struct ng_stage *stage, double time, const char *camera);
// Moves the scene to the frame's time, draws it and shows it in the window. Nothing is drawn for a minimised
// window.
NG_NODISCARD ng_result ng_stage_draw(struct ng_stage *stage, const struct ng_stage_frame *frame);

NG_EXTERN_C_END

#endif

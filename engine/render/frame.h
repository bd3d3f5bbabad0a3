// What the providers of a frame meet at (graph/provider.h): the items that one publishes and others consume.
//
//     ng_frame_item        one a frame, from the renderer: the snapshot and where its data is on the GPU
//     ng_gbuffer_item      one a frame, from the G-buffer provider: what the camera sees; producers get the
//                          same without lamps (ng_gbuffer_behind_lamps_item)
//     ng_light_maps_item   one a light, from the light-maps provider: its reflective shadow map
//     ng_radiance_item     one from each method that the frame wants: what arrives at the camera
//
// A method (raster here, others elsewhere) is a provider that consumes the first three and publishes the
// last.
#ifndef NG_RENDER_FRAME_H
#define NG_RENDER_FRAME_H

#include "base/extern_c.h"
#include "graph/provider.h"
#include "render/snapshot.h"
#include "shaders/shared/scene.h"

#include <string.h>

NG_EXTERN_C_BEGIN

struct ng_gpu;
struct ng_scene_gpu;

// The depth map of a light never has more views than this.
#define NG_LIGHT_MAX_VIEWS 6
// Size of the small maps (position, normal, flux) of a light, texels a side.
#define NG_RSM_SIZE        64

// Lights that give light in a frame, at most: with its maps and the passes of every method a light takes up
// to 16 of the 65,535 resources that a graph holds. A path tracer has no maps, and no such limit.
#define NG_MAX_LIGHTS 4095

struct ng_frame_info {
    const struct ng_gpu *gpu;
    const struct ng_snapshot *snapshot;
    struct ng_scene_gpu *scene; // render/scene_gpu.h: buffers and draws of the snapshot
    uint32_t width, height;     // at which light is computed, and the G-buffer that it needs
    uint32_t picture[2];        // width and height of the picture: these, or more
    const char *method;         // name of the method whose picture this is
    const char *other_method;   // of the one that it is compared with; null: none
};
extern const struct ng_item_type ng_frame_item;

// Whether the method of that name is to publish radiance in this frame.
static inline bool ng_frame_wants(const struct ng_frame_info *frame, const char *method)
{
    return strcmp(frame->method, method) == 0 ||
           (frame->other_method && strcmp(frame->other_method, method) == 0);
}

// Whether the picture has more pixels than light is computed for.
static inline bool ng_frame_is_guided(const struct ng_frame_info *frame)
{
    return frame->picture[0] != frame->width || frame->picture[1] != frame->height;
}

// All of the frame's size. "Surface" pixels have position.w = 1, or -1 where
// it reflects nothing and is what it emits; others 0 throughout except emission.
struct ng_gbuffer {
    struct ng_graph_ref position; // RGBA32F: world space, metres; w: as above
    struct ng_graph_ref normal;   // RGBA16F: shading normal, world; w: roughness
    struct ng_graph_ref diffuse;  // RGBA16F: diffuse albedo; w: x of the octahedral geometric normal
    struct ng_graph_ref specular; // RGBA16F: F0; w: y of the octahedral geometric normal
    struct ng_graph_ref emission; // RGBA32F: emitted radiance, the environment's too; w: 1 on lamps, else 0
    struct ng_graph_ref motion;   // RG32F: pixels, now - before
    struct ng_graph_ref entity;   // R32_UINT: index half of the entity's id
    struct ng_graph_ref depth;    // D32F: reverse-Z; zero where it was not rasterized
    bool lamps;                   // the scene has some (render/snapshot.h)
    bool on_host;                 // written by passes of the CPU, for a device that draws there
};
extern const struct ng_item_type ng_gbuffer_item; // for consumers
// In guided frames: with all the picture's pixels, lamps among them. It guides the light to them.
extern const struct ng_item_type ng_gbuffer_picture_item;
extern const struct ng_item_type
    ng_gbuffer_behind_lamps_item; // for producers: before lamps are drawn over it

// The reflective shadow map of one light (paper 4.2; conventions in engine/README.md, "Light observation").
struct ng_light_maps {
    uint32_t light;                  // index in the snapshot
    const char *name;                // unique in the frame; prefix of the light's passes: "lamp"
    uint32_t depth_views, rsm_views; // layers of the two; they differ for cascaded lights only
    uint32_t face_size;              // of the depth map, texels
    struct ng_graph_ref depth;       // D32F array [depth_views]: reverse-Z of the view
    struct ng_graph_ref sky;         // D32F array, a layer for each view of a sky; else null
    struct ng_graph_ref position;    // RGBA32F array [rsm_views], NG_RSM_SIZE: world; w: as above
    struct ng_graph_ref normal;      // RGBA16F, the same: shading normal towards the light
    struct ng_graph_ref flux;        // RGBA32F, the same: reflected flux, W
    const struct ng_light_gpu *gpu;  // light_gpu.h: what shaders need of the light
};
extern const struct ng_item_type ng_light_maps_item;

// Radiance without emission, at pixel centres. Refs that a method does not compute are zero. The method NAME
// calls its images "NAME/unshadowed", "NAME/direct" and "NAME/indirect": so layers find them in the graph.
struct ng_radiance {
    const char *method;             // name of the one that publishes
    struct ng_graph_ref unshadowed; // RGBA32F: T_l
    struct ng_graph_ref direct;     // RGBA32F: T_d
    struct ng_graph_ref indirect;   // RGBA32F: T_i
    bool on_host;                   // written by passes of the CPU
};
extern const struct ng_item_type ng_radiance_item;

NG_EXTERN_C_END

#endif

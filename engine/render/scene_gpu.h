// The snapshot on the GPU: geometry, textures, instances and materials, and the one loop that draws them.
//
// Meshes and images are uploaded when they are first seen and dropped when they have not been seen for a
// while; what changes every frame goes through the frame's own memory. Nothing here knows what a pass is for.
#ifndef NG_RENDER_SCENE_GPU_H
#define NG_RENDER_SCENE_GPU_H

#include "base/extern_c.h"
#include "gpu/frame.h"
#include "gpu/pipeline.h"
#include "render/snapshot.h"
#include "shaders/shared/scene.h"

NG_EXTERN_C_BEGIN

struct ng_scene_gpu;

NG_NODISCARD ng_result ng_scene_gpu_create(struct ng_gpu *gpu, struct ng_scene_gpu **out);
void ng_scene_gpu_destroy(struct ng_scene_gpu **scene);

// Takes a snapshot in, within a frame (gpu/frame.h) and before its first draw: uploads what is new, sorts the
// instances for drawing, writes the frame's view, instances and materials. The snapshot is borrowed until the
// next call.
NG_NODISCARD ng_result ng_scene_gpu_update(struct ng_scene_gpu *scene, const struct ng_snapshot *snapshot,
                                           uint32_t width, uint32_t height);

// After it, in frames whose picture is of another size: the camera's view of the picture.
NG_NODISCARD ng_result ng_scene_gpu_add_picture(struct ng_scene_gpu *scene, uint32_t width, uint32_t height);

// The vertex streams of a pipeline that draws scene geometry.
enum ng_vertex_streams {
    NG_STREAMS_POSITION,                // location 0
    NG_STREAMS_POSITION_UV,             // 0 and, as location 1, texture coordinates
    NG_STREAMS_SURFACE,                 // 0 position, 1 normal
    NG_STREAMS_SURFACE_MOVING,          // and 2 previous position
    NG_STREAMS_SURFACE_TEXTURED,        // 0 position, 1 normal, 2 tangent, 3 texture coordinates
    NG_STREAMS_SURFACE_TEXTURED_MOVING, // and 4 previous position
    NG_STREAMS_POSITION_FULL,           // 0 position, 1 and 2 both sets of texture coordinates, 3 colour
    NG_STREAMS_SURFACE_FULL,            // _SURFACE_TEXTURED, 4 the second texture coordinates, 5 colour
    NG_STREAMS_SURFACE_FULL_MOVING,     // and 6 previous position
};
// Fills the vertex input of `params` for these streams; the arrays are static.
void ng_scene_gpu_vertex_input(enum ng_vertex_streams streams, struct ng_gpu_graphics_params *params);
// Slots of set 1, a material's textures (enum ng_material_texture): append these to the slots of a pipeline
// for NG_STREAMS_*_TEXTURED or masked materials.
#define NG_MATERIAL_SLOTS                                                                                    \
    NG_MATERIAL_SLOT(0), NG_MATERIAL_SLOT(1), NG_MATERIAL_SLOT(2), NG_MATERIAL_SLOT(3), NG_MATERIAL_SLOT(4), \
        NG_MATERIAL_SLOT(5)
#define NG_MATERIAL_SLOT(n)                                                                                  \
    {                                                                                                        \
        .set = 1, .binding = (n), .type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,                         \
        .stages = VK_SHADER_STAGE_FRAGMENT_BIT                                                               \
    }

// Bindings of set 0 that every pass over the scene has.
struct ng_gpu_binding ng_scene_gpu_view(const struct ng_scene_gpu *scene, uint32_t binding);
struct ng_gpu_binding ng_scene_gpu_picture_view(const struct ng_scene_gpu *scene, uint32_t binding);
struct ng_gpu_binding ng_scene_gpu_instances(const struct ng_scene_gpu *scene, uint32_t binding);
struct ng_gpu_binding ng_scene_gpu_materials(const struct ng_scene_gpu *scene, uint32_t binding);
// View-projection of the camera, column-major, and whether it mirrors; for ng_draw_params.
const float *ng_scene_gpu_camera(const struct ng_scene_gpu *scene);
bool ng_scene_gpu_camera_mirrors(const struct ng_scene_gpu *scene);
// Image of the snapshot as a sampled texture that is no surface's, so without anisotropy; NG_NONE: white.
struct ng_gpu_binding ng_scene_gpu_image(const struct ng_scene_gpu *scene, uint32_t image, uint32_t binding);

// One black texel.
struct ng_gpu_binding ng_scene_gpu_black(const struct ng_scene_gpu *scene, uint32_t binding);

struct ng_draw_params {
    // What materials without textures, those of them that have moved, materials with textures or a mask, and
    // meshes whose colours or second texture coordinates are used are drawn with. No `moving`: motion does
    // not matter, as `plain`. No `full`: as `textured`.
    struct ng_draw_pipeline {
        const struct ng_gpu_pipeline *pipeline;
        enum ng_vertex_streams streams;
    } plain, moving, textured, full;
    bool depth_only;                       // a mask matters, other textures do not
    const struct ng_gpu_binding *bindings; // set 0, for both pipelines
    uint32_t binding_count;
    const void *push; // push constants, for both pipelines
    uint32_t push_size;
    const float *view_projection; // instances outside of it are not drawn
    bool mirrors;                 // the view is a mirror's: front faces turn the other way on screen
    uint32_t skip_light;          // emitters in the place of this light are not drawn; NG_NONE: all are
    bool cull_back;               // one-sided surfaces are seen from the front only
    // Lamps (render/snapshot.h) alone, or all but them.
    enum ng_draw_lamps { NG_LAMPS_TOO, NG_LAMPS_ONLY, NG_LAMPS_NOT } lamps;
};
NG_NODISCARD ng_result ng_scene_gpu_draw(struct ng_scene_gpu *scene, struct ng_cmd *cmd,
                                         const struct ng_draw_params *params);

struct ng_seen_params {
    float view_projection[16];
    uint32_t skip_light; // as for draws
    bool not_beside;     // lamps beside that light (ng_lamp_is_beside) do not count
};
// A key (graph/key.h) of everything that a view of the scene shows.
uint64_t ng_scene_gpu_seen(const struct ng_scene_gpu *scene, const struct ng_seen_params *params);

NG_EXTERN_C_END

#endif

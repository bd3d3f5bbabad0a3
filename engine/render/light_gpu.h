// A light of the snapshot in the form that shaders take: VPLs, views, and a few numbers.
//
// Knows no light type: everything follows from the type's own functions (light/light.h).
#ifndef NG_RENDER_LIGHT_GPU_H
#define NG_RENDER_LIGHT_GPU_H

#include "base/extern_c.h"
#include "gpu/frame.h"
#include "gpu/pipeline.h"
#include "render/frame.h"
#include "shaders/shared/scene.h"

NG_EXTERN_C_BEGIN

#define NG_LIGHT_VPLS 32 // for the sums of shaders; delta lights need one

// Plain data. The ranges are valid for the frame.
struct ng_light_gpu {
    struct ng_light_data data;
    struct ng_vpl_data vpls[NG_LIGHT_VPLS];
    struct ng_light_view_data depth_views[NG_LIGHT_MAX_VIEWS], rsm_views[NG_LIGHT_MAX_VIEWS];
    uint32_t depth_view_count, rsm_view_count;
    // Of a sky, light from so many directions that one depth map tells nothing: so many VPLs, the first ones,
    // have a view each. 0: no sky.
    uint32_t sky_view_count;
    struct ng_frame_range data_range, vpl_range, depth_view_range, rsm_view_range, sky_range, facet_range;
};

// Observes a light. A scene wider than `cascade_radius` makes orthographic lights follow the camera with four
// cascades; the RSM's views never follow it. `source`: the light as it shines, or as ng_light_unit makes it;
// views, proxy and axes are the same.
void ng_light_gpu_observe(const struct ng_snapshot *snapshot, uint32_t light,
                          const struct ng_light_source *source, float aspect, float cascade_radius,
                          struct ng_light_gpu *out);
// Texel-snaps the cascades and tells the shaders the size of the depth map.
void ng_light_gpu_set_face_size(struct ng_light_gpu *light, uint32_t face_size);
// Of a sky: how the scene looks from where a VPL shines.
void ng_light_gpu_sky_view(const struct ng_light_gpu *light, const struct ng_snapshot *snapshot, uint32_t vpl,
                           struct ng_light_view_data *out);
// Writes the buffers of the frame that is open (gpu/frame.h).
NG_NODISCARD ng_result ng_light_gpu_record(struct ng_gpu *gpu, const struct ng_snapshot *snapshot,
                                           struct ng_light_gpu *light);

// Bindings 7 (views), 8 (light) and 9 (VPLs) of set 0, as the shaders number them.
void ng_light_gpu_bindings(const struct ng_light_gpu *light, bool rsm, struct ng_gpu_binding out[3]);

NG_EXTERN_C_END

#endif

// What the renderer's passes drew, as plain data on the host: the G-buffer, and of each light its direct
// VPLs, its reflective shadow map and its depth maps (paper 4.1 to 4.3; engine/README.md, "Light
// observation").
//
// lf_shadow_lookup is the one definition of the lookup in a depth map.
#ifndef LF_CLUES_CAPTURED_H
#define LF_CLUES_CAPTURED_H

#include "base/extern_c.h"
#include "light/light.h"
#include "shaders/shared/scene.h"

NG_EXTERN_C_BEGIN

#define LF_VPL_COUNT 500 // of a light, where the parameters do not say

// A light that shines. Pictures are stored row by row from the top, views one after another.
struct lf_captured_light {
    uint32_t light;               // index in the snapshot
    float power[3];               // W, by channel
    struct ng_light_data data;    // proxy, faces or windows of the depth map: as shaders have it
    struct ng_light_sample *vpls; // [vpl_count of the frame]
    uint32_t rsm_views;           // of 64 x 64 texels (NG_RSM_SIZE)
    const float *position;  // [rsm_views][64][64][4] world, metres; w: 1 where there is a surface, else 0
    const uint16_t *normal; // the same, halfs: shading normal, world
    const float *flux;      // the same: reflected flux, W
    uint32_t depth_views, face_size;
    const float *depth; // [depth_views][face_size][face_size] reverse-Z
};

// [height][width][4]; layouts as struct ng_gbuffer of render/frame.h. uint16_t are halfs.
struct lf_gbuffer {
    const float *position;    // world, metres; w: 1 where there is a surface
    const uint16_t *normal;   // shading normal, world; w: roughness
    const uint16_t *diffuse;  // albedo
    const uint16_t *specular; // F0
    const float *emission;    // radiance
};

// A depth map in host memory. `depth`: [layers][face_size][face_size], reverse-Z as the views of `light` draw
// it; a layer that `layers` does not have is outside of the map.
struct lf_depth_map {
    const struct ng_light_data *light;
    const float *depth;
    uint32_t layers, face_size;
};

struct lf_shadow_distance {
    float
        receiver; // d_f: metres from the proxy (cube) or the scene sphere's entry (orthographic) to the point
    float occluder; // d: the same to what the light sees in the point's direction; d_f outside of the map,
                    // and where the light sees nothing
};

// Equation 2's distances for a world position. Pure.
struct lf_shadow_distance lf_shadow_lookup(const struct lf_depth_map *map, const float position[3]);

NG_EXTERN_C_END

#endif

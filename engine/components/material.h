// A surface: metallic-roughness, as glTF 2.0. Materials are entities, so that editing one is a transaction
// and all meshes that refer to it follow.
//
// diffuse albedo = base * (1 - metallic);  F0 = mix(0.04, base, metallic);  alpha = roughness^2, roughness >=
// 0.045.
#ifndef NG_COMPONENTS_MATERIAL_H
#define NG_COMPONENTS_MATERIAL_H

#include "scene/component.h"

struct ng_material {
    float base_color[3];       // linear; multiplies the texture
    float metallic, roughness; // multiply the texture's B and G
    float emissive[3];         // linear colour; multiplies the texture
    float emissive_strength;   // radiance = emissive * strength, W/(sr m2)
    float normal_scale;        // on the tangent-space x and y of the normal map
    float alpha;               // base colour's alpha; multiplies the texture
    float alpha_cutoff;        // mask: alpha below this is a hole
    bool alpha_mask;           // false: opaque, alpha ignored
    bool double_sided;
    ng_asset base_color_texture; // struct ng_image, sRGB
    ng_asset metallic_roughness_texture;
    ng_asset normal_texture;
    ng_asset emissive_texture; // sRGB
    // Which set of texture coordinates of the mesh each texture uses: 0 or 1.
    uint32_t base_color_uv_set, metallic_roughness_uv_set, normal_uv_set, emissive_uv_set;
};

#endif

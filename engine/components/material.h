// A surface: metallic-roughness, as glTF 2.0. Materials are entities, so that editing one is a transaction
// and all meshes that refer to it follow.
//
// diffuse albedo = base * (1 - metallic);  F0 = mix(dielectric, base, metallic);  alpha = roughness^2,
// roughness >= 0.045. The dielectric part is that of KHR_materials_ior and KHR_materials_specular:
// specular * min(((ior - 1) / (ior + 1))^2 * specular_color, 1); its F90 stays 1.
#ifndef NG_COMPONENTS_MATERIAL_H
#define NG_COMPONENTS_MATERIAL_H

#include "scene/component.h"

// What the alpha of the base colour means.
enum ng_alpha_mode {
    NG_ALPHA_OPAQUE, // nothing
    NG_ALPHA_MASK,   // where it is below alpha_cutoff is a hole
    NG_ALPHA_BLEND,  // the part that the surface covers of what is behind it
};

// Where on a texture a surface's coordinates lie (KHR_texture_transform): scaled, then turned, then moved.
struct ng_texture_transform {
    float offset[2], rotation, scale[2]; // of the whole picture; radians, counter-clockwise
};

// The textures of a material, in the order of their fields.
enum ng_material_texture {
    NG_TEXTURE_BASE_COLOR,
    NG_TEXTURE_METALLIC_ROUGHNESS,
    NG_TEXTURE_NORMAL,
    NG_TEXTURE_EMISSIVE,
    NG_TEXTURE_SPECULAR,
    NG_TEXTURE_SPECULAR_COLOR,
    NG_TEXTURE_COUNT
};

struct ng_material {
    float base_color[3];       // linear; multiplies the texture
    float metallic, roughness; // multiply the texture's B and G
    float emissive[3];         // linear colour; multiplies the texture
    float emissive_strength;   // radiance = emissive * strength, W/(sr m2)
    float normal_scale;        // on the tangent-space x and y of the normal map
    float alpha;               // base colour's alpha; multiplies the texture
    float alpha_cutoff;        // NG_ALPHA_MASK: alpha below this is a hole
    uint32_t alpha_mode;       // enum ng_alpha_mode
    float ior;                 // 0: infinite, the dielectric part reflects all of specular_color
    float specular;            // of the dielectric part; multiplies the texture's A
    float specular_color[3];   // linear, may be above 1; multiplies the texture
    bool double_sided;
    bool unlit; // KHR_materials_unlit: shows its base colour as radiance, and has no part in light

    // One texture each for what it is named after, and where on it the coordinates lie.
    ng_asset base_color_texture; // struct ng_image, sRGB
    ng_asset metallic_roughness_texture;
    ng_asset normal_texture;
    ng_asset emissive_texture;       // sRGB
    ng_asset specular_texture;       // A
    ng_asset specular_color_texture; // sRGB
    // Which set of texture coordinates of the mesh each texture uses: 0 or 1.
    uint32_t base_color_uv_set, metallic_roughness_uv_set, normal_uv_set, emissive_uv_set;
    uint32_t specular_uv_set, specular_color_uv_set;
    struct ng_texture_transform base_color_transform, metallic_roughness_transform, normal_transform;
    struct ng_texture_transform emissive_transform, specular_transform, specular_color_transform;
};

// A texture of a material, whichever.
struct ng_material_texture_use {
    ng_asset image;
    uint32_t uv_set;
    struct ng_texture_transform transform;
};

static inline struct ng_material_texture_use ng_material_texture_of(const struct ng_material *m,
                                                                    enum ng_material_texture texture)
{
#define NG_USE_OF(name)                                                                                      \
    {                                                                                                        \
        m->name##_texture, m->name##_uv_set, m->name##_transform                                             \
    }
    const struct ng_material_texture_use uses[NG_TEXTURE_COUNT] = {
        NG_USE_OF(base_color), NG_USE_OF(metallic_roughness), NG_USE_OF(normal),
        NG_USE_OF(emissive),   NG_USE_OF(specular),           NG_USE_OF(specular_color)};
#undef NG_USE_OF
    return uses[texture];
}

#endif

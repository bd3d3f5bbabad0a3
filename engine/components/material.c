#include "components/material.h"

static const struct ng_material defaults = {.base_color = {1, 1, 1},
                                            .metallic = 0.0f,
                                            .roughness = 1.0f,
                                            .emissive_strength = 1.0f,
                                            .normal_scale = 1.0f,
                                            .alpha = 1.0f,
                                            .alpha_cutoff = 0.5f};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_material, base_color, NG_FIELD_COLOR, "", 0.0f, 1.0f,
             "linear; multiplies the texture"),
    NG_FIELD(struct ng_material, metallic, NG_FIELD_F32, "", 0.0f, 1.0f,
             "0 dielectric, 1 metal; multiplies the texture's B"),
    NG_FIELD(struct ng_material, roughness, NG_FIELD_F32, "", 0.0f, 1.0f,
             "perceptual roughness; multiplies the texture's G"),
    NG_FIELD(struct ng_material, emissive, NG_FIELD_COLOR, "", 0.0f, 1.0f, "linear; multiplies the texture"),
    NG_FIELD(struct ng_material, emissive_strength, NG_FIELD_F32, "W/(sr m2)", 0.0f, 1e12f,
             "radiance of emissive colour 1"),
    NG_FIELD(struct ng_material, normal_scale, NG_FIELD_F32, "", -1e3f, 1e3f,
             "multiplies x and y of the normal map"),
    NG_FIELD(struct ng_material, alpha, NG_FIELD_F32, "", 0.0f, 1.0f,
             "base colour's alpha; multiplies the texture"),
    NG_FIELD(struct ng_material, alpha_cutoff, NG_FIELD_F32, "", 0.0f, 1e3f,
             "with alpha_mask: a hole where alpha is below this"),
    NG_FIELD(struct ng_material, alpha_mask, NG_FIELD_BOOL, "", 0, 0, "false: opaque, alpha ignored"),
    NG_FIELD(struct ng_material, double_sided, NG_FIELD_BOOL, "", 0, 0,
             "seen, and emitting, from both sides"),
    NG_FIELD(struct ng_material, base_color_texture, NG_FIELD_ASSET, "", 0, 0, "sRGB image"),
    NG_FIELD(struct ng_material, metallic_roughness_texture, NG_FIELD_ASSET, "", 0, 0,
             "linear image: G roughness, B metallic"),
    NG_FIELD(struct ng_material, normal_texture, NG_FIELD_ASSET, "", 0, 0, "tangent-space normal map"),
    NG_FIELD(struct ng_material, emissive_texture, NG_FIELD_ASSET, "", 0, 0, "sRGB image"),
};

const struct ng_component_desc ng_material_component = {
    .name = "material",
    .doc = "a surface: metallic-roughness, as glTF 2.0",
    .size = sizeof(struct ng_material),
    .align = _Alignof(struct ng_material),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

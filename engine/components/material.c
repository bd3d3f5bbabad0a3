#include "components/material.h"

#define IDENTITY                                                                                             \
    {                                                                                                        \
        .scale = { 1, 1 }                                                                                    \
    }

static const struct ng_material defaults = {.base_color = {1, 1, 1},
                                            .metallic = 0.0f,
                                            .roughness = 1.0f,
                                            .emissive_strength = 1.0f,
                                            .normal_scale = 1.0f,
                                            .alpha = 1.0f,
                                            .alpha_cutoff = 0.5f,
                                            .ior = 1.5f,
                                            .specular = 1.0f,
                                            .specular_color = {1, 1, 1},
                                            .base_color_transform = IDENTITY,
                                            .metallic_roughness_transform = IDENTITY,
                                            .normal_transform = IDENTITY,
                                            .emissive_transform = IDENTITY,
                                            .specular_transform = IDENTITY,
                                            .specular_color_transform = IDENTITY};

static const char *const alpha_modes[] = {"opaque", "mask", "blend", NULL};

#define TRANSFORM_FIELD(texture_, member_, kind_, unit_, doc_)                                               \
    {                                                                                                        \
        .name = #texture_ "_texture_" #member_, .type = (kind_),                                             \
        .offset = (uint32_t)offsetof(struct ng_material, texture_##_transform.member_), .unit = (unit_),     \
        .min = -1e6f, .max = 1e6f, .doc = (doc_)                                                             \
    }
#define TRANSFORM_FIELDS(texture_)                                                                           \
    TRANSFORM_FIELD(texture_, offset, NG_FIELD_VEC2, "", "of its coordinates, in pictures"),                 \
        TRANSFORM_FIELD(texture_, rotation, NG_FIELD_F32, "rad", "of its coordinates, before the offset"),   \
        TRANSFORM_FIELD(texture_, scale, NG_FIELD_VEC2, "", "of its coordinates, before the rotation")

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
             "of a mask: a hole where alpha is below this"),
    NG_FIELD_CHOICE(struct ng_material, alpha_mode, alpha_modes,
                    "alpha is ignored, cuts holes, or is the part that is covered"),
    NG_FIELD(struct ng_material, ior, NG_FIELD_F32, "", 0.0f, 1e3f,
             "index of refraction of the dielectric part; 0: infinite"),
    NG_FIELD(struct ng_material, specular, NG_FIELD_F32, "", 0.0f, 1.0f,
             "of the dielectric part's F0; multiplies the texture's A"),
    NG_FIELD(struct ng_material, specular_color, NG_FIELD_COLOR, "", 0.0f, 1e3f,
             "linear, of the dielectric part's F0; multiplies the texture"),
    NG_FIELD(struct ng_material, double_sided, NG_FIELD_BOOL, "", 0, 0,
             "seen, and emitting, from both sides"),
    NG_FIELD(struct ng_material, unlit, NG_FIELD_BOOL, "", 0, 0,
             "shows its base colour as radiance, and has no part in light"),
    NG_FIELD(struct ng_material, base_color_texture, NG_FIELD_ASSET, "", 0, 0, "sRGB image"),
    NG_FIELD(struct ng_material, metallic_roughness_texture, NG_FIELD_ASSET, "", 0, 0,
             "linear image: G roughness, B metallic"),
    NG_FIELD(struct ng_material, normal_texture, NG_FIELD_ASSET, "", 0, 0, "tangent-space normal map"),
    NG_FIELD(struct ng_material, emissive_texture, NG_FIELD_ASSET, "", 0, 0, "sRGB image"),
    NG_FIELD(struct ng_material, specular_texture, NG_FIELD_ASSET, "", 0, 0, "image: A specular"),
    NG_FIELD(struct ng_material, specular_color_texture, NG_FIELD_ASSET, "", 0, 0, "sRGB image"),
    NG_FIELD(struct ng_material, base_color_uv_set, NG_FIELD_U32, "", 0, 1,
             "texture coordinates of the texture"),
    NG_FIELD(struct ng_material, metallic_roughness_uv_set, NG_FIELD_U32, "", 0, 1, "the same"),
    NG_FIELD(struct ng_material, normal_uv_set, NG_FIELD_U32, "", 0, 1, "the same"),
    NG_FIELD(struct ng_material, emissive_uv_set, NG_FIELD_U32, "", 0, 1, "the same"),
    NG_FIELD(struct ng_material, specular_uv_set, NG_FIELD_U32, "", 0, 1, "the same"),
    NG_FIELD(struct ng_material, specular_color_uv_set, NG_FIELD_U32, "", 0, 1, "the same"),
    TRANSFORM_FIELDS(base_color),
    TRANSFORM_FIELDS(metallic_roughness),
    TRANSFORM_FIELDS(normal),
    TRANSFORM_FIELDS(emissive),
    TRANSFORM_FIELDS(specular),
    TRANSFORM_FIELDS(specular_color),
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

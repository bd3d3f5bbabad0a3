// Materials: what glTF's metallic-roughness model has a place for stands there.
#include "asset/gltf_save_internal.h"
#include "components/components.h"
#include "components/material.h"
#include "components/name.h"

#include <cjson/cJSON.h>

#include <string.h>

// What a material without a word means.
static const struct ng_material standard = {.base_color = {1, 1, 1},
                                            .metallic = 1,
                                            .roughness = 1,
                                            .emissive_strength = 1,
                                            .normal_scale = 1,
                                            .alpha = 1,
                                            .alpha_cutoff = 0.5f};

// Where the number or the texture of a field stands; of a texture also the field of its coordinates.
struct slot {
    const char *field, *object, *key, *extension, *uv_set;
};

static const struct slot numbers[] = {
    {"metallic", "pbrMetallicRoughness", "metallicFactor", NULL, NULL},
    {"roughness", "pbrMetallicRoughness", "roughnessFactor", NULL, NULL},
    {"emissive", NULL, "emissiveFactor", NULL, NULL},
    {"emissive_strength", NULL, "emissiveStrength", "KHR_materials_emissive_strength", NULL},
    {"alpha_cutoff", NULL, "alphaCutoff", NULL, NULL},
};

static const struct slot textures[] = {
    {"base_color_texture", "pbrMetallicRoughness", "baseColorTexture", NULL, "base_color_uv_set"},
    {"metallic_roughness_texture", "pbrMetallicRoughness", "metallicRoughnessTexture", NULL,
     "metallic_roughness_uv_set"},
    {"normal_texture", NULL, "normalTexture", NULL, "normal_uv_set"},
    {"emissive_texture", NULL, "emissiveTexture", NULL, "emissive_uv_set"},
};

// One material on its way.
struct job {
    struct gltf_saver *s;
    const struct gltf_saved *place;
    cJSON *json;
    const struct ng_material *now;
    uint64_t done; // fields that stand in their place
};

static const struct ng_field *field_of(const char *name)
{
    return ng_component_field(&ng_material_component, name);
}

static bool differs(const struct job *j, const char *name)
{
    const struct ng_field *f = field_of(name);
    if (j->place->kept)
        return ng_gltf_field_changed(j->s, j->place, NG_MATERIAL, f);
    return memcmp((const char *)j->now + f->offset, (const char *)&standard + f->offset,
                  ng_field_size(f->type)) != 0;
}

static void done(struct job *j, const char *name)
{
    j->done |= ng_gltf_field_bit(j->s, NG_MATERIAL, name);
}

static cJSON *owner(const struct job *j, const struct slot *slot)
{
    if (slot->extension)
        return ng_gltf_json_extension(&j->s->w, j->json, slot->extension);
    return slot->object ? ng_gltf_json_object(&j->s->w, j->json, slot->object) : j->json;
}

static void save_numbers(struct job *j)
{
    for (size_t i = 0; i < NG_COUNT(numbers); i++) {
        const struct ng_field *f = field_of(numbers[i].field);
        if (differs(j, numbers[i].field))
            ng_gltf_json_floats(&j->s->w, owner(j, &numbers[i]), numbers[i].key,
                                (const float *)((const char *)j->now + f->offset), ng_field_floats(f->type));
        done(j, numbers[i].field);
    }
    if (differs(j, "base_color") || differs(j, "alpha")) {
        const float *c = j->now->base_color, color[4] = {c[0], c[1], c[2], j->now->alpha};
        ng_gltf_json_floats(&j->s->w, ng_gltf_json_object(&j->s->w, j->json, "pbrMetallicRoughness"),
                            "baseColorFactor", color, 4);
    }
    done(j, "base_color");
    done(j, "alpha");
}

static void save_switches(struct job *j)
{
    if (differs(j, "alpha_mask"))
        ng_gltf_json_text(&j->s->w, j->json, "alphaMode", j->now->alpha_mask ? "MASK" : "OPAQUE");
    if (differs(j, "double_sided"))
        ng_gltf_json_bool(&j->s->w, j->json, "doubleSided", j->now->double_sided);
    done(j, "alpha_mask");
    done(j, "double_sided");
}

static void save_texture(struct job *j, const struct slot *slot)
{
    ng_asset image;
    uint32_t uv_set;
    memcpy(&image, (const char *)j->now + field_of(slot->field)->offset, sizeof image);
    memcpy(&uv_set, (const char *)j->now + field_of(slot->uv_set)->offset, sizeof uv_set);
    if (differs(j, slot->field)) {
        int texture = ng_gltf_save_texture(j->s, image);
        if (texture < 0)
            ng_gltf_json_remove(owner(j, slot), slot->key);
        else
            ng_gltf_json_number(&j->s->w, ng_gltf_json_object(&j->s->w, owner(j, slot), slot->key), "index",
                                texture);
    }
    if (!image.id) // NG_scene says what the standard has no place for
        return;
    if (differs(j, slot->uv_set))
        ng_gltf_json_number(&j->s->w, ng_gltf_json_object(&j->s->w, owner(j, slot), slot->key), "texCoord",
                            uv_set);
    done(j, slot->uv_set);
}

static void save_textures(struct job *j)
{
    for (size_t i = 0; i < NG_COUNT(textures); i++)
        save_texture(j, &textures[i]);
    cJSON *normal = cJSON_GetObjectItemCaseSensitive(j->json, "normalTexture");
    if (!normal)
        return;
    if (differs(j, "normal_scale"))
        ng_gltf_json_floats(&j->s->w, normal, "scale", &j->now->normal_scale, 1);
    done(j, "normal_scale");
}

void ng_gltf_save_material(struct gltf_saver *s, const struct gltf_saved *p)
{
    struct job j = {.s = s,
                    .place = p,
                    .json = ng_gltf_saved_json(s, p),
                    .now = ng_world_get(s->world, p->entity, NG_MATERIAL)};
    ng_gltf_save_name(s, p, j.json);
    save_numbers(&j);
    save_switches(&j);
    save_textures(&j);
    ng_gltf_save_component(s, p, j.json, NG_MATERIAL, j.done);
    ng_gltf_save_others(s, p, j.json, (uint64_t)1 << NG_MATERIAL);
}

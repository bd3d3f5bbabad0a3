// Materials: what glTF's metallic-roughness model has a place for stands there.
#include "asset/gltf_save_internal.h"
#include "components/components.h"
#include "components/material.h"
#include "components/name.h"

#include <cjson/cJSON.h>

#include <stdio.h>
#include <string.h>

// Where the number or the texture of a field stands; of a texture also what the fields of its place begin
// with.
struct slot {
    const char *field, *object, *key, *extension, *name;
};

#define SPECULAR   "KHR_materials_specular"
#define GLOSSINESS "KHR_materials_pbrSpecularGlossiness"
#define UNLIT      "KHR_materials_unlit"
#define TRANSFORM  "KHR_texture_transform"

static const struct slot numbers[] = {
    {"metallic", "pbrMetallicRoughness", "metallicFactor", NULL, NULL},
    {"roughness", "pbrMetallicRoughness", "roughnessFactor", NULL, NULL},
    {"emissive", NULL, "emissiveFactor", NULL, NULL},
    {"emissive_strength", NULL, "emissiveStrength", "KHR_materials_emissive_strength", NULL},
    {"alpha_cutoff", NULL, "alphaCutoff", NULL, NULL},
    {"ior", NULL, "ior", "KHR_materials_ior", NULL},
    {"specular", NULL, "specularFactor", SPECULAR, NULL},
    {"specular_color", NULL, "specularColorFactor", SPECULAR, NULL},
};

static const struct slot textures[] = {
    {"base_color_texture", "pbrMetallicRoughness", "baseColorTexture", NULL, "base_color"},
    {"metallic_roughness_texture", "pbrMetallicRoughness", "metallicRoughnessTexture", NULL,
     "metallic_roughness"},
    {"normal_texture", NULL, "normalTexture", NULL, "normal"},
    {"emissive_texture", NULL, "emissiveTexture", NULL, "emissive"},
    {"specular_texture", NULL, "specularTexture", SPECULAR, "specular"},
    {"specular_color_texture", NULL, "specularColorTexture", SPECULAR, "specular_color"},
};

// One material on its way.
struct job {
    struct gltf_saver *s;
    const struct gltf_saved *place;
    cJSON *json;
    const struct ng_material *now;
    uint64_t done;               // fields that stand in their place
    bool anew;                   // what the file has is no longer what it was made from
    struct ng_material standard; // what a material without a word means
};

static const struct ng_field *field_of(const char *name)
{
    return ng_component_field(&ng_material_component, name);
}

static bool differs(const struct job *j, const char *name)
{
    const struct ng_field *f = field_of(name);
    if (j->place->kept && !j->anew)
        return ng_gltf_field_changed(j->s, j->place, NG_MATERIAL, f);
    return memcmp((const char *)j->now + f->offset, (const char *)&j->standard + f->offset,
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
        // One of the two may be driven by a clip, and is then what the file had.
        const struct ng_material *was =
            ng_gltf_kept_value(j->s->origin, j->s->world, j->place->kept, NG_MATERIAL);
        const float *c = was && !differs(j, "base_color") ? was->base_color : j->now->base_color;
        const float color[4] = {c[0], c[1], c[2], was && !differs(j, "alpha") ? was->alpha : j->now->alpha};
        ng_gltf_json_floats(&j->s->w, ng_gltf_json_object(&j->s->w, j->json, "pbrMetallicRoughness"),
                            "baseColorFactor", color, 4);
    }
    done(j, "base_color");
    done(j, "alpha");
}

static void save_switches(struct job *j)
{
    static const char *const modes[] = {"OPAQUE", "MASK", "BLEND"};
    if (differs(j, "alpha_mode"))
        ng_gltf_json_text(&j->s->w, j->json, "alphaMode", modes[j->now->alpha_mode]);
    if (differs(j, "double_sided"))
        ng_gltf_json_bool(&j->s->w, j->json, "doubleSided", j->now->double_sided);
    if (differs(j, "unlit") && j->now->unlit)
        ng_gltf_json_extension(&j->s->w, j->json, UNLIT);
    else if (differs(j, "unlit"))
        ng_gltf_json_remove_extension(j->json, UNLIT);
    done(j, "alpha_mode");
    done(j, "double_sided");
    done(j, "unlit");
}

// "base_color" and "texture_offset": "base_color_texture_offset".
static const char *field_name(char out[64], const struct slot *slot, const char *part)
{
    snprintf(out, 64, "%s_%s", slot->name, part);
    return out;
}

// Where on the picture: all of it, once any is different.
static void save_place(struct job *j, const struct slot *slot)
{
    static const char *const parts[] = {"texture_offset", "texture_rotation", "texture_scale"};
    static const char *const keys[] = {"offset", "rotation", "scale"};
    char name[64];
    cJSON *use = ng_gltf_json_object(&j->s->w, owner(j, slot), slot->key);
    bool moved = false;
    for (size_t i = 0; i < NG_COUNT(parts); i++)
        moved |= differs(j, field_name(name, slot, parts[i]));
    for (size_t i = 0; i < NG_COUNT(parts); i++) {
        const struct ng_field *f = field_of(field_name(name, slot, parts[i]));
        if (moved)
            ng_gltf_json_floats(&j->s->w, ng_gltf_json_extension(&j->s->w, use, TRANSFORM), keys[i],
                                (const float *)((const char *)j->now + f->offset), ng_field_floats(f->type));
        done(j, name);
    }
}

static void save_uv_set(struct job *j, const struct slot *slot)
{
    char name[64];
    uint32_t uv_set;
    field_name(name, slot, "uv_set");
    memcpy(&uv_set, (const char *)j->now + field_of(name)->offset, sizeof uv_set);
    if (differs(j, name)) {
        cJSON *use = ng_gltf_json_object(&j->s->w, owner(j, slot), slot->key);
        cJSON *extensions = cJSON_GetObjectItemCaseSensitive(use, "extensions");
        cJSON *moved = cJSON_GetObjectItemCaseSensitive(extensions, TRANSFORM);
        ng_gltf_json_number(&j->s->w, use, "texCoord", uv_set);
        if (moved) // where it would count instead
            ng_gltf_json_remove(moved, "texCoord");
    }
    done(j, name);
}

static bool is_there(const struct job *j, const struct slot *slot)
{
    const cJSON *at = j->json;
    if (slot->extension)
        at = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(at, "extensions"),
                                              slot->extension);
    else if (slot->object)
        at = cJSON_GetObjectItemCaseSensitive(at, slot->object);
    return cJSON_GetObjectItemCaseSensitive(at, slot->key) != NULL;
}

// A field whose place in the standard is gone with its texture: NG_scene says it then.
static void keep_field(struct job *j, const char *name)
{
    const struct ng_field *f = field_of(name);
    const char *now = (const char *)j->now + f->offset;
    if (!j->place->kept || memcmp(now, (const char *)&j->standard + f->offset, ng_field_size(f->type)) == 0)
        return;
    cJSON *component = ng_gltf_json_component(&j->s->w, j->json, "material");
    uint32_t whole;
    memcpy(&whole, now, sizeof whole);
    if (f->type == NG_FIELD_U32)
        ng_gltf_json_number(&j->s->w, component, name, whole);
    else
        ng_gltf_json_floats(&j->s->w, component, name, (const float *)now, ng_field_floats(f->type));
}

static void keep_place(struct job *j, const struct slot *slot)
{
    static const char *const parts[] = {"uv_set", "texture_offset", "texture_rotation", "texture_scale"};
    char name[64];
    for (size_t i = 0; i < NG_COUNT(parts); i++)
        keep_field(j, field_name(name, slot, parts[i]));
}

static void save_texture(struct job *j, const struct slot *slot)
{
    ng_asset image;
    memcpy(&image, (const char *)j->now + field_of(slot->field)->offset, sizeof image);
    if (differs(j, slot->field)) {
        int texture = ng_gltf_save_texture(j->s, image);
        if (texture < 0)
            ng_gltf_json_remove(owner(j, slot), slot->key);
        else
            ng_gltf_json_number(&j->s->w, ng_gltf_json_object(&j->s->w, owner(j, slot), slot->key), "index",
                                texture);
    }
    if (!image.id) {
        if (differs(j, slot->field))
            keep_place(j, slot);
        return;
    }
    if (!is_there(j, slot))
        return; // made from what the file has elsewhere
    save_uv_set(j, slot);
    save_place(j, slot);
}

static void save_textures(struct job *j)
{
    for (size_t i = 0; i < NG_COUNT(textures); i++)
        save_texture(j, &textures[i]);
    cJSON *normal = cJSON_GetObjectItemCaseSensitive(j->json, "normalTexture");
    if (!normal) {
        if (differs(j, "normal_texture"))
            keep_field(j, "normal_scale");
        return;
    }
    if (differs(j, "normal_scale"))
        ng_gltf_json_floats(&j->s->w, normal, "scale", &j->now->normal_scale, 1);
    done(j, "normal_scale");
}

// Of specular and glossiness we keep what was made of them, and give up the extension with the first change.
static void leave_glossiness(struct job *j)
{
    bool changed = false;
    cJSON *extensions = cJSON_GetObjectItemCaseSensitive(j->json, "extensions");
    if (!j->place->kept || !cJSON_GetObjectItemCaseSensitive(extensions, GLOSSINESS))
        return;
    for (uint32_t i = 0; i < ng_material_component.field_count; i++)
        changed |= ng_gltf_field_changed(j->s, j->place, NG_MATERIAL, &ng_material_component.fields[i]);
    if (!changed)
        return;
    j->anew = true;
    ng_gltf_json_remove_extension(j->json, GLOSSINESS);
    ng_gltf_json_remove(j->json, "pbrMetallicRoughness");
}

void ng_gltf_save_material(struct gltf_saver *s, const struct gltf_saved *p)
{
    struct job j = {.s = s,
                    .place = p,
                    .json = ng_gltf_saved_json(s, p),
                    .now = ng_world_get(s->world, p->entity, NG_MATERIAL)};
    memcpy(&j.standard, ng_material_component.defaults, sizeof j.standard);
    j.standard.metallic = 1;
    ng_gltf_save_name(s, p, j.json);
    leave_glossiness(&j);
    save_numbers(&j);
    save_switches(&j);
    save_textures(&j);
    ng_gltf_save_component(s, p, j.json, NG_MATERIAL, j.done);
    ng_gltf_save_others(s, p, j.json, (uint64_t)1 << NG_MATERIAL);
}

// Materials and images. Record 0 is the default material, then the scene's in the order of their entities; in
// the snapshot those of emitters follow. Images are listed as materials and lights ask for them.
#include "base/log.h"
#include "render/extract_internal.h"
#include "shaders/shared/scene.h"

#include <stdlib.h>
#include <string.h>

// glTF 2.0, 3.9: what a primitive without a material looks like.
static const struct ng_material default_material = {.base_color = {1, 1, 1},
                                                    .metallic = 1,
                                                    .roughness = 1,
                                                    .normal_scale = 1,
                                                    .alpha = 1,
                                                    .alpha_cutoff = 0.5f};

static int compare_records(const void *a, const void *b)
{
    uint32_t x = ng_entity_index(((const struct ng_material_record *)a)->entity);
    uint32_t y = ng_entity_index(((const struct ng_material_record *)b)->entity);
    return (x > y) - (x < y);
}

static ng_result collect_records(struct ng_extractor *x)
{
    x->records.count = 0;
    if (!ng_array_push(&x->records, (struct ng_material_record){.value = default_material}))
        return ng_out_of_memory("the frame's scene");
    ng_query_each (it, x->materials) {
        const struct ng_material *values = it.columns[0];
        for (uint32_t i = 0; i < it.count; i++)
            if (!ng_array_push(&x->records,
                               (struct ng_material_record){.entity = it.entities[i], .value = values[i]})) {
                ng_query_stop(&it);
                return ng_out_of_memory("the frame's scene");
            }
    }
    qsort(x->records.items + 1, x->records.count - 1, sizeof x->records.items[0], compare_records);
    return NG_OK;
}

// Field by field, since padding has no value; by bits, since a NaN that stays is no difference.
#define DIFFERS(field) (!ng_extract_same(&a->field, &b->field, sizeof a->field))

bool ng_extract_reflects_differently(const struct ng_material *a, const struct ng_material *b)
{
    return DIFFERS(base_color) || DIFFERS(metallic) || DIFFERS(roughness) || DIFFERS(normal_scale) ||
           DIFFERS(alpha) || DIFFERS(alpha_cutoff) || DIFFERS(alpha_mask) || DIFFERS(double_sided) ||
           DIFFERS(base_color_texture) || DIFFERS(metallic_roughness_texture) || DIFFERS(normal_texture) ||
           DIFFERS(base_color_uv_set) || DIFFERS(metallic_roughness_uv_set) || DIFFERS(normal_uv_set);
}

void ng_extract_emission(const struct ng_material *m, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m->emissive[i] * m->emissive_strength;
}

static bool emits_differently(const struct ng_material *a, const struct ng_material *b)
{
    float of_a[3], of_b[3];
    ng_extract_emission(a, of_a);
    ng_extract_emission(b, of_b);
    return !ng_extract_same(of_a, of_b, sizeof of_a) || DIFFERS(emissive_texture) || DIFFERS(emissive_uv_set);
}
#undef DIFFERS

// What a record is from now on; its revisions move on where that looks different.
static void take_value(struct ng_extractor *x, struct ng_material_record *record, struct ng_material value)
{
    ng_asset *textures[NG_MATERIAL_IMAGES] = {&value.base_color_texture, &value.metallic_roughness_texture,
                                              &value.normal_texture, &value.emissive_texture};
    uint64_t images[NG_MATERIAL_IMAGES];
    for (size_t i = 0; i < NG_MATERIAL_IMAGES; i++) {
        if (!ng_assets_image(x->assets, *textures[i]))
            *textures[i] = (ng_asset){0};
        images[i] = ng_assets_revision(x->assets, *textures[i]).content;
    }
    const size_t emitted = NG_MATERIAL_IMAGES - 1;
    bool reflects = !record->reflection || ng_extract_reflects_differently(&record->value, &value) ||
                    !ng_extract_same(record->images, images, emitted * sizeof *images);
    bool emits = !record->emission || emits_differently(&record->value, &value) ||
                 record->images[emitted] != images[emitted];
    memcpy(record->images, images, sizeof images);
    if (reflects)
        record->reflection = ++x->clock;
    if (emits)
        record->emission = ++x->clock;
    x->materials_changed |= reflects || emits;
    record->value = value;
}

static ng_result list_records(struct ng_extractor *x)
{
    NG_SWAP(x->records, x->old_records);
    NG_TRY(collect_records(x));
    for (size_t i = 0; i < x->records.count; i++) {
        struct ng_material_record *now = &x->records.items[i];
        uint32_t at = i ? ng_index_map_get(&x->material_of, now->entity.id) : 0;
        struct ng_material value = now->value;
        if (at < x->old_records.count)
            *now = x->old_records.items[at];
        take_value(x, now, value);
    }
    ng_index_map_clear(&x->material_of);
    for (size_t i = 1; i < x->records.count; i++)
        if (!ng_index_map_set(&x->material_of, x->records.items[i].entity.id, (uint32_t)i))
            return ng_out_of_memory("the frame's scene");
    return NG_OK;
}

// Reads the values of the listed materials; false if one of them is gone.
static bool reread_records(struct ng_extractor *x)
{
    for (size_t i = 1; i < x->records.count; i++) {
        struct ng_material_record *record = &x->records.items[i];
        const struct ng_material *value = ng_world_get(x->world, record->entity, NG_MATERIAL);
        if (!value)
            return false;
        take_value(x, record, *value);
    }
    return true;
}

ng_result ng_extract_read_materials(struct ng_extractor *x, bool count_changed, bool assets_changed,
                                    bool *listed)
{
    *listed = x->materials_changed = false;
    if (!count_changed && x->records.count) {
        if (!assets_changed && ng_world_component_changed_at(x->world, NG_MATERIAL) <= x->since)
            return NG_OK;
        x->image_list_dirty = true;
        if (reread_records(x))
            return NG_OK;
    }
    *listed = x->image_list_dirty = true;
    return list_records(x);
}

uint32_t ng_extract_material_index(const struct ng_extractor *x, ng_entity material)
{
    uint32_t index = ng_entity_is_null(material) ? 0 : ng_index_map_get(&x->material_of, material.id);
    return index == UINT32_MAX ? 0 : index;
}

// ---- the snapshot's arrays -------------------------------------------------------------------------------
static ng_result image_index(struct ng_extractor *x, ng_asset id, uint32_t *out)
{
    const struct ng_image *image = id.id ? ng_assets_image(x->assets, id) : NULL;
    *out = NG_NONE;
    if (!image)
        return NG_OK;
    *out = ng_index_map_get(&x->image_of, id.id);
    if (*out != UINT32_MAX)
        return NG_OK;
    *out = (uint32_t)x->images.count;
    const struct ng_snapshot_image listed = {
        .key = id.id, .revision = ng_assets_revision(x->assets, id).content, .image = image};
    bool ok = ng_array_push(&x->images, listed) && ng_array_push(&x->image_ids, id) &&
              ng_index_map_set(&x->image_of, id.id, *out);
    return ok ? NG_OK : ng_out_of_memory("the frame's scene");
}

static ng_result write_material(struct ng_extractor *x, ng_entity e, const struct ng_material *m)
{
    struct ng_snapshot_material out = {
        .entity = e,
        .metallic = m->metallic,
        .roughness = m->roughness,
        .normal_scale = m->normal_scale,
        .alpha = m->alpha,
        .alpha_cutoff = m->alpha_cutoff,
        .double_sided = m->double_sided,
        .alpha_mask = m->alpha_mask,
        .second_uvs = m->base_color_uv_set << NG_SLOT_BASE_COLOR |
                      m->metallic_roughness_uv_set << NG_SLOT_METALLIC_ROUGHNESS |
                      m->normal_uv_set << NG_SLOT_NORMAL | m->emissive_uv_set << NG_SLOT_EMISSIVE,
    };
    memcpy(out.base_color, m->base_color, sizeof out.base_color);
    ng_extract_emission(m, out.emission);
    NG_TRY(image_index(x, m->base_color_texture, &out.base_color_image));
    NG_TRY(image_index(x, m->metallic_roughness_texture, &out.metallic_roughness_image));
    NG_TRY(image_index(x, m->normal_texture, &out.normal_image));
    NG_TRY(image_index(x, m->emissive_texture, &out.emissive_image));
    return ng_array_push(&x->material_array, out) ? NG_OK : ng_out_of_memory("the frame's scene");
}

ng_result ng_extract_write_materials(struct ng_extractor *x)
{
    if (!x->image_list_dirty)
        return NG_OK;
    x->image_list_dirty = false;
    x->images.count = x->image_ids.count = x->material_array.count = 0;
    ng_index_map_clear(&x->image_of);
    for (size_t i = 0; i < x->records.count; i++)
        NG_TRY(write_material(x, x->records.items[i].entity, &x->records.items[i].value));
    for (size_t i = 0; i < x->slots.count; i++) {
        const struct ng_light_slot *slot = &x->slots.items[i];
        if (slot->emitter != NG_NONE) {
            struct ng_material shown;
            ng_extract_emitter_material(x, slot, &shown);
            NG_TRY(write_material(x, slot->entity, &shown));
        }
        struct ng_snapshot_light *light = &x->light_array.items[i];
        light->image = NG_NONE;
        if (slot->source.type->infinite)
            NG_TRY(image_index(x, slot->image, &light->image));
    }
    return NG_OK;
}

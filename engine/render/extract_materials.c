// Materials and images. Record 0 is the default material, then the scene's in the order of their entities; in
// the snapshot those of emitters follow. Images are listed as materials and lights ask for them.
#include "base/log.h"
#include "render/extract_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// glTF 2.0, 3.9: what a primitive without a material looks like.
static struct ng_material default_material(void)
{
    struct ng_material m;
    memcpy(&m, ng_material_component.defaults, sizeof m);
    m.metallic = 1;
    return m;
}

static int compare_records(const void *a, const void *b)
{
    uint32_t x = ng_entity_index(((const struct ng_material_record *)a)->entity);
    uint32_t y = ng_entity_index(((const struct ng_material_record *)b)->entity);
    return (x > y) - (x < y);
}

static ng_result collect_records(struct ng_extractor *x)
{
    x->records.count = 0;
    if (!ng_array_push(&x->records, (struct ng_material_record){.value = default_material()}))
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
    for (uint32_t i = 0; i < ng_material_component.field_count; i++) {
        const struct ng_field *f = &ng_material_component.fields[i];
        const char *of_a = (const char *)a + f->offset, *of_b = (const char *)b + f->offset;
        if (strncmp(f->name, "emissive", 8) != 0 && !ng_extract_same(of_a, of_b, ng_field_size(f->type)))
            return true;
    }
    return false;
}

bool ng_extract_lets_through(const struct ng_material *m)
{
    bool whole =
        m->alpha >= 1 && !m->base_color_texture.id; // as exporters write that blend whatever they have
    return m->alpha_mode == NG_ALPHA_MASK || (m->alpha_mode == NG_ALPHA_BLEND && !whole);
}

void ng_extract_emission(const struct ng_material *m, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m->unlit ? 0 : m->emissive[i] * m->emissive_strength;
}

void ng_extract_coordinates(const struct ng_texture_transform *t, struct ng_snapshot_texture *out)
{
    float c = cosf(t->rotation), s = sinf(t->rotation);
    const float coordinates[6] = {c * t->scale[0],  s * t->scale[1], t->offset[0],
                                  -s * t->scale[0], c * t->scale[1], t->offset[1]};
    static const struct ng_texture_transform identity = {.scale = {1, 1}};
    memcpy(out->coordinates, coordinates, sizeof coordinates);
    out->transformed = !ng_extract_same(t, &identity, sizeof identity);
}

static bool emits_differently(const struct ng_material *a, const struct ng_material *b)
{
    float of_a[3], of_b[3];
    ng_extract_emission(a, of_a);
    ng_extract_emission(b, of_b);
    return !ng_extract_same(of_a, of_b, sizeof of_a) || DIFFERS(emissive_texture) ||
           DIFFERS(emissive_uv_set) || DIFFERS(emissive_transform);
}
#undef DIFFERS

// What a record is from now on; its revisions move on where that looks different.
static void take_value(struct ng_extractor *x, struct ng_material_record *record, struct ng_material value)
{
    ng_asset *const textures[NG_TEXTURE_COUNT] = {
        &value.base_color_texture, &value.metallic_roughness_texture, &value.normal_texture,
        &value.emissive_texture,   &value.specular_texture,           &value.specular_color_texture};
    uint64_t images[NG_TEXTURE_COUNT];
    bool other_images = false;
    for (size_t i = 0; i < NG_TEXTURE_COUNT; i++) {
        if (!ng_assets_image(x->assets, *textures[i]))
            *textures[i] = (ng_asset){0};
        images[i] = ng_assets_revision(x->assets, *textures[i]).content;
        other_images |= i != NG_TEXTURE_EMISSIVE && images[i] != record->images[i];
    }
    if (!ng_extract_lets_through(&value))
        value.alpha_mode = NG_ALPHA_OPAQUE;
    bool reflects =
        !record->reflection || ng_extract_reflects_differently(&record->value, &value) || other_images;
    struct ng_material lit = value;
    lit.unlit = record->value.unlit;
    bool emitter = !record->emitter || ng_extract_reflects_differently(&record->value, &lit) || other_images;
    bool emits = !record->emission || emits_differently(&record->value, &value) ||
                 record->images[NG_TEXTURE_EMISSIVE] != images[NG_TEXTURE_EMISSIVE];
    memcpy(record->images, images, sizeof images);
    if (reflects)
        record->reflection = ++x->clock;
    if (emitter)
        record->emitter = x->clock;
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
        .specular = m->specular,
        .alpha_mode = m->alpha_mode,
        .double_sided = m->double_sided,
        .unlit = m->unlit,
    };
    // In doubles: the usual index of 1.5 gives the float that is nearest to 0.04.
    double ratio = ((double)m->ior - 1) / ((double)m->ior + 1);
    memcpy(out.base_color, m->base_color, sizeof out.base_color);
    ng_extract_emission(m, out.emission);
    for (int i = 0; i < 3; i++) {
        out.specular_color[i] = (float)(ratio * ratio) * m->specular_color[i];
        if (m->unlit)
            out.emission[i] = m->base_color[i];
    }
    for (int i = 0; i < NG_TEXTURE_COUNT; i++) {
        struct ng_material_texture_use use = ng_material_texture_of(m, (enum ng_material_texture)i);
        NG_TRY(image_index(x, use.image, &out.textures[i].image));
        out.textures[i].uv_set = use.uv_set;
        ng_extract_coordinates(&use.transform, &out.textures[i]);
    }
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

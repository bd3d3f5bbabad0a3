// Lights. The list follows the components; each light keeps its slot, and in it the importance tables, from
// frame to frame. A source is compared with last frame's byte by byte: an unchanged light keeps its version,
// and only a changed image, emission or emitter mesh prepares its tables again.
#include "base/hash.h"
#include "base/log.h"
#include "components/name.h"
#include "components/scene_scale.h"
#include "render/extract_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *ng_extract_name(const struct ng_extractor *x, ng_entity e, char buffer[NG_TEXT_SIZE])
{
    const struct ng_name *name = ng_world_get(x->world, e, NG_NAME);
    if (name && name->text[0])
        return name->text;
    snprintf(buffer, NG_TEXT_SIZE, "entity %u", ng_entity_index(e));
    return buffer;
}

// ---- listing ---------------------------------------------------------------------------------------------
static int compare_slots(const void *a, const void *b)
{
    const struct ng_light_slot *x = a, *y = b;
    uint32_t i = ng_entity_index(x->entity), k = ng_entity_index(y->entity);
    if (i != k)
        return i < k ? -1 : 1;
    return (x->source.type->component > y->source.type->component) -
           (x->source.type->component < y->source.type->component);
}

static ng_result collect_slots(struct ng_extractor *x)
{
    x->slots.count = 0;
    for (uint32_t t = 0; t < x->light_types; t++)
        ng_query_each (it, x->lights[t]) {
            for (uint32_t i = 0; i < it.count; i++) {
                struct ng_light_slot slot = {.entity = it.entities[i],
                                             .source.type = ng_light_types[t],
                                             .emitter = NG_NONE,
                                             .shape = NG_SHAPE_BUILTIN,
                                             .instance = NG_NONE};
                if (!ng_array_push(&x->slots, slot)) {
                    ng_query_stop(&it);
                    return ng_out_of_memory("the frame's scene");
                }
            }
        }
    if (x->slots.count > 1)
        qsort(x->slots.items, x->slots.count, sizeof x->slots.items[0], compare_slots);
    return NG_OK;
}

static void finish_slot(struct ng_light_slot *slot)
{
    ng_light_finish(&slot->source);
    ng_array_finish(&slot->triangles);
    ng_array_finish(&slot->uvs);
}

// Slots of lights that stay move over whole; both lists are sorted. True if the lists name the same lights.
static bool carry_slots(struct ng_extractor *x)
{
    size_t k = 0, carried = 0;
    for (size_t i = 0; i < x->slots.count; i++) {
        while (k < x->old_slots.count && compare_slots(&x->old_slots.items[k], &x->slots.items[i]) < 0)
            finish_slot(&x->old_slots.items[k++]);
        if (k == x->old_slots.count)
            break;
        if (ng_entity_same(x->old_slots.items[k].entity, x->slots.items[i].entity) &&
            x->old_slots.items[k].source.type == x->slots.items[i].source.type) {
            x->slots.items[i] = x->old_slots.items[k++];
            carried++;
        }
    }
    for (; k < x->old_slots.count; k++)
        finish_slot(&x->old_slots.items[k]);
    bool same = carried == x->slots.count && carried == x->old_slots.count;
    x->old_slots.count = 0;
    return same;
}

// Numbers emitters, and remembers which meshes are lights.
static ng_result number_emitters(struct ng_extractor *x)
{
    uint32_t emitters = 0;
    ng_index_map_clear(&x->mesh_light_of);
    for (uint32_t i = 0; i < x->slots.count; i++) {
        struct ng_light_slot *slot = &x->slots.items[i];
        if (!slot->source.type->surface)
            continue;
        struct ng_light_surface surface = {0};
        slot->source.type->surface(&slot->source, &surface);
        slot->shape = surface.shape;
        slot->emitter = emitters++;
        if (slot->source.type->emissive_mesh && !ng_index_map_set(&x->mesh_light_of, slot->entity.id, i))
            return ng_out_of_memory("the frame's scene");
    }
    return NG_OK;
}

// As many lights as before, and each of them still there: the same ones, whatever their values.
static bool same_lights(const struct ng_extractor *x)
{
    for (size_t i = 0; i < x->slots.count; i++)
        if (!ng_world_has(x->world, x->slots.items[i].entity, x->slots.items[i].source.type->component))
            return false;
    return true;
}

ng_result ng_extract_list_lights(struct ng_extractor *x, bool count_changed, bool *listed)
{
    *listed = false;
    if (!count_changed && same_lights(x))
        return NG_OK;
    NG_SWAP(x->slots, x->old_slots);
    NG_TRY(collect_slots(x));
    *listed = !carry_slots(x);
    x->image_list_dirty |= *listed;
    if (!ng_array_resize(&x->light_array, x->slots.count))
        return ng_out_of_memory("the frame's scene");
    return *listed ? number_emitters(x) : NG_OK;
}

// ---- sources ---------------------------------------------------------------------------------------------
static struct ng_light_image light_image(const struct ng_image *image)
{
    static const enum ng_light_texel formats[] = {[NG_PIXEL_RGBA8] = NG_LIGHT_TEXEL_UNORM8,
                                                  [NG_PIXEL_RGBA8_SRGB] = NG_LIGHT_TEXEL_SRGB8,
                                                  [NG_PIXEL_RGBA32F] = NG_LIGHT_TEXEL_FLOAT32};
    static const enum ng_light_wrap wraps[] = {[NG_WRAP_CLAMP] = NG_LIGHT_WRAP_CLAMP,
                                               [NG_WRAP_REPEAT] = NG_LIGHT_WRAP_REPEAT,
                                               [NG_WRAP_MIRROR] = NG_LIGHT_WRAP_MIRROR};
    if (!image)
        return (struct ng_light_image){0};
    return (struct ng_light_image){.width = image->width,
                                   .height = image->height,
                                   .format = formats[image->format],
                                   .wrap_u = wraps[image->sampling.wrap_u],
                                   .wrap_v = wraps[image->sampling.wrap_v],
                                   .nearest = image->sampling.magnify == NG_FILTER_NEAREST,
                                   .pixels = image->pixels};
}

static void to_world(const float rows[12], const float p[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = rows[i * 4] * p[0] + rows[i * 4 + 1] * p[1] + rows[i * 4 + 2] * p[2] + rows[i * 4 + 3];
}

// Adds an emitter's triangles in world space; their texture coordinates are those on the emissive texture.
// Those that are mirrored where the light is not are turned around: their second and third corners change
// places.
static ng_result add_triangles(struct ng_light_slot *slot, struct ng_snapshot_instance *instance,
                               const struct ng_snapshot_mesh *mesh)
{
    static const uint32_t turned[3] = {0, 2, 1};
    const float *uvs = slot->material.emissive_uv_set && mesh->uvs1 ? mesh->uvs1 : mesh->uvs;
    size_t first = (size_t)slot->source.triangle_count * 3, count = mesh->index_count;
    bool turn = (instance->flags & NG_INSTANCE_MIRRORED) && !slot->source.mirrored;
    struct ng_snapshot_texture texture = {0};
    ng_extract_coordinates(&slot->material.emissive_transform, &texture);
    if (first + count > UINT32_MAX || !ng_array_resize(&slot->triangles, (first + count) * 3) ||
        !ng_array_resize(&slot->uvs, (first + count) * 2))
        return ng_out_of_memory("the frame's scene");
    for (size_t i = 0; i < count; i++) {
        size_t vertex = mesh->indices[turn ? i - i % 3 + turned[i % 3] : i];
        to_world(instance->matrix, mesh->positions + vertex * 3, slot->triangles.items + (first + i) * 3);
        ng_snapshot_texture_uv(&texture, uvs + vertex * 2, slot->uvs.items + (first + i) * 2);
    }
    instance->light_triangle = slot->source.triangle_count;
    slot->source.triangle_count += mesh->index_count / 3;
    slot->source.triangles = slot->triangles.items;
    slot->source.triangle_uvs = slot->uvs.items;
    return NG_OK;
}

// What an emitter's material says; `*prepare` is set where the tables are out of date.
static void read_emission(struct ng_light_slot *slot, const struct ng_material *m, ng_asset *image,
                          bool *prepare)
{
    struct ng_light_source *s = &slot->source;
    struct ng_material seen = *m;
    if (!seen.emissive_texture.id) { // where its coordinates would lie shows in nothing
        seen.emissive_uv_set = 0;
        seen.emissive_transform = (struct ng_texture_transform){.scale = {1, 1}};
    }
    *prepare |= s->double_sided != m->double_sided;
    s->double_sided = m->double_sided;
    *image = m->emissive_texture;
    if (slot->material.emissive_uv_set != seen.emissive_uv_set ||
        !ng_extract_same(&slot->material.emissive_transform, &seen.emissive_transform,
                         sizeof seen.emissive_transform))
        slot->piece_version = slot->looked = 0; // triangles are read again
    slot->material = seen;
    slot->material.unlit = false; // what is a light has a part in light
    ng_extract_emission(&slot->material, s->emission);
}

bool ng_extract_lights_material(const struct ng_extractor *x, ng_entity light)
{
    return ng_world_has(x->world, light, NG_MATERIAL) && !ng_world_has(x->world, light, NG_MESH);
}

// All meshes of a material, in the order of their entities, that are no lights of their own.
static ng_result read_material_emitter(struct ng_extractor *x, struct ng_light_slot *slot, ng_asset *image,
                                       bool *prepare)
{
    uint32_t light = (uint32_t)(slot - x->slots.items);
    read_emission(slot, &x->records.items[ng_extract_material_index(x, slot->entity)].value, image, prepare);
    if (slot->looked == x->snapshot.geometry_version)
        return NG_OK;
    slot->looked = x->snapshot.geometry_version;
    uint64_t version = 1;
    for (uint32_t i = 0; i < x->pieces.count; i++)
        if (x->instances.items[i].light == light)
            version = ng_hash_combine(ng_hash_combine(version, x->pieces.items[i].entity.id),
                                      x->instances.items[i].version);
    if (slot->piece_version == version)
        return NG_OK;
    slot->piece_version = version;
    slot->source.triangle_count = 0;
    slot->source.mirrored = false;
    *prepare = true;
    for (uint32_t i = 0; i < x->pieces.count; i++)
        if (x->instances.items[i].light == light)
            NG_TRY(add_triangles(slot, &x->instances.items[i], ng_extract_piece_mesh(&x->pieces.items[i])));
    return NG_OK;
}

// Mesh lights: material, emission and triangles of the entity's mesh. `*prepare` is set where the tables are
// out of date.
static ng_result read_emitter(struct ng_extractor *x, struct ng_light_slot *slot, ng_asset *image,
                              bool *prepare)
{
    struct ng_light_source *s = &slot->source;
    uint32_t index = ng_index_map_get(&x->piece_of, slot->entity.id);
    if (ng_extract_lights_material(x, slot->entity))
        return read_material_emitter(x, slot, image, prepare);
    if (index == UINT32_MAX) {
        *prepare |= s->triangle_count > 0;
        s->triangle_count = 0;
        slot->piece_version = 0;
        return NG_OK;
    }
    const struct ng_piece *piece = &x->pieces.items[index];
    struct ng_snapshot_instance *instance = &x->instances.items[index];
    read_emission(slot, &x->records.items[ng_extract_material_index(x, piece->material)].value, image,
                  prepare);
    if (slot->piece_version == instance->version)
        return NG_OK;
    slot->piece_version = instance->version;
    *prepare = true;
    s->triangle_count = 0;
    s->mirrored = (instance->flags & NG_INSTANCE_MIRRORED) != 0;
    return add_triangles(slot, instance, ng_extract_piece_mesh(piece));
}

static void warn_scale(struct ng_extractor *x, const struct ng_light_slot *slot)
{
    char name[NG_TEXT_SIZE];
    float shortest = INFINITY, longest = 0;
    if (slot->shape != NG_LIGHT_SHAPE_SPHERE)
        return;
    for (int i = 0; i < 3; i++) {
        const float *axis = &slot->source.matrix[4 * i];
        float length = sqrtf(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        shortest = fminf(shortest, length);
        longest = fmaxf(longest, length);
    }
    if (longest > shortest * 1.001f && ng_extract_warn_once(x, slot->entity, NG_WARN_SPHERE))
        ng_log_warn("sphere light '%s' has a scale that is not uniform: its largest axis counts",
                    ng_extract_name(x, slot->entity, name));
}

// Texels are factors of what a material emits, so lights of other images stay out.
static void add_radiance(const struct ng_light_slot *from, const struct ng_light_slot *to, float sum[3])
{
    struct ng_light_surface surface = {0};
    if (from->image.id != to->image.id)
        return;
    from->source.type->surface(&from->source, &surface);
    for (int i = 0; i < 3; i++)
        sum[i] += surface.radiance[i];
}

void ng_extract_emitter_material(const struct ng_extractor *x, const struct ng_light_slot *slot,
                                 struct ng_material *out)
{
    *out = slot->material;
    memset(out->emissive, 0, sizeof out->emissive);
    for (uint32_t i = slot->place; i != NG_NONE; i = x->slots.items[i].next_in_place)
        add_radiance(&x->slots.items[i], slot, out->emissive);
    out->emissive_strength = 1;
}

// What can be seen of an area light follows the light.
static ng_result update_surface(struct ng_extractor *x, struct ng_light_slot *slot)
{
    const struct ng_light_type *type = slot->source.type;
    if (!type->surface)
        return NG_OK;
    x->image_list_dirty = true;
    if (slot->shape == NG_SHAPE_BUILTIN)
        return NG_OK; // its own mesh and material

    struct ng_light_surface surface = {0};
    struct ng_material before = slot->material;
    type->surface(&slot->source, &surface);
    memcpy(&slot->material, ng_material_component.defaults, sizeof slot->material);
    slot->material.emissive_texture = slot->image;
    memcpy(slot->material.base_color, surface.albedo, sizeof surface.albedo);
    struct ng_snapshot_instance *instance = &x->instances.items[slot->instance];
    float rows[12];
    ng_extract_rows(surface.matrix, rows);
    bool moved = !ng_extract_same(rows, instance->matrix, sizeof rows);
    memcpy(instance->matrix, rows, sizeof rows);
    if (!slot->version)
        memcpy(instance->previous_matrix, rows, sizeof rows); // new: it has not moved
    ng_extract_bounds(instance, &x->builtin[slot->shape]->mesh);
    ng_extract_set_mirrored(instance, surface.matrix);
    return moved || ng_extract_reflects_differently(&before, &slot->material)
               ? ng_extract_touch(x, slot->instance)
               : NG_OK;
}

// But for what a preparation follows from.
static bool same_numbers(const struct ng_light_source *a, const struct ng_light_source *b)
{
    return ng_extract_same(a->params, b->params, sizeof a->params) &&
           ng_extract_same(a->matrix, b->matrix, sizeof a->matrix) &&
           ng_extract_same(a->emission, b->emission, sizeof a->emission) &&
           ng_extract_same(a->scene_center, b->scene_center, sizeof a->scene_center) &&
           ng_extract_same(&a->scene_radius, &b->scene_radius, sizeof a->scene_radius);
}

static bool same_unit(const struct ng_light_source *a, const struct ng_light_source *b)
{
    struct ng_light_source unit_a, unit_b;
    ng_light_unit(a, &unit_a);
    ng_light_unit(b, &unit_b);
    return same_numbers(&unit_a, &unit_b);
}

// Brings a light's source up to date. `*changed` is set where anything about the light is different, `*unit`
// where that is more than its brightness.
static ng_result update_source(struct ng_extractor *x, struct ng_light_slot *slot, bool *changed, bool *unit)
{
    struct ng_light_source *s = &slot->source, before = *s;
    ng_component component = s->type->component;
    uint32_t size = ng_world_component(x->world, component)->size;
    bool prepare = slot->version == 0;
    memcpy(s->params, ng_world_get(x->world, slot->entity, component), size);
    memcpy(s->matrix, ng_extract_placement(x, slot->entity), sizeof s->matrix);
    memcpy(s->scene_center, x->snapshot.scene_center, sizeof s->scene_center);
    s->scene_radius = x->snapshot.scene_radius;

    ng_asset image = s->type->image ? s->type->image(s) : (ng_asset){0};
    if (s->type->emissive_mesh)
        NG_TRY(read_emitter(x, slot, &image, &prepare));
    const struct ng_image *texels = image.id ? ng_assets_image(x->assets, image) : NULL;
    uint64_t revision = texels ? ng_assets_revision(x->assets, image).content : 0;
    if (image.id != slot->image.id || revision != slot->image_revision) {
        slot->image = image;
        slot->image_revision = revision;
        s->image = light_image(texels);
        prepare = x->image_list_dirty = true;
    }
    if (s->type->emissive_mesh && !before.triangle_count && !s->triangle_count)
        prepare = slot->version == 0; // dark before and now, whatever its material says
    *changed = prepare || !same_numbers(&before, s);
    *unit = prepare || (*changed && !same_unit(&before, s));
    return prepare ? ng_light_prepare(s) : NG_OK;
}

static ng_result update_slot(struct ng_extractor *x, uint32_t index, bool *any_changed)
{
    struct ng_light_slot *slot = &x->slots.items[index];
    struct ng_snapshot_light *out = &x->light_array.items[index];
    char name[NG_TEXT_SIZE];
    bool changed, unit;
    NG_TRY(update_source(x, slot, &changed, &unit));
    if (changed) {
        slot->power = ng_light_power(&slot->source);
        NG_TRY(update_surface(x, slot));
        slot->version = ++x->clock;
        if (unit)
            slot->unit_version = x->clock;
        warn_scale(x, slot);
        *any_changed = true;
    }
    uint32_t image = out->image; // written with the images
    *out = (struct ng_snapshot_light){.entity = slot->entity,
                                      .source = slot->source,
                                      .image = image,
                                      .place = slot->place,
                                      .power = slot->power,
                                      .version = slot->version,
                                      .unit_version = slot->unit_version};
    snprintf(out->name, sizeof out->name, "%s", ng_extract_name(x, slot->entity, name));
    return NG_OK;
}

static void choose_environment(struct ng_extractor *x)
{
    uint32_t found = 0;
    x->snapshot.environment = NG_NONE;
    for (uint32_t i = 0; i < x->slots.count; i++) {
        const struct ng_light_slot *slot = &x->slots.items[i];
        if (!slot->source.type->infinite || slot->source.type->delta || !(slot->power > 0))
            continue;
        x->snapshot.environment = found++ ? x->snapshot.environment : i;
    }
    if (found > 1 && ng_extract_warn_once(x, (ng_entity){0}, NG_WARN_ENVIRONMENTS)) {
        char name[NG_TEXT_SIZE];
        ng_log_warn("%u environments are on: all give light, only '%s' is seen behind the scene", found,
                    ng_extract_name(x, x->slots.items[x->snapshot.environment].entity, name));
    }
}

static bool is_lamp(const struct ng_extractor *x, const struct ng_light_slot *slot,
                    const struct ng_snapshot_instance *instance)
{
    const float *albedo = slot->material.base_color;
    float d[3], radius = x->snapshot.scene_radius;
    for (int i = 0; i < 3; i++)
        d[i] = instance->bounds_max[i] - instance->bounds_min[i];
    float box = 2 * (d[0] * d[1] + d[1] * d[2] + d[2] * d[0]), sphere = 4 * NG_PI * radius * radius;
    return !(albedo[0] > 0 || albedo[1] > 0 || albedo[2] > 0) && box <= NG_LAMP_MOST_SHARE * sphere;
}

static void find_front(const struct ng_extractor *x, struct ng_snapshot_light *light)
{
    struct ng_light_surface surface;
    struct ng_light_source unit;
    struct ng_light_proxy proxy;
    light->flat = false;
    if (!light->source.type->surface)
        return;
    light->source.type->surface(&light->source, &surface);
    if (surface.shape != NG_LIGHT_SHAPE_RECTANGLE && surface.shape != NG_LIGHT_SHAPE_DISK)
        return;
    ng_light_unit(&light->source, &unit);
    ng_light_proxy_of(&unit, &proxy);
    memcpy(light->front, proxy.direction, sizeof proxy.direction);
    light->front[3] = -NG_LAMP_ROW * x->snapshot.scene_radius;
    for (int k = 0; k < 3; k++)
        light->front[3] -= proxy.direction[k] * proxy.position[k];
    light->flat = true;
}

// Last, since it follows from the scene's size as well.
static void find_lamps(struct ng_extractor *x)
{
    bool changed = false;
    for (size_t i = 0; i < x->slots.count; i++) {
        const struct ng_light_slot *slot = &x->slots.items[i];
        find_front(x, &x->light_array.items[i]);
        if (slot->instance == NG_NONE)
            continue;
        struct ng_snapshot_instance *instance = &x->instances.items[slot->instance];
        uint32_t before = instance->flags;
        instance->flags &= ~(uint32_t)NG_INSTANCE_LAMP;
        bool lamp = is_lamp(x, slot, instance);
        if (lamp)
            instance->flags |= NG_INSTANCE_LAMP;
        x->light_array.items[i].lamp = lamp;
        changed |= instance->flags != before;
        changed |= (instance->flags & (NG_INSTANCE_LAMP | NG_INSTANCE_MOVED)) == NG_INSTANCE_MOVED;
    }
    if (changed)
        x->snapshot.surface_version = ++x->clock;
}

ng_result ng_extract_update_lights(struct ng_extractor *x, bool listed)
{
    bool changed = listed;
    for (uint32_t i = 0; i < x->slots.count; i++)
        NG_TRY(update_slot(x, i, &changed));
    if (changed)
        NG_TRY(ng_extract_place_lights(x));
    choose_environment(x);
    find_lamps(x);
    return NG_OK;
}

void ng_extract_finish_lights(struct ng_extractor *x)
{
    for (size_t i = 0; i < x->slots.count; i++)
        finish_slot(&x->slots.items[i]);
    for (size_t i = 0; i < x->old_slots.count; i++)
        finish_slot(&x->old_slots.items[i]);
    ng_array_finish(&x->slots);
    ng_array_finish(&x->old_slots);
    ng_index_map_finish(&x->mesh_light_of);
    ng_index_map_finish(&x->place_of);
}

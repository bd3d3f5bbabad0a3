// Component values from JSON, by the component's own field table: the table names the fields, gives their
// types and their ranges, so there is nothing here about any single component.
#include "asset/gltf_loader_internal.h"
#include "asset/gltf_unit.h"
#include "base/log.h"
#include "components/components.h"
#include "components/name.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MAX_COMPONENT_SIZE 1024

ng_result ng_gltf_index_member(const struct gltf_loader *l, const struct gltf_value *object,
                               const char *where, const char *key, int missing, int *out)
{
    const struct gltf_value *v = ng_gltf_member(object, key);
    *out = missing;
    if (!v)
        return NG_OK;
    if (v->kind != GLTF_NUMBER || v->number < 0 || v->number > INT32_MAX || v->number != floor(v->number))
        return ng_gltf_error(l, "%s: \"%s\" is not an index", where, key);
    *out = (int)v->number;
    return NG_OK;
}

// Puts a field within its range, or to its default where that cannot be told.
static ng_result fit_field(struct gltf_loader *l, const char *where, const struct ng_component_desc *desc,
                           const struct ng_field *f, void *value)
{
    char why[NG_REASON_SIZE];
    void *field = (char *)value + f->offset;
    if (ng_field_check(f, field, why))
        return NG_OK;
    if (f->type != NG_FIELD_QUAT && ng_field_clamp(f, field))
        return ng_gltf_fault(&l->faults, "it is moved there", "%s: %s.%s: %s", where, desc->name, f->name,
                             why);
    NG_REQUIRE(desc->defaults, "%s.%s: %s, and it has no default", desc->name, f->name, why);
    memcpy(field, (const char *)desc->defaults + f->offset, ng_field_size(f->type));
    return ng_gltf_fault(&l->faults, "the default is used", "%s: %s.%s: %s", where, desc->name, f->name, why);
}

ng_result ng_gltf_add(struct gltf_loader *l, ng_entity e, const char *where, ng_component component,
                      const void *given)
{
    const struct ng_component_desc *desc = ng_world_component(l->world, component);
    _Alignas(16) char value[MAX_COMPONENT_SIZE];
    NG_REQUIRE(desc && desc->size <= sizeof value, "the world must have the engine's components");
    memcpy(value, given, desc->size);
    for (uint32_t i = 0; i < desc->field_count; i++)
        NG_TRY(fit_field(l, where, desc, &desc->fields[i], value));
    return ng_world_add(l->world, e, component, value);
}

// Copies as much of a name as fits, without cutting a UTF-8 sequence in two.
static void copy_name(char out[NG_TEXT_SIZE], const char *name)
{
    size_t n = strlen(name);
    if (n > NG_TEXT_SIZE - 1) {
        n = NG_TEXT_SIZE - 1;
        while (n > 0 && ((unsigned char)name[n] & 0xc0) == 0x80)
            n--;
    }
    memcpy(out, name, n);
    out[n] = 0;
}

ng_result ng_gltf_entity(struct gltf_loader *l, ng_entity parent, const char *name, const char *fallback,
                         uint32_t index, ng_entity *out)
{
    if (l->out.entity_count >= l->limits.max_entities) {
        ng_log_error("%s: more than the limit of %u entities", l->path, l->limits.max_entities);
        return NG_ERROR_MEMORY;
    }
    struct ng_name value = {0};
    if (name[0])
        copy_name(value.text, name);
    else
        snprintf(value.text, sizeof value.text, "%s %u", fallback, index);
    *out = ng_entity_create(l->world);
    if (ng_entity_is_null(*out))
        return NG_ERROR_MEMORY;
    l->out.entity_count++;
    if (!ng_entity_is_null(parent))
        NG_TRY(ng_world_set_parent(l->world, *out, parent, (ng_entity){0}));
    return ng_gltf_add(l, *out, fallback, NG_NAME, &value);
}

// Where a value stands, for messages: "node 3: light_spot.color".
struct place {
    const char *where;
    const struct ng_component_desc *desc;
    const struct ng_field *field;
};

static ng_result wrong(const struct gltf_loader *l, const struct place *p, const char *expected)
{
    return ng_gltf_error(l, "%s: %s.%s: expected %s", p->where, p->desc->name, p->field->name, expected);
}

static ng_result read_floats(const struct gltf_loader *l, const struct place *p, const struct gltf_value *v,
                             void *field)
{
    float out[16] = {0};
    uint32_t n = ng_field_size(p->field->type) / (uint32_t)sizeof(float);
    const struct gltf_value *items = n == 1 ? v : v->items;
    NG_REQUIRE(n <= 16, "a field has at most 16 floats");
    if (n > 1 && (v->kind != GLTF_ARRAY || v->count != n))
        return wrong(l, p, "an array of as many numbers as the field has");
    for (uint32_t i = 0; i < n; i++) {
        if (items[i].kind != GLTF_NUMBER)
            return wrong(l, p, "a number");
        if (fabs(items[i].number) > 3e38)
            return wrong(l, p, "a number of a magnitude under 3e38");
        out[i] = (float)items[i].number;
    }
    if (p->field->type == NG_FIELD_QUAT && !ng_gltf_normalize_rotation(out))
        return wrong(l, p, "a quaternion that is not zero");
    memcpy(field, out, n * sizeof *out);
    return NG_OK;
}

static ng_result read_integer(const struct gltf_loader *l, const struct place *p, const struct gltf_value *v,
                              void *out)
{
    bool is_signed = p->field->type == NG_FIELD_I32;
    double min = is_signed ? INT32_MIN : 0, max = is_signed ? INT32_MAX : UINT32_MAX;
    if (v->kind != GLTF_NUMBER || v->number < min || v->number > max || v->number != floor(v->number))
        return wrong(l, p, is_signed ? "a whole number" : "a whole number that is not negative");
    int32_t s = is_signed ? (int32_t)v->number : 0;
    uint32_t u = is_signed ? 0 : (uint32_t)v->number;
    memcpy(out, is_signed ? (const void *)&s : (const void *)&u, 4);
    return NG_OK;
}

static ng_result read_choice(const struct gltf_loader *l, const struct place *p, const struct gltf_value *v,
                             void *out)
{
    char expected[256] = "one of";
    for (uint32_t i = 0; p->field->choices && p->field->choices[i]; i++) {
        if (v->kind == GLTF_STRING && strcmp(v->string, p->field->choices[i]) == 0) {
            memcpy(out, &i, sizeof i);
            return NG_OK;
        }
        size_t n = strlen(expected);
        snprintf(expected + n, sizeof expected - n, " \"%s\"", p->field->choices[i]);
    }
    return wrong(l, p, expected);
}

static ng_result read_asset(struct gltf_loader *l, const struct place *p, ng_component component,
                            const struct gltf_value *v, void *out)
{
    // What these refer to has its place in the standard part of the file, and is not an image.
    if (component == NG_MESH || component == NG_SKIN || component == NG_ANIMATION || component == NG_MATERIAL)
        return wrong(l, p, "the standard part of the file to say this");
    if (component == NG_SUBDIVISION)
        return wrong(l, p, "the primitive's \"cage\" to say this");
    const char *const expected = "{\"texture\": index} or {\"uri\": file}";
    ng_asset asset;
    int texture;
    if (v->kind != GLTF_OBJECT || v->count != 1)
        return wrong(l, p, expected);
    const struct gltf_value *uri = ng_gltf_member(v, "uri");
    NG_TRY(ng_gltf_index_member(l, v, p->where, "texture", -1, &texture));
    if (uri && uri->kind == GLTF_STRING)
        NG_TRY(ng_gltf_picture(l, p->where, uri->string, &asset));
    else if (texture >= 0)
        NG_TRY(ng_gltf_texture(l, p->where, texture, true, &asset));
    else
        return wrong(l, p, expected);
    memcpy(out, &asset, sizeof asset);
    return NG_OK;
}

static ng_result read_entity(const struct gltf_loader *l, const struct place *p, const struct gltf_value *v,
                             void *out)
{
    const char *const expected = "{\"node\": index} of the scene or {\"material\": index}";
    int node, material;
    if (v->kind != GLTF_OBJECT || v->count != 1)
        return wrong(l, p, expected);
    NG_TRY(ng_gltf_index_member(l, v, p->where, "node", -1, &node));
    NG_TRY(ng_gltf_index_member(l, v, p->where, "material", -1, &material));
    ng_entity e = {0};
    if (node >= 0 && (uint32_t)node < l->doc->node_count)
        e = l->nodes[node];
    else if (node < 0 && material >= 0 && (uint32_t)material < l->doc->material_count)
        e = l->materials[material];
    if (ng_entity_is_null(e))
        return wrong(l, p, expected);
    memcpy(out, &e, sizeof e);
    return NG_OK;
}

static ng_result read_field(struct gltf_loader *l, const struct place *p, ng_component component,
                            const struct gltf_value *v, void *out)
{
    switch (p->field->type) {
    case NG_FIELD_BOOL:
        if (v->kind != GLTF_BOOL)
            return wrong(l, p, "true or false");
        memcpy(out, &v->boolean, sizeof(bool));
        return NG_OK;
    case NG_FIELD_I32:
    case NG_FIELD_U32:
        return read_integer(l, p, v, out);
    case NG_FIELD_ENUM:
        return read_choice(l, p, v, out);
    case NG_FIELD_TEXT:
        if (v->kind != GLTF_STRING || strlen(v->string) >= NG_TEXT_SIZE)
            return wrong(l, p, "a text of at most 63 bytes");
        memset(out, 0, NG_TEXT_SIZE);
        memcpy(out, v->string, strlen(v->string));
        return NG_OK;
    case NG_FIELD_ENTITY:
        return read_entity(l, p, v, out);
    case NG_FIELD_ASSET:
        return read_asset(l, p, component, v, out);
    default:
        return read_floats(l, p, v, out);
    }
}

static ng_result read_member(struct gltf_loader *l, const struct place *p, ng_component component,
                             const struct gltf_value *v, char *value)
{
    if (!p->field)
        return ng_gltf_error(l, "%s: NG_scene: %s has no field \"%.64s\"", p->where, p->desc->name, v->key);
    return read_field(l, p, component, v, value + p->field->offset);
}

static ng_result read_component(struct gltf_loader *l, ng_entity e, const char *where,
                                const struct gltf_value *v)
{
    ng_component id;
    if (!ng_world_find_component(l->world, v->key, &id))
        return ng_gltf_error(l, "%s: NG_scene: there is no component \"%.64s\"", where, v->key);
    const struct ng_component_desc *desc = ng_world_component(l->world, id);
    if (desc->flags & NG_COMPONENT_DERIVED)
        return ng_gltf_error(l, "%s: NG_scene: %s is computed, it cannot be given", where, desc->name);
    if (v->kind != GLTF_OBJECT)
        return ng_gltf_error(l, "%s: NG_scene: %s is not an object", where, desc->name);
    _Alignas(16) char value[MAX_COMPONENT_SIZE] = {0};
    NG_REQUIRE(desc->size <= sizeof value, "component %s has more than %d bytes", desc->name,
               MAX_COMPONENT_SIZE);
    const void *start = ng_world_get(l->world, e, id);
    if (start || desc->defaults)
        memcpy(value, start ? start : desc->defaults, desc->size);
    for (uint32_t i = 0; i < v->count; i++) {
        struct place place = {where, desc, ng_component_field(desc, v->items[i].key)};
        struct gltf_part part;
        ng_gltf_part_begin(&part, "the field stays as it was");
        ng_result r = read_member(l, &place, id, &v->items[i], value);
        NG_TRY(ng_gltf_part_end(&l->faults, &part, r));
    }
    return ng_gltf_add(l, e, where, id, value);
}

static ng_result read_components(struct gltf_loader *l, ng_entity e, const char *where,
                                 const struct gltf_value *components)
{
    if (components->kind != GLTF_OBJECT)
        return ng_gltf_fault(&l->faults, "it is ignored", "%s: NG_scene: components is not an object", where);
    for (uint32_t i = 0; i < components->count; i++) {
        struct gltf_part part;
        ng_gltf_part_begin(&part, "the component is left out");
        NG_TRY(ng_gltf_part_end(&l->faults, &part, read_component(l, e, where, &components->items[i])));
    }
    return NG_OK;
}

ng_result ng_gltf_components(struct gltf_loader *l, ng_entity e, const char *where,
                             const struct gltf_value *extension, const char *special)
{
    if (!extension)
        return NG_OK;
    for (uint32_t i = 0; i < extension->count; i++) {
        const struct gltf_value *member = &extension->items[i];
        if (special && (strcmp(member->key, special) == 0 || strcmp(member->key, "exact") == 0))
            continue;
        if (strcmp(member->key, "components") == 0)
            NG_TRY(read_components(l, e, where, member));
        else
            NG_TRY(ng_gltf_fault(&l->faults, "it is ignored", "%s: NG_scene: unknown member \"%.64s\"", where,
                                 member->key));
    }
    return NG_OK;
}

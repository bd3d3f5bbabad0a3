// Values of components into JSON, by the component's field table: the other way of gltf_extension.c.
#include "asset/gltf_save_internal.h"
#include "asset/gltf_unit.h"
#include "base/log.h"
#include "components/components.h"
#include "components/name.h"

#include <cjson/cJSON.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- JSON ------------------------------------------------------------------------------------------------

double ng_gltf_decimal(float value)
{
    char text[32];
    double decimal = (double)value;
    for (int digits = 6; digits <= 9; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, (double)value);
        decimal = strtod(text, NULL);
        if ((float)decimal == value)
            return decimal;
    }
    return (double)value;
}

void ng_gltf_json_floats(struct ng_gltf_writer *w, cJSON *object, const char *key, const float *values,
                         size_t count)
{
    double decimals[16];
    for (size_t i = 0; i < count; i++)
        decimals[i] = ng_gltf_decimal(values[i]);
    if (count == 1)
        ng_gltf_json_number(w, object, key, decimals[0]);
    else
        ng_gltf_json_numbers(w, object, key, decimals, count);
}

void ng_gltf_json_remove(cJSON *object, const char *key)
{
    cJSON_DeleteItemFromObjectCaseSensitive(object, key);
}

void ng_gltf_json_remove_extension(cJSON *object, const char *name)
{
    cJSON *extensions = cJSON_GetObjectItemCaseSensitive(object, "extensions");
    ng_gltf_json_remove(extensions, name);
    if (extensions && !extensions->child)
        ng_gltf_json_remove(object, "extensions");
}

const cJSON *ng_gltf_json_get(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

int ng_gltf_json_index(const cJSON *object, const char *key)
{
    const cJSON *value = ng_gltf_json_get(object, key);
    return cJSON_IsNumber(value) && value->valuedouble >= 0 && value->valuedouble < INT32_MAX
               ? (int)value->valuedouble
               : -1;
}

// ---- what differs ----------------------------------------------------------------------------------------

static bool same_value(const struct gltf_saver *s, const struct ng_field *f, const void *a, const void *b)
{
    if (f->type == NG_FIELD_TEXT)
        return strcmp(a, b) == 0;
    if (memcmp(a, b, ng_field_size(f->type)) != 0)
        return false;
    ng_asset asset = {0};
    if (f->type == NG_FIELD_ASSET)
        memcpy(&asset, a, sizeof asset);
    return !asset.id || ng_gltf_kept_asset(s->origin, s->assets, asset);
}

// Whether a clip that plays writes to a field: what stands there is of the moment.
static bool is_driven(const struct gltf_saver *s, ng_entity e, ng_component component,
                      const struct ng_field *f)
{
    for (size_t i = 0; i < s->driven.count; i++) {
        const struct gltf_driven *d = &s->driven.items[i];
        if (ng_entity_same(d->entity, e) && d->component == component && d->offset == f->offset)
            return true;
    }
    return false;
}

bool ng_gltf_field_changed(struct gltf_saver *s, const struct gltf_saved *p, ng_component component,
                           const struct ng_field *f)
{
    const char *now = ng_world_get(s->world, p->entity, component);
    const char *was = ng_gltf_kept_value(s->origin, s->world, p->kept, component);
    if (!now || !was)
        return now != was;
    return !same_value(s, f, now + f->offset, was + f->offset) && !is_driven(s, p->entity, component, f);
}

uint64_t ng_gltf_field_bit(const struct gltf_saver *s, ng_component component, const char *name)
{
    const struct ng_component_desc *desc = ng_world_component(s->world, component);
    return (uint64_t)1 << (ng_component_field(desc, name) - desc->fields);
}

// ---- values ----------------------------------------------------------------------------------------------

static void normalize4(float *v)
{
    (void)ng_gltf_normalize_rotation(v);
}

bool ng_gltf_before_normalizing(void (*normalize)(float *), unsigned width, const float *value, float *out)
{
    float got[8];
    for (int k = 0; k < 4096; k++) {
        int away = (k % 2 ? -1 : 1) * ((k + 1) / 2);
        double scale = 1 + away * 2.9e-8;
        for (unsigned i = 0; i < width; i++)
            out[i] = got[i] = (float)((double)value[i] * scale);
        normalize(got);
        if (memcmp(got, value, width * sizeof *value) == 0)
            return true;
    }
    memcpy(out, value, width * sizeof *value);
    return false;
}

static void set_entity(struct gltf_saver *s, cJSON *component, const struct ng_field *f, ng_entity e)
{
    const struct gltf_saved *p = ng_gltf_saved(s, e);
    ng_gltf_json_remove(component, f->name);
    if (p && (p->role == GLTF_NODE || p->role == GLTF_MATERIAL))
        ng_gltf_json_number(&s->w, ng_gltf_json_object(&s->w, component, f->name),
                            p->role == GLTF_NODE ? "node" : "material", p->index);
    else if (!ng_entity_is_null(e) && !s->warned_entity) {
        ng_log_warn("%s: a %s is neither a node nor a material; it is left out", s->path, f->name);
        s->warned_entity = true;
    }
}

static void set_field(struct gltf_saver *s, cJSON *component, const struct ng_field *f, const void *value)
{
    float floats[16];
    int32_t i;
    uint32_t u;
    ng_entity e;
    ng_asset asset;
    switch (f->type) {
    case NG_FIELD_BOOL:
        ng_gltf_json_bool(&s->w, component, f->name, *(const bool *)value);
        break;
    case NG_FIELD_I32:
        memcpy(&i, value, sizeof i);
        ng_gltf_json_number(&s->w, component, f->name, i);
        break;
    case NG_FIELD_U32:
    case NG_FIELD_ENUM:
        memcpy(&u, value, sizeof u);
        if (f->type == NG_FIELD_ENUM)
            ng_gltf_json_text(&s->w, component, f->name, f->choices[u]);
        else
            ng_gltf_json_number(&s->w, component, f->name, u);
        break;
    case NG_FIELD_TEXT:
        ng_gltf_json_text(&s->w, component, f->name, value);
        break;
    case NG_FIELD_ENTITY:
        memcpy(&e, value, sizeof e);
        set_entity(s, component, f, e);
        break;
    case NG_FIELD_ASSET:
        memcpy(&asset, value, sizeof asset);
        ng_gltf_json_remove(component, f->name);
        if (asset.id)
            ng_gltf_save_picture(s, ng_gltf_json_object(&s->w, component, f->name), asset);
        break;
    default:
        memcpy(floats, value, ng_field_size(f->type));
        if (f->type == NG_FIELD_QUAT)
            ng_gltf_before_normalizing(normalize4, 4, value, floats);
        ng_gltf_json_floats(&s->w, component, f->name, floats, ng_field_size(f->type) / sizeof(float));
    }
}

static cJSON *find_component(cJSON *json, const char *name)
{
    cJSON *scene =
        cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(json, "extensions"), "NG_scene");
    return cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(scene, "components"), name);
}

// Assets that NG_scene has no word for: the standard, or a cage, says which.
static bool is_elsewhere(ng_component component, const struct ng_field *f)
{
    return f->type == NG_FIELD_ASSET &&
           (component == NG_MESH || component == NG_SKIN || component == NG_ANIMATION ||
            component == NG_MATERIAL || component == NG_SUBDIVISION);
}

void ng_gltf_save_component(struct gltf_saver *s, const struct gltf_saved *p, cJSON *json,
                            ng_component component, uint64_t standard)
{
    const struct ng_component_desc *desc = ng_world_component(s->world, component);
    const char *now = ng_world_get(s->world, p->entity, component);
    const char *was = ng_gltf_kept_value(s->origin, s->world, p->kept, component);
    bool has = ng_world_has(s->world, p->entity, component);
    if (!has) {
        s->lost_made |= p->kept && p->kept->components >> component & 1;
        cJSON *scene = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(json, "extensions"),
                                                        "NG_scene");
        ng_gltf_json_remove(cJSON_GetObjectItemCaseSensitive(scene, "components"), desc->name);
        return;
    }
    if ((!was || s->explicit) && !standard)
        ng_gltf_json_component(&s->w, json, desc->name);
    for (uint32_t i = 0; i < desc->field_count; i++) {
        static const char zeros[64];
        const struct ng_field *f = &desc->fields[i];
        const char *start = desc->defaults ? (const char *)desc->defaults + f->offset : zeros;
        bool in_place = standard >> i & 1;
        bool differs = memcmp(now + f->offset, start, ng_field_size(f->type)) != 0;
        if (is_elsewhere(component, f))
            continue;
        bool write = was ? ng_gltf_field_changed(s, p, component, f) : in_place || differs;
        if (!write && !(s->explicit && !in_place && differs))
            continue;
        if (in_place)
            ng_gltf_json_remove(find_component(json, desc->name), f->name);
        else
            set_field(s, ng_gltf_json_component(&s->w, json, desc->name), f, now + f->offset);
    }
}

void ng_gltf_save_others(struct gltf_saver *s, const struct gltf_saved *p, cJSON *json, uint64_t but)
{
    for (ng_component c = 0; c < ng_world_component_count(s->world); c++)
        if (c != NG_NAME && !(but >> c & 1) &&
            !(ng_world_component(s->world, c)->flags & NG_COMPONENT_DERIVED))
            ng_gltf_save_component(s, p, json, c, 0);
}

void ng_gltf_save_name(struct gltf_saver *s, const struct gltf_saved *p, cJSON *json)
{
    const struct ng_name *name = ng_world_get(s->world, p->entity, NG_NAME);
    if (!name && p->kept)
        ng_gltf_json_remove(json, "name");
    else if (name && ng_gltf_field_changed(s, p, NG_NAME, &ng_name_component.fields[0]))
        ng_gltf_json_text(&s->w, json, "name", name->text);
}

// Looking into the values of a document. Of members with one name the last counts, as with most readers.
#include "asset/gltf_internal.h"

#include <math.h>
#include <string.h>

const struct gltf_value *ng_gltf_member(const struct gltf_value *object, const char *key)
{
    for (uint32_t i = object && object->kind == GLTF_OBJECT ? object->count : 0; i-- > 0;)
        if (strcmp(object->items[i].key, key) == 0)
            return &object->items[i];
    return NULL;
}

static const struct gltf_value *member_of_kind(const struct gltf_value *object, const char *key,
                                               enum gltf_kind kind)
{
    const struct gltf_value *v = ng_gltf_member(object, key);
    return v && v->kind == kind ? v : NULL;
}

double ng_gltf_number(const struct gltf_value *object, const char *key, double missing)
{
    const struct gltf_value *v = member_of_kind(object, key, GLTF_NUMBER);
    return v ? v->number : missing;
}

int ng_gltf_index(const struct gltf_value *object, const char *key, int missing)
{
    double v = ng_gltf_number(object, key, missing);
    return v == floor(v) && v >= INT32_MIN && v <= INT32_MAX ? (int)v : missing;
}

const char *ng_gltf_text(const struct gltf_value *object, const char *key, const char *missing)
{
    const struct gltf_value *v = member_of_kind(object, key, GLTF_STRING);
    return v ? v->string : missing;
}

bool ng_gltf_bool(const struct gltf_value *object, const char *key, bool missing)
{
    const struct gltf_value *v = member_of_kind(object, key, GLTF_BOOL);
    return v ? v->boolean : missing;
}

const struct gltf_value *ng_gltf_array(const struct gltf_value *object, const char *key)
{
    return member_of_kind(object, key, GLTF_ARRAY);
}

uint32_t ng_gltf_type_width(const char *type)
{
    static const struct {
        const char *name;
        uint32_t components;
    } types[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                 {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    for (size_t i = 0; i < NG_COUNT(types); i++)
        if (strcmp(type, types[i].name) == 0)
            return types[i].components;
    return 0;
}

uint32_t ng_gltf_number_count(const struct gltf_value *list)
{
    for (uint32_t i = 0; list && i < list->count; i++)
        if (list->items[i].kind != GLTF_NUMBER)
            return 0;
    return list ? list->count : 0;
}

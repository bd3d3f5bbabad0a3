// Field tables at work: sizes, names and the check that every value from outside passes through.
#include "scene/component.h"

#include "base/result.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// What a type is made of: `count` elements of one kind.
enum element { ELEMENT_BOOL, ELEMENT_I32, ELEMENT_U32, ELEMENT_F32, ELEMENT_CHAR, ELEMENT_ID };

static const struct {
    const char *name;
    enum element element;
    uint32_t count, size;
} types[] = {
    [NG_FIELD_BOOL] = {"bool", ELEMENT_BOOL, 1, sizeof(bool)},
    [NG_FIELD_I32] = {"i32", ELEMENT_I32, 1, 4},
    [NG_FIELD_U32] = {"u32", ELEMENT_U32, 1, 4},
    [NG_FIELD_ENUM] = {"enum", ELEMENT_U32, 1, 4},
    [NG_FIELD_F32] = {"f32", ELEMENT_F32, 1, 4},
    [NG_FIELD_VEC2] = {"vec2", ELEMENT_F32, 2, 8},
    [NG_FIELD_VEC3] = {"vec3", ELEMENT_F32, 3, 12},
    [NG_FIELD_VEC4] = {"vec4", ELEMENT_F32, 4, 16},
    [NG_FIELD_QUAT] = {"quat", ELEMENT_F32, 4, 16},
    [NG_FIELD_COLOR] = {"color", ELEMENT_F32, 3, 12},
    [NG_FIELD_MAT4] = {"mat4", ELEMENT_F32, 16, 64},
    [NG_FIELD_TEXT] = {"text", ELEMENT_CHAR, NG_TEXT_SIZE, NG_TEXT_SIZE},
    [NG_FIELD_ENTITY] = {"entity", ELEMENT_ID, 1, sizeof(ng_entity)},
    [NG_FIELD_ASSET] = {"asset", ELEMENT_ID, 1, sizeof(ng_asset)},
};

uint32_t ng_field_size(enum ng_field_type type)
{
    assert((size_t)type < NG_COUNT(types));
    return types[type].size;
}

uint32_t ng_field_floats(enum ng_field_type type)
{
    assert((size_t)type < NG_COUNT(types));
    return types[type].element == ELEMENT_F32 && type != NG_FIELD_MAT4 ? types[type].count : 0;
}

const char *ng_field_type_name(enum ng_field_type type)
{
    assert((size_t)type < NG_COUNT(types));
    return types[type].name;
}

const struct ng_field *ng_component_field(const struct ng_component_desc *desc, const char *name)
{
    for (uint32_t i = 0; i < desc->field_count; i++)
        if (strcmp(desc->fields[i].name, name) == 0)
            return &desc->fields[i];
    return NULL;
}

// Element i as a number, whatever its type; doubles hold all of 32-bit integers.
static double element_number(enum element element, const void *value, uint32_t i)
{
    float f;
    int32_t s;
    uint32_t u;
    unsigned char b;
    switch (element) {
    case ELEMENT_F32:
        memcpy(&f, (const char *)value + i * sizeof f, sizeof f);
        return (double)f;
    case ELEMENT_I32:
        memcpy(&s, value, sizeof s);
        return s;
    case ELEMENT_U32:
        memcpy(&u, value, sizeof u);
        return u;
    default: // a bool, read as a byte: any other value than 0 and 1 would be undefined
        memcpy(&b, value, sizeof b);
        return b;
    }
}

static void range(const struct ng_field *field, double *min, double *max)
{
    *min = -INFINITY, *max = INFINITY;
    if (field->type == NG_FIELD_BOOL) {
        *min = 0, *max = 1;
    } else if (field->type == NG_FIELD_ENUM) {
        *min = 0, *max = -1;
        while (field->choices && field->choices[(int)*max + 1])
            *max += 1;
    } else if (field->min != 0 || field->max != 0) {
        *min = (double)field->min, *max = (double)field->max;
    }
}

bool ng_field_check(const struct ng_field *field, const void *value, char reason[NG_REASON_SIZE])
{
    char unused[NG_REASON_SIZE];
    char *why = reason ? reason : unused;
    enum element element = types[field->type].element;
    if (element == ELEMENT_ID)
        return true;
    if (element == ELEMENT_CHAR) {
        snprintf(why, NG_REASON_SIZE, "the text is longer than %d bytes", NG_TEXT_SIZE - 1);
        return memchr(value, 0, NG_TEXT_SIZE) != NULL;
    }
    double min, max, squares = 0;
    range(field, &min, &max);
    for (uint32_t i = 0; i < types[field->type].count; i++) {
        double x = element_number(element, value, i);
        squares += x * x;
        if (!isfinite(x)) {
            snprintf(why, NG_REASON_SIZE, "%g is not a finite number", x);
            return false;
        }
        if (x < min || x > max) {
            snprintf(why, NG_REASON_SIZE, "%g is outside %g to %g", x, min, max);
            return false;
        }
    }
    if (field->type == NG_FIELD_QUAT && fabs(squares - 1) > 2e-3) {
        snprintf(why, NG_REASON_SIZE, "the quaternion's length is %g, not 1", sqrt(squares));
        return false;
    }
    return true;
}

bool ng_field_clamp(const struct ng_field *field, float *value)
{
    double min, max;
    if (types[field->type].element != ELEMENT_F32)
        return false;
    range(field, &min, &max);
    float low = (float)fmax(min, -(double)FLT_MAX), high = (float)fmin(max, (double)FLT_MAX);
    for (uint32_t i = 0; i < types[field->type].count; i++) {
        if (isnan(value[i]))
            return false;
        value[i] = fminf(fmaxf(value[i], low), high);
    }
    return true;
}

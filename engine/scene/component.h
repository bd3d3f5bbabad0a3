// The description of a component: its name, size, defaults and a table of its fields.
//
// This one table drives scene files, the inspector, undo, animation of any field, variations and
// `lightformer info components`. There is no second description of a component anywhere.
#ifndef NG_SCENE_COMPONENT_H
#define NG_SCENE_COMPONENT_H

#include "base/extern_c.h"
#include "scene/entity.h"

#include <stddef.h>

NG_EXTERN_C_BEGIN

enum ng_field_type {
    NG_FIELD_BOOL,   // bool
    NG_FIELD_I32,    // int32_t
    NG_FIELD_U32,    // uint32_t
    NG_FIELD_ENUM,   // uint32_t, an index into `choices`
    NG_FIELD_F32,    // float
    NG_FIELD_VEC2,   // float[2]
    NG_FIELD_VEC3,   // float[3]
    NG_FIELD_VEC4,   // float[4]
    NG_FIELD_QUAT,   // float[4], x y z w, unit length
    NG_FIELD_COLOR,  // float[3], linear Rec. 709
    NG_FIELD_MAT4,   // float[16], column-major
    NG_FIELD_TEXT,   // char[64], zero-terminated UTF-8
    NG_FIELD_ENTITY, // ng_entity
    NG_FIELD_ASSET,  // ng_asset
};

#define NG_TEXT_SIZE   64
#define NG_REASON_SIZE 96

struct ng_field {
    const char *name;
    enum ng_field_type type;
    uint32_t offset;
    const char *unit;           // SI symbol, "" if none
    float min, max;             // both 0: unbounded; values outside are refused when loaded or edited
    const char *const *choices; // NG_FIELD_ENUM: names, null-terminated
    const char *doc;            // one line
};

enum {
    NG_COMPONENT_DERIVED = 1, // computed from others every frame: not saved, not part of undo
};

struct ng_component_desc {
    const char *name;     // lower_snake_case, unique in a world
    const char *doc;      // one line
    uint32_t size, align; // 0 bytes is a tag
    const void *defaults; // `size` bytes; null: zeros
    const struct ng_field *fields;
    uint32_t field_count;
    uint32_t flags;
};

// A component's id within a world: the order of registration. Engine components have fixed ids
// (components/components.h).
typedef uint32_t ng_component;

// One line of a field table:
//     NG_FIELD(struct ng_camera, fov_y, NG_FIELD_F32, "rad", 0.01f, 3.1f, "vertical field of view"),
#define NG_FIELD(type_, member_, kind_, unit_, min_, max_, doc_)                                             \
    {                                                                                                        \
        .name = #member_, .type = (kind_), .offset = (uint32_t)offsetof(type_, member_), .unit = (unit_),    \
        .min = (min_), .max = (max_), .doc = (doc_)                                                          \
    }

// The same for an NG_FIELD_ENUM; `choices_` ends with null.
#define NG_FIELD_CHOICE(type_, member_, choices_, doc_)                                                      \
    {                                                                                                        \
        .name = #member_, .type = NG_FIELD_ENUM, .offset = (uint32_t)offsetof(type_, member_), .unit = "",   \
        .choices = (choices_), .doc = (doc_)                                                                 \
    }

// Bytes of one field of this type.
uint32_t ng_field_size(enum ng_field_type type);
// How many floats a number, vector, quaternion or colour has, 4 at most; 0 for all else, matrices too.
uint32_t ng_field_floats(enum ng_field_type type);
// "f32", "vec3", ...: the type as people read it.
const char *ng_field_type_name(enum ng_field_type type);
// Null if no field has this name.
const struct ng_field *ng_component_field(const struct ng_component_desc *desc, const char *name);
// Whether a value may be stored in a field. If not, `reason` (may be null) gets a phrase such as
// "4.2 is outside 0.01 to 3.1". Finite numbers within min and max, an existing choice, text that ends, a bool
// that is 0 or 1, a quaternion of unit length (to 1e-3).
bool ng_field_check(const struct ng_field *field, const void *value, char reason[NG_REASON_SIZE]);
// Moves floats that are out of a field's range to its ends, for values that were computed. False, and nothing
// may be stored, where one is no number, or the field is not of floats.
bool ng_field_clamp(const struct ng_field *field, float *value);

NG_EXTERN_C_END

#endif

#include "components/transform.h"

static const struct ng_transform defaults = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_transform, translation, NG_FIELD_VEC3, "m", -NG_TRANSFORM_MAX, NG_TRANSFORM_MAX,
             "applied last"),
    NG_FIELD(struct ng_transform, rotation, NG_FIELD_QUAT, "", 0, 0, "unit quaternion x y z w"),
    NG_FIELD(struct ng_transform, scale, NG_FIELD_VEC3, "", -NG_TRANSFORM_MAX, NG_TRANSFORM_MAX,
             "applied first; negative mirrors"),
};

const struct ng_component_desc ng_transform_component = {
    .name = "transform",
    .doc = "where an entity is, relative to its parent",
    .size = sizeof(struct ng_transform),
    .align = _Alignof(struct ng_transform),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

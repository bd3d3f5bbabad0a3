#include "components/scene_scale.h"

static const struct ng_scene_scale defaults = {.radius = 1.0f};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_scene_scale, center, NG_FIELD_VEC3, "m", -1e9f, 1e9f, "centre of the sphere"),
    NG_FIELD(struct ng_scene_scale, radius, NG_FIELD_F32, "m", 1e-6f, 1e9f, "radius of the sphere"),
};

const struct ng_component_desc ng_scene_scale_component = {
    .name = "scene_scale",
    .doc = "the scene's bounding sphere when it was made; one entity has it",
    .size = sizeof(struct ng_scene_scale),
    .align = _Alignof(struct ng_scene_scale),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

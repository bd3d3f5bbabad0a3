#include "components/placement.h"

static const struct ng_placement defaults = {.matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_placement, matrix, NG_FIELD_MAT4, "", 0, 0, "local to world, column-major"),
};

const struct ng_component_desc ng_placement_component = {
    .name = "placement",
    .doc = "where an entity is in the world, from its transform and its ancestors'",
    .size = sizeof(struct ng_placement),
    .align = _Alignof(struct ng_placement),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
    .flags = NG_COMPONENT_DERIVED,
};

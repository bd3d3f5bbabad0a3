#include "components/subdivision.h"

static const struct ng_subdivision defaults = {.level = 2, .boundary = NG_BOUNDARY_EDGE_AND_CORNER};

static const char *const boundaries[] = {"edge_only", "edge_and_corner", NULL};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_subdivision, level, NG_FIELD_U32, "", 0.0f, 6.0f, "each level quadruples the faces"),
    NG_FIELD_CHOICE(struct ng_subdivision, boundary, boundaries, "how open edges and their corners are kept"),
    NG_FIELD(struct ng_subdivision, cage, NG_FIELD_ASSET, "", 0, 0,
             "control mesh; none: the mesh's triangles"),
};

const struct ng_component_desc ng_subdivision_component = {
    .name = "subdivision",
    .doc = "makes the mesh a Catmull-Clark surface",
    .size = sizeof(struct ng_subdivision),
    .align = _Alignof(struct ng_subdivision),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

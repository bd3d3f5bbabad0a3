#include "components/mesh.h"

static const struct ng_mesh defaults = {.visible = true};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_mesh, geometry, NG_FIELD_ASSET, "", 0, 0, "the geometry"),
    NG_FIELD(struct ng_mesh, material, NG_FIELD_ENTITY, "", 0, 0,
             "an entity with a material; none: the default material"),
    NG_FIELD(struct ng_mesh, visible, NG_FIELD_BOOL, "", 0, 0, "false: neither seen nor casting shadows"),
};

const struct ng_component_desc ng_mesh_component = {
    .name = "mesh",
    .doc = "geometry with one material",
    .size = sizeof(struct ng_mesh),
    .align = _Alignof(struct ng_mesh),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

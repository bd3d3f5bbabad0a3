#include "components/light_mesh.h"

static const struct ng_light_mesh defaults = {.on = true, .color = {1, 1, 1}, .scale = 1.0f};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_light_mesh, on, NG_FIELD_BOOL, "", 0, 0, "whether it shines"),
    NG_FIELD(struct ng_light_mesh, color, NG_FIELD_COLOR, "", 0.0f, 1e9f,
             "linear colour, multiplies the material's emission"),
    NG_FIELD(struct ng_light_mesh, scale, NG_FIELD_F32, "", 0.0f, 1e12f,
             "multiplies the material's emission"),
};

const struct ng_component_desc ng_light_mesh_component = {
    .name = "light_mesh",
    .doc = "makes the emissive mesh of its entity a light, or all meshes of a material one light",
    .size = sizeof(struct ng_light_mesh),
    .align = _Alignof(struct ng_light_mesh),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

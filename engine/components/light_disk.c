#include "components/light_disk.h"

static const struct ng_light_disk defaults = {
    .on = true, .color = {1, 1, 1}, .radiance = 1.0f, .radius = 0.5f};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_light_disk, on, NG_FIELD_BOOL, "", 0, 0, "whether it shines"),
    NG_FIELD(struct ng_light_disk, color, NG_FIELD_COLOR, "", 0.0f, 1e9f,
             "linear colour, multiplies the strength"),
    NG_FIELD(struct ng_light_disk, radiance, NG_FIELD_F32, "W/(sr m2)", 0.0f, 1e12f,
             "radiance, times colour"),
    NG_FIELD(struct ng_light_disk, radius, NG_FIELD_F32, "m", 1e-6f, 1e6f, "before the placement's scale"),
    NG_FIELD(struct ng_light_disk, albedo, NG_FIELD_COLOR, "", 0.0f, 1.0f,
             "linear diffuse albedo of the emitter itself"),
};

const struct ng_component_desc ng_light_disk_component = {
    .name = "light_disk",
    .doc = "a disk in XY that emits along -Z",
    .size = sizeof(struct ng_light_disk),
    .align = _Alignof(struct ng_light_disk),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

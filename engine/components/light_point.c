#include "components/light_point.h"

static const struct ng_light_point defaults = {.on = true, .color = {1, 1, 1}, .intensity = 1.0f};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_light_point, on, NG_FIELD_BOOL, "", 0, 0, "whether it shines"),
    NG_FIELD(struct ng_light_point, color, NG_FIELD_COLOR, "", 0.0f, 1e9f,
             "linear colour, multiplies the strength"),
    NG_FIELD(struct ng_light_point, intensity, NG_FIELD_F32, "W/sr", 0.0f, 1e12f, "intensity, times colour"),
};

const struct ng_component_desc ng_light_point_component = {
    .name = "light_point",
    .doc = "light from a point, the same in all directions",
    .size = sizeof(struct ng_light_point),
    .align = _Alignof(struct ng_light_point),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

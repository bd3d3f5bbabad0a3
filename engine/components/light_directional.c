#include "components/light_directional.h"

static const struct ng_light_directional defaults = {.on = true, .color = {1, 1, 1}, .irradiance = 1.0f};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_light_directional, on, NG_FIELD_BOOL, "", 0, 0, "whether it shines"),
    NG_FIELD(struct ng_light_directional, color, NG_FIELD_COLOR, "", 0.0f, 1e9f,
             "linear colour, multiplies the strength"),
    NG_FIELD(struct ng_light_directional, irradiance, NG_FIELD_F32, "W/m2", 0.0f, 1e12f,
             "on a surface that faces it, times colour"),
};

const struct ng_component_desc ng_light_directional_component = {
    .name = "light_directional",
    .doc = "light from infinitely far, along -Z",
    .size = sizeof(struct ng_light_directional),
    .align = _Alignof(struct ng_light_directional),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

#include "components/light_environment.h"

static const struct ng_light_environment defaults = {.on = true, .color = {1, 1, 1}, .intensity = 1.0f};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_light_environment, on, NG_FIELD_BOOL, "", 0, 0, "whether it shines"),
    NG_FIELD(struct ng_light_environment, color, NG_FIELD_COLOR, "", 0.0f, 1e9f,
             "linear colour, multiplies the strength"),
    NG_FIELD(struct ng_light_environment, intensity, NG_FIELD_F32, "W/(sr m2)", 0.0f, 1e12f,
             "multiplies the map; without a map the radiance, times colour"),
    NG_FIELD(struct ng_light_environment, map, NG_FIELD_ASSET, "", 0, 0,
             "latitude-longitude image; none: the colour everywhere"),
};

const struct ng_component_desc ng_light_environment_component = {
    .name = "light_environment",
    .doc = "light from all around: a latitude-longitude map",
    .size = sizeof(struct ng_light_environment),
    .align = _Alignof(struct ng_light_environment),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

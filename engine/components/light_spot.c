#include "components/light_spot.h"

static const struct ng_light_spot defaults = {
    .on = true, .color = {1, 1, 1}, .intensity = 1.0f, .outer_angle = 0.785398163f};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_light_spot, on, NG_FIELD_BOOL, "", 0, 0, "whether it shines"),
    NG_FIELD(struct ng_light_spot, color, NG_FIELD_COLOR, "", 0.0f, 1e9f,
             "linear colour, multiplies the strength"),
    NG_FIELD(struct ng_light_spot, intensity, NG_FIELD_F32, "W/sr", 0.0f, 1e12f, "on the axis, times colour"),
    NG_FIELD(struct ng_light_spot, inner_angle, NG_FIELD_F32, "rad", 0.0f, 1.5707964f,
             "half angle of full intensity"),
    NG_FIELD(struct ng_light_spot, outer_angle, NG_FIELD_F32, "rad", 1e-4f, 1.5707964f,
             "half angle of the cone: nothing outside"),
};

const struct ng_component_desc ng_light_spot_component = {
    .name = "light_spot",
    .doc = "light from a point into a cone along -Z",
    .size = sizeof(struct ng_light_spot),
    .align = _Alignof(struct ng_light_spot),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

#include "components/light_rectangle.h"

static const struct ng_light_rectangle defaults = {
    .on = true, .color = {1, 1, 1}, .radiance = 1.0f, .size = {1, 1}};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_light_rectangle, on, NG_FIELD_BOOL, "", 0, 0, "whether it shines"),
    NG_FIELD(struct ng_light_rectangle, color, NG_FIELD_COLOR, "", 0.0f, 1e9f,
             "linear colour, multiplies the strength"),
    NG_FIELD(struct ng_light_rectangle, radiance, NG_FIELD_F32, "W/(sr m2)", 0.0f, 1e12f,
             "radiance, times colour"),
    NG_FIELD(struct ng_light_rectangle, size, NG_FIELD_VEC2, "m", 1e-6f, 1e6f,
             "full width and height, before the placement's scale"),
    NG_FIELD(struct ng_light_rectangle, texture, NG_FIELD_ASSET, "", 0, 0,
             "image that multiplies the radiance; none: white"),
    NG_FIELD(struct ng_light_rectangle, albedo, NG_FIELD_COLOR, "", 0.0f, 1.0f,
             "linear diffuse albedo of the emitter itself"),
};

const struct ng_component_desc ng_light_rectangle_component = {
    .name = "light_rectangle",
    .doc = "a rectangle in XY that emits along -Z",
    .size = sizeof(struct ng_light_rectangle),
    .align = _Alignof(struct ng_light_rectangle),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

#include "components/animation.h"

static const struct ng_animation defaults = {.weight = 1.0f, .speed = 1.0f, .loop = true, .playing = true};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_animation, clip, NG_FIELD_ASSET, "", 0, 0, "the clip"),
    NG_FIELD(struct ng_animation, weight, NG_FIELD_F32, "", 0.0f, 1e6f,
             "share among the clips that drive the same field; 0: off"),
    NG_FIELD(struct ng_animation, speed, NG_FIELD_F32, "", -1e6f, 1e6f,
             "clip seconds a scene second; negative: backwards"),
    NG_FIELD(struct ng_animation, offset, NG_FIELD_F32, "s", -1e6f, 1e6f, "clip time at scene time 0"),
    NG_FIELD(struct ng_animation, loop, NG_FIELD_BOOL, "", 0, 0,
             "wraps at the ends instead of stopping there"),
    NG_FIELD(struct ng_animation, playing, NG_FIELD_BOOL, "", 0, 0, "false: as if the weight were 0"),
};

const struct ng_component_desc ng_animation_component = {
    .name = "animation",
    .doc = "a clip that plays",
    .size = sizeof(struct ng_animation),
    .align = _Alignof(struct ng_animation),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

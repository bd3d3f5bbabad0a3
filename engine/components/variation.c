#include "components/variation.h"

static const char *const kinds[] = {"range",   "log_range", "offset", "turn",
                                    "choices", "time",      "camera", NULL};

static const struct ng_variation defaults = {0};

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_variation, field, NG_FIELD_TEXT, "", 0, 0,
             "path of what varies: \"light_rectangle.radiance\""),
    NG_FIELD(struct ng_variation, target, NG_FIELD_ENTITY, "", 0, 0, "whose field varies"),
    NG_FIELD_CHOICE(struct ng_variation, kind, kinds, "how values are drawn"),
    NG_FIELD(struct ng_variation, choice_count, NG_FIELD_U32, "", 0, NG_VARIATION_CHOICE_MAX,
             "choices: how many there are"),
    NG_FIELD(struct ng_variation, min, NG_FIELD_VEC4, "", 0, 0, "lower end, a channel each"),
    NG_FIELD(struct ng_variation, max, NG_FIELD_VEC4, "", 0, 0, "upper end, a channel each"),
    NG_FIELD(struct ng_variation, look_min, NG_FIELD_VEC3, "m", 0, 0,
             "camera: box of points to look at, lower corner"),
    NG_FIELD(struct ng_variation, look_max, NG_FIELD_VEC3, "m", 0, 0,
             "camera: box of points to look at, upper corner"),
    NG_FIELD(struct ng_variation, choice_0, NG_FIELD_VEC4, "", 0, 0, "first choice"),
    NG_FIELD(struct ng_variation, choice_1, NG_FIELD_VEC4, "", 0, 0, "second choice"),
    NG_FIELD(struct ng_variation, choice_2, NG_FIELD_VEC4, "", 0, 0, "third choice"),
    NG_FIELD(struct ng_variation, choice_3, NG_FIELD_VEC4, "", 0, 0, "fourth choice"),
    NG_FIELD(struct ng_variation, choice_4, NG_FIELD_VEC4, "", 0, 0, "fifth choice"),
    NG_FIELD(struct ng_variation, choice_5, NG_FIELD_VEC4, "", 0, 0, "sixth choice"),
};

const struct ng_component_desc ng_variation_component = {
    .name = "variation",
    .doc = "what may vary between the samples of a data set",
    .size = sizeof(struct ng_variation),
    .align = _Alignof(struct ng_variation),
    .defaults = &defaults,
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

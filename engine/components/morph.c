#include "components/morph.h"

// Four weights a field, which is what a channel of a clip can drive.
#define WEIGHTS(first)                                                                                       \
    {                                                                                                        \
        .name = "weights_" #first, .type = NG_FIELD_VEC4,                                                    \
        .offset = (uint32_t)(offsetof(struct ng_morph, weights) + (first) * sizeof(float)), .unit = "",      \
        .min = -1e6f, .max = 1e6f, .doc = "of morph target " #first " and the three after it"                \
    }

static const struct ng_field fields[] = {
    WEIGHTS(0),   WEIGHTS(4),   WEIGHTS(8),   WEIGHTS(12),  WEIGHTS(16),  WEIGHTS(20),  WEIGHTS(24),
    WEIGHTS(28),  WEIGHTS(32),  WEIGHTS(36),  WEIGHTS(40),  WEIGHTS(44),  WEIGHTS(48),  WEIGHTS(52),
    WEIGHTS(56),  WEIGHTS(60),  WEIGHTS(64),  WEIGHTS(68),  WEIGHTS(72),  WEIGHTS(76),  WEIGHTS(80),
    WEIGHTS(84),  WEIGHTS(88),  WEIGHTS(92),  WEIGHTS(96),  WEIGHTS(100), WEIGHTS(104), WEIGHTS(108),
    WEIGHTS(112), WEIGHTS(116), WEIGHTS(120), WEIGHTS(124),
};
_Static_assert(sizeof fields / sizeof fields[0] * 4 == NG_MORPH_TARGETS, "a field for each four targets");

const struct ng_component_desc ng_morph_component = {
    .name = "morph",
    .doc = "how much of each morph target of its geometry a mesh shows",
    .size = sizeof(struct ng_morph),
    .align = _Alignof(struct ng_morph),
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

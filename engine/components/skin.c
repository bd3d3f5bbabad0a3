#include "components/skin.h"

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_skin, skin, NG_FIELD_ASSET, "", 0, 0, "joints and inverse bind matrices"),
};

const struct ng_component_desc ng_skin_component = {
    .name = "skin",
    .doc = "makes the mesh follow joints",
    .size = sizeof(struct ng_skin),
    .align = _Alignof(struct ng_skin),
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

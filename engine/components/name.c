#include "components/name.h"

static const struct ng_field fields[] = {
    NG_FIELD(struct ng_name, text, NG_FIELD_TEXT, "", 0, 0, "UTF-8, at most 63 bytes"),
};

const struct ng_component_desc ng_name_component = {
    .name = "name",
    .doc = "what an entity is called; need not be unique",
    .size = sizeof(struct ng_name),
    .align = _Alignof(struct ng_name),
    .fields = fields,
    .field_count = sizeof fields / sizeof fields[0],
};

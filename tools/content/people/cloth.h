// Small normal maps that tile: cloth, leather, hair.
#ifndef CONTENT_PEOPLE_CLOTH_H
#define CONTENT_PEOPLE_CLOTH_H

#include "../image.h"

NG_NODISCARD ng_result cloth_weave(struct bytes *out);   // plain weave
NG_NODISCARD ng_result cloth_denim(struct bytes *out);   // twill
NG_NODISCARD ng_result cloth_leather(struct bytes *out); // grain
NG_NODISCARD ng_result cloth_strands(struct bytes *out); // along v

#endif

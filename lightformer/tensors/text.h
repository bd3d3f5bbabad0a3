// Text that grows, for headers and manifests. Zero is empty; out of memory is remembered, not told.
#ifndef LF_TENSORS_TEXT_H
#define LF_TENSORS_TEXT_H

#include "base/array.h"
#include "base/extern_c.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct lf_text {
    NG_ARRAY(char) bytes; // without a zero at the end
    bool failed;
};

void lf_text_put(struct lf_text *t, const char *s);
// As a JSON string, with quotes; control characters become spaces.
void lf_text_quote(struct lf_text *t, const char *s);

NG_EXTERN_C_END

#endif

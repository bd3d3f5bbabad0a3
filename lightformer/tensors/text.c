#include "lightformer/tensors/text.h"

#include <string.h>

void lf_text_put(struct lf_text *t, const char *s)
{
    size_t n = strlen(s), at = t->bytes.count;
    if (t->failed || !ng_array_resize(&t->bytes, at + n))
        t->failed = true;
    else
        memcpy(t->bytes.items + at, s, n);
}

void lf_text_quote(struct lf_text *t, const char *s)
{
    char c[3] = {0};
    lf_text_put(t, "\"");
    for (; *s; s++) {
        bool escape = *s == '"' || *s == '\\';
        c[0] = escape ? '\\' : (unsigned char)*s < 0x20 ? ' ' : *s;
        c[1] = escape ? *s : 0;
        lf_text_put(t, c);
    }
    lf_text_put(t, "\"");
}

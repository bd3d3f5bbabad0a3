#include "lightformer/net/memory.h"

#include "base/log.h"

#include <stdlib.h>

void lf_memory_lend(struct lf_memory *m, void *data, uint64_t size)
{
    if (!m->lent)
        lf_memory_finish(m);
    if (m->base != data)
        m->used = 0;
    m->base = data;
    m->size = size;
    m->lent = true;
}

ng_result lf_memory_begin(struct lf_memory *m, uint64_t bytes, const char *what)
{
    m->used = 0;
    if (bytes <= m->size && m->base)
        return NG_OK;
    NG_REQUIRE(!m->lent, "%s: a buffer of %llu bytes was lent for %llu", what, (unsigned long long)m->size,
               (unsigned long long)bytes);
    lf_memory_finish(m);
    m->size = lf_memory_part(bytes ? bytes : 1);
    m->base = aligned_alloc(LF_MEMORY_ALIGNMENT, m->size);
    if (m->base)
        return NG_OK;
    m->size = 0;
    return ng_out_of_memory(what);
}

void *lf_memory_take(struct lf_memory *m, uint64_t count, size_t size)
{
    uint64_t left = m->size - m->used;
    if (!m->base || count > left / size)
        return NULL;
    unsigned char *part = m->base + m->used;
    uint64_t bytes = lf_memory_part(count * size);
    m->used += bytes < left ? bytes : left;
    return part;
}

void lf_memory_finish(struct lf_memory *m)
{
    if (!m->lent)
        free(m->base);
    *m = (struct lf_memory){0};
}

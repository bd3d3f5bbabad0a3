// Growth by half again: amortised constant, and freed blocks can be reused by the allocator.
#include "base/array.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

bool ng_array_reserve_(void **items, size_t *capacity, size_t size, size_t want)
{
    if (want <= *capacity)
        return true;
    size_t grown = *capacity + *capacity / 2;
    size_t cap = grown > want ? grown : want;
    if (cap < 8)
        cap = 8;
    if (cap > SIZE_MAX / size)
        return false;
    void *p = realloc(*items, cap * size);
    if (!p)
        return false;
    *items = p;
    *capacity = cap;
    return true;
}

bool ng_array_resize_(void **items, size_t *count, size_t *capacity, size_t size, size_t want)
{
    if (!ng_array_reserve_(items, capacity, size, want))
        return false;
    if (want > *count)
        memset((unsigned char *)*items + *count * size, 0, (want - *count) * size);
    *count = want;
    return true;
}

void ng_array_free_(void *items)
{
    free(items);
}

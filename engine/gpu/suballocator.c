// The free list holds at most one range more than there are live allocations, since two free neighbours are
// always merged. An allocation reserves that room in advance, so that giving back cannot fail.
#include "gpu/suballocator.h"

#include <assert.h>
#include <string.h>

bool ng_suballocator_init(struct ng_suballocator *s, uint64_t size)
{
    *s = (struct ng_suballocator){.size = size};
    return ng_array_push(&s->free, (struct ng_gpu_range){0, size});
}

void ng_suballocator_finish(struct ng_suballocator *s)
{
    ng_array_finish(&s->free);
    *s = (struct ng_suballocator){0};
}

static void remove_range(struct ng_suballocator *s, size_t i)
{
    s->free.count--;
    memmove(&s->free.items[i], &s->free.items[i + 1], (s->free.count - i) * sizeof *s->free.items);
}

static void insert_range(struct ng_suballocator *s, size_t i, struct ng_gpu_range range)
{
    assert(s->free.count < s->free.capacity);
    memmove(&s->free.items[i + 1], &s->free.items[i], (s->free.count - i) * sizeof *s->free.items);
    s->free.items[i] = range;
    s->free.count++;
}

// Takes [offset, offset + size) out of free range i; what remains before and after stays free.
static void carve(struct ng_suballocator *s, size_t i, uint64_t offset, uint64_t size)
{
    struct ng_gpu_range range = s->free.items[i];
    uint64_t before = offset - range.offset, after = range.size - before - size;
    if (before && after) {
        s->free.items[i].size = before;
        insert_range(s, i + 1, (struct ng_gpu_range){offset + size, after});
    } else if (before) {
        s->free.items[i].size = before;
    } else if (after) {
        s->free.items[i] = (struct ng_gpu_range){offset + size, after};
    } else {
        remove_range(s, i);
    }
}

uint64_t ng_suballocator_allocate(struct ng_suballocator *s, uint64_t size, uint64_t alignment)
{
    if (!ng_array_reserve(&s->free, (size_t)s->live + 2))
        return NG_SUBALLOCATOR_FULL;
    for (size_t i = 0; i < s->free.count; i++) {
        struct ng_gpu_range range = s->free.items[i];
        uint64_t padding = (alignment - range.offset % alignment) % alignment;
        if (padding <= range.size && size <= range.size - padding) {
            carve(s, i, range.offset + padding, size);
            s->live++;
            return range.offset + padding;
        }
    }
    return NG_SUBALLOCATOR_FULL;
}

// First free range that lies behind `offset`.
static size_t range_after(const struct ng_suballocator *s, uint64_t offset)
{
    size_t low = 0, high = s->free.count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (s->free.items[middle].offset > offset)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

void ng_suballocator_free(struct ng_suballocator *s, uint64_t offset, uint64_t size)
{
    struct ng_gpu_range *f = s->free.items;
    size_t i = range_after(s, offset);
    bool joins_before = i > 0 && f[i - 1].offset + f[i - 1].size == offset;
    bool joins_after = i < s->free.count && offset + size == f[i].offset;
    assert(s->live && (i == 0 || f[i - 1].offset + f[i - 1].size <= offset));
    s->live--;
    if (joins_before && joins_after) {
        f[i - 1].size += size + f[i].size;
        remove_range(s, i);
    } else if (joins_before) {
        f[i - 1].size += size;
    } else if (joins_after) {
        f[i] = (struct ng_gpu_range){offset, f[i].size + size};
    } else {
        insert_range(s, i, (struct ng_gpu_range){offset, size});
    }
}

// Blocks of growing size in a list; reset walks the same list again instead of freeing it.
#include "base/arena.h"

#include <stdalign.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define ALIGN      ((size_t)16)
#define BLOCK_SIZE ((size_t)64 << 10)

struct ng_arena_block {
    struct ng_arena_block *next;
    size_t size, used;
    alignas(16) unsigned char data[];
};

static struct ng_arena_block *block_with_room(struct ng_arena *a, size_t size)
{
    struct ng_arena_block *b = a->current;
    if (b && b->size - b->used >= size)
        return b;
    // After a reset the list still holds blocks: take the next one that is large enough, in order.
    while (b && b->next) {
        b = b->next;
        b->used = 0;
        if (b->size >= size)
            return a->current = b;
    }
    size_t want = b ? b->size * 2 : BLOCK_SIZE;
    if (want > (size_t)16 << 20)
        want = (size_t)16 << 20;
    if (want < size)
        want = size;
    if (want > SIZE_MAX - sizeof *b)
        return NULL;
    struct ng_arena_block *fresh = malloc(sizeof *fresh + want);
    if (!fresh)
        return NULL;
    *fresh = (struct ng_arena_block){.size = want};
    if (b)
        b->next = fresh;
    else
        a->first = fresh;
    return a->current = fresh;
}

void *ng_arena_alloc(struct ng_arena *a, size_t size)
{
    if (size > SIZE_MAX - ALIGN)
        return NULL;
    size = (size + ALIGN - 1) & ~(ALIGN - 1);
    if (a->limit && (size > a->limit || a->used > a->limit - size))
        return NULL;
    struct ng_arena_block *b = block_with_room(a, size);
    if (!b)
        return NULL;
    void *p = b->data + b->used;
    b->used += size;
    a->used += size;
    return memset(p, 0, size);
}

void *ng_arena_array(struct ng_arena *a, size_t count, size_t size)
{
    if (size && count > SIZE_MAX / size)
        return NULL;
    return ng_arena_alloc(a, count * size);
}

char *ng_arena_string(struct ng_arena *a, const char *text)
{
    size_t n = strlen(text) + 1;
    char *copy = ng_arena_alloc(a, n);
    return copy ? memcpy(copy, text, n) : NULL;
}

void ng_arena_reset(struct ng_arena *a)
{
    a->current = a->first;
    if (a->first)
        a->first->used = 0;
    a->used = 0;
}

void ng_arena_finish(struct ng_arena *a)
{
    for (struct ng_arena_block *b = a->first, *next; b; b = next) {
        next = b->next;
        free(b);
    }
    *a = (struct ng_arena){0};
}

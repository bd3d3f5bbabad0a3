// A bump allocator: many small allocations that die together (a frame, a file being parsed).
//
// Not thread-safe. Zero is a valid empty arena. ng_arena_reset keeps the memory, so that a frame loop
// allocates nothing once it has seen its largest frame.
#ifndef NG_BASE_ARENA_H
#define NG_BASE_ARENA_H

#include "base/extern_c.h"

#include <stddef.h>

NG_EXTERN_C_BEGIN

struct ng_arena_block;
struct ng_arena {
    struct ng_arena_block *first, *current;
    size_t used;  // bytes handed out since the last reset
    size_t limit; // 0: none; else an allocation that would pass it returns null
};

// Zeroed memory aligned to 16 bytes, or null (out of memory, or over the limit). A size of 0 gives a valid
// pointer.
void *ng_arena_alloc(struct ng_arena *a, size_t size);
// The same for `count` elements; null where count * size would overflow.
void *ng_arena_array(struct ng_arena *a, size_t count, size_t size);
// A copy of a string, or null.
char *ng_arena_string(struct ng_arena *a, const char *text);
void ng_arena_reset(struct ng_arena *a);
void ng_arena_finish(struct ng_arena *a);

NG_EXTERN_C_END

#endif

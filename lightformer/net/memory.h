// Memory that parts are taken of one after another, and that whoever owns an object may lend to it: so what a
// picture takes can lie in the buffers of a render graph. Without a loan it is the object's own.
//
//     lf_memory_lend(&memory, buffer, size);           // or not
//     NG_TRY(lf_memory_begin(&memory, most, "..."));   // all parts taken so far are void
//     if (!lf_take(&memory, &self->planes, count))     // any struct {T *items; size_t count;}
//
// Parts lie at multiples of 64 bytes and hold anything. Belongs to one thread.
#ifndef LF_NET_MEMORY_H
#define LF_NET_MEMORY_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

#define LF_MEMORY_ALIGNMENT 64

struct lf_memory {
    unsigned char *base;
    uint64_t size, used; // bytes
    bool lent;
};

// Bytes that a part of `bytes` takes.
static inline uint64_t lf_memory_part(uint64_t bytes)
{
    return (bytes + LF_MEMORY_ALIGNMENT - 1) / LF_MEMORY_ALIGNMENT * LF_MEMORY_ALIGNMENT;
}

// From now on `data`, borrowed, at a multiple of LF_MEMORY_ALIGNMENT, is the memory. What was taken before
// stays valid if it was of the same loan.
void lf_memory_lend(struct lf_memory *memory, void *data, uint64_t size);
// Makes all of it free, and sure that there are `bytes`. Errors, logged: NG_ERROR_MEMORY. `what` names it.
NG_NODISCARD ng_result lf_memory_begin(struct lf_memory *memory, uint64_t bytes, const char *what);
// Null where fewer bytes are left: more was taken than lf_memory_begin was told.
void *lf_memory_take(struct lf_memory *memory, uint64_t count, size_t size);
// Gives back what is not lent; the memory may be used again.
void lf_memory_finish(struct lf_memory *memory);

// An array that is a part.
#define LF_PART(T)                                                                                           \
    struct {                                                                                                 \
        T *items;                                                                                            \
        size_t count;                                                                                        \
    }

// A part for `n` items of an array. False as above.
#define lf_take(memory, array, n)                                                                            \
    ((array)->count = (n),                                                                                   \
     ((array)->items = lf_memory_take(memory, (array)->count, sizeof *(array)->items)) != NULL)

NG_EXTERN_C_END

#endif

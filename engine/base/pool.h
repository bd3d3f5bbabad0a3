// Handles that outlive what they name: an index and a generation, so that a stale handle is found, not
// followed.
//
// The pool hands out slots; the owner keeps its objects in an array of its own, indexed by slot.
// A handle is 0 when it names nothing. Generations are 12 bits and skip 0; a slot whose generations are used
// up is retired, so that no handle is ever given twice.
#ifndef NG_BASE_POOL_H
#define NG_BASE_POOL_H

#include "base/array.h"
#include "base/extern_c.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_pool {
    NG_ARRAY(uint16_t) generation; // by slot; bit 15: in use
    NG_ARRAY(uint32_t) free_slots;
};

#define NG_POOL_MAX_SLOTS (1u << 20)

// A new handle, or 0 when out of memory or slots.
uint32_t ng_pool_acquire(struct ng_pool *p);
// False if the handle is stale.
bool ng_pool_release(struct ng_pool *p, uint32_t handle);
bool ng_pool_has(const struct ng_pool *p, uint32_t handle);
static inline uint32_t ng_pool_slot(uint32_t handle)
{
    return handle & (NG_POOL_MAX_SLOTS - 1);
}
void ng_pool_finish(struct ng_pool *p);

NG_EXTERN_C_END

#endif

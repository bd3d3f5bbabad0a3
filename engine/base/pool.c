// A free list over slots; the generation of a slot moves on when it is released.
#include "base/pool.h"

#define IN_USE         0x8000u
#define MAX_GENERATION 0xfffu

uint32_t ng_pool_acquire(struct ng_pool *p)
{
    uint32_t slot;
    if (p->free_slots.count) {
        slot = p->free_slots.items[--p->free_slots.count];
    } else {
        slot = (uint32_t)p->generation.count;
        if (slot >= NG_POOL_MAX_SLOTS || !ng_array_push(&p->generation, 1))
            return 0;
        // Releasing must not fail: keep room for every slot in the free list.
        if (!ng_array_reserve(&p->free_slots, p->generation.count)) {
            p->generation.count--;
            return 0;
        }
    }
    p->generation.items[slot] |= IN_USE;
    return slot | (uint32_t)(p->generation.items[slot] & MAX_GENERATION) << 20;
}

bool ng_pool_has(const struct ng_pool *p, uint32_t handle)
{
    uint32_t slot = ng_pool_slot(handle);
    return handle && slot < p->generation.count && p->generation.items[slot] == (IN_USE | handle >> 20);
}

bool ng_pool_release(struct ng_pool *p, uint32_t handle)
{
    if (!ng_pool_has(p, handle))
        return false;
    uint32_t slot = ng_pool_slot(handle);
    uint16_t next = (uint16_t)((handle >> 20) + 1);
    p->generation.items[slot] = next;
    if (next <= MAX_GENERATION)
        p->free_slots.items[p->free_slots.count++] = slot;
    return true;
}

void ng_pool_finish(struct ng_pool *p)
{
    ng_array_finish(&p->generation);
    ng_array_finish(&p->free_slots);
}

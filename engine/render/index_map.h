// A hash table from 64-bit keys (entity and asset ids, hashes) to indices. Zero is empty; memory is kept when
// cleared. Key 0 is not stored.
#ifndef NG_RENDER_INDEX_MAP_H
#define NG_RENDER_INDEX_MAP_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_index_map {
    uint64_t *keys;
    uint32_t *values;
    size_t capacity, count; // capacity: 0 or a power of two
};

void ng_index_map_clear(struct ng_index_map *map);
void ng_index_map_finish(struct ng_index_map *map);
// Adds or replaces; false when out of memory.
bool ng_index_map_set(struct ng_index_map *map, uint64_t key, uint32_t value);
// UINT32_MAX if there is no such key.
uint32_t ng_index_map_get(const struct ng_index_map *map, uint64_t key);

NG_EXTERN_C_END

#endif

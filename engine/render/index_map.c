// Open addressing with linear probing, at most half full; nothing is ever deleted from it but all at once.
#include "render/index_map.h"

#include "base/hash.h"

#include <stdlib.h>

void ng_index_map_clear(struct ng_index_map *map)
{
    if (map->count)
        memset(map->keys, 0, map->capacity * sizeof *map->keys);
    map->count = 0;
}

void ng_index_map_finish(struct ng_index_map *map)
{
    free(map->keys);
    free(map->values);
    *map = (struct ng_index_map){0};
}

// The place of a key, or the empty one where it would be.
static size_t place_of(const struct ng_index_map *map, uint64_t key)
{
    size_t at = (size_t)ng_hash_u64(key) & (map->capacity - 1);
    while (map->keys[at] && map->keys[at] != key)
        at = (at + 1) & (map->capacity - 1);
    return at;
}

static bool grow(struct ng_index_map *map)
{
    struct ng_index_map larger = {.capacity = map->capacity ? map->capacity * 2 : 64};
    larger.keys = calloc(larger.capacity, sizeof *larger.keys);
    larger.values = malloc(larger.capacity * sizeof *larger.values);
    if (!larger.keys || !larger.values) {
        ng_index_map_finish(&larger);
        return false;
    }
    for (size_t i = 0; i < map->capacity; i++)
        if (map->keys[i]) {
            size_t at = place_of(&larger, map->keys[i]);
            larger.keys[at] = map->keys[i];
            larger.values[at] = map->values[i];
        }
    larger.count = map->count;
    struct ng_index_map old = *map;
    *map = larger;
    ng_index_map_finish(&old);
    return true;
}

bool ng_index_map_set(struct ng_index_map *map, uint64_t key, uint32_t value)
{
    if (map->count * 2 >= map->capacity && !grow(map))
        return false;
    size_t at = place_of(map, key);
    map->count += map->keys[at] == 0;
    map->keys[at] = key;
    map->values[at] = value;
    return true;
}

uint32_t ng_index_map_get(const struct ng_index_map *map, uint64_t key)
{
    if (!map->count)
        return UINT32_MAX;
    size_t at = place_of(map, key);
    return map->keys[at] ? map->values[at] : UINT32_MAX;
}

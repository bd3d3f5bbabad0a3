// Keys: 64-bit numbers that stand for content. Equal keys, equal content; 0 stands for content that nobody
// vouches for. A key is made of what the content follows from: revisions, sizes, the numbers of a camera.
//
//     uint64_t key = ng_key_add(NG_KEY, snapshot->geometry_version);
//     key = ng_key_add_bytes(key, camera->view, sizeof camera->view);
//
// Only a key says what a pass depends on (graph.h, "Keys"). Bytes of structs with padding are no content.
#ifndef NG_GRAPH_KEY_H
#define NG_GRAPH_KEY_H

#include "base/hash.h"

#define NG_KEY ((uint64_t)1) // a key of nothing yet

// Order matters. Never 0.
static inline uint64_t ng_key_add(uint64_t key, uint64_t value)
{
    uint64_t next = ng_hash_combine(key, value);
    return next ? next : NG_KEY;
}

static inline uint64_t ng_key_add_bytes(uint64_t key, const void *data, size_t size)
{
    uint64_t next = ng_hash_bytes(key, data, size);
    return next ? next : NG_KEY;
}

#endif

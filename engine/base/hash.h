// 64-bit hashing for tables, caches and content hashes. Not cryptographic; the same on every machine.
#ifndef NG_BASE_HASH_H
#define NG_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

// The finaliser of SplitMix64 (Steele et al. 2014): every input bit reaches every output bit.
static inline uint64_t ng_hash_u64(uint64_t x)
{
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static inline uint64_t ng_hash_combine(uint64_t seed, uint64_t value)
{
    return ng_hash_u64(seed + 0x9e3779b97f4a7c15u + value);
}

// Bytes, eight at a time. Start with seed 0; chain by passing the last result on.
static inline uint64_t ng_hash_bytes(uint64_t seed, const void *data, size_t size)
{
    const unsigned char *p = (const unsigned char *)data;
    uint64_t h = ng_hash_combine(seed, size), word;
    for (; size >= 8; p += 8, size -= 8) {
        memcpy(&word, p, 8);
        h = ng_hash_combine(h, word);
    }
    if (size) {
        word = 0;
        memcpy(&word, p, size);
        h = ng_hash_combine(h, word);
    }
    return h;
}

static inline uint64_t ng_hash_string(const char *text)
{
    return ng_hash_bytes(0, text, strlen(text));
}

#endif

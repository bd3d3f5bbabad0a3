// Meshes that Draco's own encoder compresses, for tests of what reads them.
#ifndef NG_TESTS_UNIT_DRACO_MAKER_H
#define NG_TESTS_UNIT_DRACO_MAKER_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct draco_source {
    uint32_t vertex_count, index_count;
    const float *positions; // [vertex_count][3]: attribute 0
    const uint8_t *colors;  // [vertex_count][4], normalized: attribute 1
    const uint32_t *indices;
    bool edgebreaker; // vertices in another order, positions quantized to 14 bits; else all as it is
    bool metadata;
};

// Bytes written; 0: there is no room, or Draco does not want to.
size_t draco_make(const struct draco_source *source, unsigned char *out, size_t room);

NG_EXTERN_C_END

#endif

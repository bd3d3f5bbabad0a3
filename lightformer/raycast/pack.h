// Halfs of a tile at once. Plain C that the compiler vectorizes, built for several instruction sets; all give
// the same bytes.
#ifndef LF_RAYCAST_PACK_H
#define LF_RAYCAST_PACK_H

#include "base/extern_c.h"
#include "lightformer/trace/tracer.h"

NG_EXTERN_C_BEGIN

#define LF_PACK_HALFS (4 * LF_PACKET)

struct lf_pack_kernels {
    void (*to_halfs)(const float from[LF_PACK_HALFS], uint16_t to[LF_PACK_HALFS]);
};

// The sets that this CPU has, the fastest first; null past the end.
const struct lf_pack_kernels *lf_pack_kernels_of(uint32_t index);

NG_EXTERN_C_END

#endif

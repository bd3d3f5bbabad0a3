#include "base/serial.h"

#include <stdatomic.h>

#define STEPS 40 // bits of a range

uint64_t ng_serial_range(void)
{
    static atomic_uint_least64_t ranges;
    return (atomic_fetch_add(&ranges, 1) + 1) << STEPS;
}

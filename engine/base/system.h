// What the engine asks of the operating system besides files and threads.
#ifndef NG_BASE_SYSTEM_H
#define NG_BASE_SYSTEM_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

// Nanoseconds of a clock that never goes back; differences only.
uint64_t ng_clock_ns(void);
// CPU time of the calling process in nanoseconds, all threads.
uint64_t ng_clock_cpu_ns(void);
// Processors this process may run on, at least 1.
uint32_t ng_system_processors(void);
// Largest resident set of this process so far, in bytes.
uint64_t ng_system_peak_memory(void);
// Bytes that this process may still take: what the system has available, within the limits of the process and
// of the control groups that it is in (containers, services). Systems promise more than they have, and end a
// process that takes them at their word; so ask before very large allocations. UINT64_MAX where it is not
// known.
uint64_t ng_system_available_memory(void);
// The same of a system whose /proc and /sys are found below `root`, for tests.
uint64_t ng_system_available_memory_below(const char *root);
// True if standard error is a terminal (progress bars).
bool ng_system_stderr_is_terminal(void);

NG_EXTERN_C_END

#endif

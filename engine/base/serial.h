// Numbers that stand for content wherever they come: an extractor's versions, an asset store's revisions. Two
// that count on their own would give different content one number, and a renderer that draws both would take
// one for the other.
#ifndef NG_BASE_SERIAL_H
#define NG_BASE_SERIAL_H

#include "base/extern_c.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

// A number from which a counter may go on for 2^40 steps without meeting another's. Never 0. Any thread.
uint64_t ng_serial_range(void);

NG_EXTERN_C_END

#endif

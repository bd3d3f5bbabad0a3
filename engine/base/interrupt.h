// The signals that ask a process to end: SIGINT (Ctrl-C), SIGTERM, SIGHUP (its terminal is gone). For
// programs: no library calls this. One that the process was started to ignore (nohup) stays ignored.
#ifndef NG_BASE_INTERRUPT_H
#define NG_BASE_INTERRUPT_H

#include "base/extern_c.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

// From now on these signals end the process as they always do, after ng_file_abandon; and a file that grows
// past the process's limit is an error of the write, not a signal.
void ng_interrupt_watch(void);

// From now on the first of these signals is only noted, as the program ends soon of its own accord; a second
// one ends it at once.
void ng_interrupt_hold(void);
// Whether one was noted.
bool ng_interrupt_came(void);
// The end of ng_interrupt_hold. If a signal was noted the process ends by it, and this does not return.
void ng_interrupt_release(void);

NG_EXTERN_C_END

#endif

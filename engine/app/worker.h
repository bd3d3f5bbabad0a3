// A thread that does one piece of work at a time for another thread, which must not wait for it: frames,
// while the window's own thread listens to a person.
#ifndef NG_APP_WORKER_H
#define NG_APP_WORKER_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct ng_worker;

struct ng_worker_params {
    void (*work)(void *user); // on the worker's thread
    void (*done)(void *user); // the same, when that is over; may be null
    void *user;
};

NG_NODISCARD ng_result ng_worker_create(const struct ng_worker_params *params, struct ng_worker **out);
// Waits for the work at hand.
void ng_worker_destroy(struct ng_worker **worker);

// Hands it the next piece, which may use all that the caller has written so far. It must not be at work.
void ng_worker_begin(struct ng_worker *worker);
// False: all that the work has written may be read.
bool ng_worker_is_busy(struct ng_worker *worker);

NG_EXTERN_C_END

#endif

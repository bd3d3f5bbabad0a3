// The one thread pool of a process: a parallel for over ranges, in which the caller takes part.
//
// Work is handed out in chunks of `grain` items by an atomic counter. Results must not depend on which worker
// runs a chunk: write to places that belong to the items. A call from inside a job runs in place, serially;
// calls from several threads wait for one another.
#ifndef NG_BASE_JOBS_H
#define NG_BASE_JOBS_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_jobs;

struct ng_jobs_params {
    uint32_t threads; // workers including the caller, at most 256; 0: one a processor
};

NG_NODISCARD ng_result ng_jobs_create(const struct ng_jobs_params *params, struct ng_jobs **out);
void ng_jobs_destroy(struct ng_jobs **jobs);
// Workers including the caller: `worker` below is smaller than this. 1 for a null pool.
uint32_t ng_jobs_threads(const struct ng_jobs *jobs);

// Runs on items [begin, end).
typedef void (*ng_jobs_fn)(void *user, uint32_t begin, uint32_t end, uint32_t worker);

// Runs fn over [0, count) and returns when all of it is done. A null pool runs everything in place.
void ng_jobs_for(struct ng_jobs *jobs, uint32_t count, uint32_t grain, ng_jobs_fn fn, void *user);

NG_EXTERN_C_END

#endif

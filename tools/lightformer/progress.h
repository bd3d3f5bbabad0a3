// A bar on standard error, where that is a terminal and the work takes longer than a second.
#ifndef LIGHTFORMER_PROGRESS_H
#define LIGHTFORMER_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

struct progress {
    const char *label; // "frame"
    uint64_t total, started_ns, shown_ns;
    bool shown;
};

void progress_begin(struct progress *p, const char *label, uint64_t total);
// `done` of `total` are done.
void progress_update(struct progress *p, uint64_t done);
// Removes the bar.
void progress_end(struct progress *p);

#endif

#include "progress.h"

#include "base/system.h"

#include <stdio.h>

#define SECOND_NS   1000000000u
#define INTERVAL_NS 100000000u

void progress_begin(struct progress *p, const char *label, uint64_t total)
{
    *p = (struct progress){.label = label, .total = total, .started_ns = ng_clock_ns()};
}

void progress_update(struct progress *p, uint64_t done)
{
    enum { WIDTH = 40 };
    uint64_t now = ng_clock_ns();
    if (now - p->started_ns < SECOND_NS || now - p->shown_ns < INTERVAL_NS || !ng_system_stderr_is_terminal())
        return;
    p->shown = true;
    p->shown_ns = now;

    char bar[WIDTH + 1];
    for (uint64_t i = 0; i < WIDTH; i++)
        bar[i] = i * p->total < done * WIDTH ? '#' : '.';
    bar[WIDTH] = 0;
    double elapsed_s = (double)(now - p->started_ns) * 1e-9;
    double left_s = done ? elapsed_s * (double)(p->total - done) / (double)done : 0;
    fprintf(stderr, "\r%s %llu/%llu [%s] %.0f s left \033[K", p->label, (unsigned long long)done,
            (unsigned long long)p->total, bar, left_s);
    fflush(stderr);
}

void progress_end(struct progress *p)
{
    if (p->shown)
        fputs("\r\033[K", stderr);
    p->shown = false;
}

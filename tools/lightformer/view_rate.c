#include "view_rate.h"

enum { ROOM = sizeof((struct view_rate *)0)->at / sizeof(double) };

void view_rate_add(struct view_rate *r, double now, double ms)
{
    r->at[r->newest] = now;
    r->ms[r->newest] = ms;
    r->newest = (r->newest + 1) % ROOM;
    r->count += r->count < ROOM;
}

struct view_figures view_rate_of(const struct view_rate *r, double now)
{
    struct view_figures f = {0};
    double sum = 0;
    uint32_t last = (r->newest + ROOM - 1) % ROOM;
    while (f.fps < r->count) {
        uint32_t i = (last + ROOM - f.fps) % ROOM;
        if (r->at[i] <= now - 1)
            break;
        sum += r->ms[i];
        f.fps++;
    }
    if (r->count)
        f.ms = f.fps ? sum / f.fps : r->ms[last];
    return f;
}

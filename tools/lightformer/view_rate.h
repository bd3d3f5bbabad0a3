// How fast pictures come: over the last second, and nothing older.
#ifndef LIGHTFORMER_VIEW_RATE_H
#define LIGHTFORMER_VIEW_RATE_H

#include <stdint.h>

// Zero to begin with.
struct view_rate {
    double at[512], ms[512]; // when each came, in seconds, and what it took; a ring
    uint32_t count, newest;  // newest: where the next one goes
};

struct view_figures {
    uint32_t fps; // pictures in the last second
    double ms;    // what one of them took, in the mean; of the last one if that is older
};

void view_rate_add(struct view_rate *rate, double now, double ms);
struct view_figures view_rate_of(const struct view_rate *rate, double now);

#endif

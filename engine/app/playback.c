#include "app/playback.h"

#include <math.h>

// Into [0, duration), or [0, ...) without one.
static double wrap(const struct ng_playback *p, double time)
{
    if (p->duration <= 0)
        return fmax(time, 0);
    double wrapped = fmod(time, p->duration);
    return wrapped < 0 ? wrapped + p->duration : wrapped;
}

void ng_playback_advance(struct ng_playback *p, double seconds)
{
    p->jumped = false;
    if (!p->playing)
        return;
    double before = p->time;
    p->time = wrap(p, p->time + seconds);
    p->jumped = p->time < before;
}

void ng_playback_seek(struct ng_playback *p, double time)
{
    p->time = wrap(p, time);
    p->jumped = true;
}

void ng_playback_scrub(struct ng_playback *p, double seconds)
{
    ng_playback_seek(p, p->time + seconds);
}

#include "view_tier.h"

#include <math.h>

#define STEP      0.75 // of the pixels, from a level to the next
#define AIM_MS    (0.85 * VIEW_MOVING_MS)
#define SPARE_MS  (0.8 * VIEW_MOVING_MS) // that a picture of more pixels may take, as far as one can tell
#define CALM_LONG 4

// What level 0 takes of level 1: as its pixels, unless it has been measured.
static double ratio_of(const struct view_tier *t)
{
    double most = t->upsamples ? 4 : 1 / STEP;
    return t->ratio > 0 ? fmin(fmax(t->ratio, 1 / STEP), most) : most;
}

// The level with most pixels that takes no longer than `limit`, where level 1 takes `ms`. What does not
// depend on pixels makes it too low a level, or a careful one.
static uint32_t level_within(const struct view_tier *t, double ms, double limit)
{
    if (ms * ratio_of(t) <= limit)
        return 0;
    double steps = ms > limit ? ceil(log(ms / limit) / -log(STEP) - 1e-9) : 0;
    return (uint32_t)fmin(1 + steps, VIEW_TIERS - 1);
}

void view_tier_add(struct view_tier *t, uint32_t level, double ms)
{
    t->ms = level ? ms / pow(STEP, level - 1.0) : ms / ratio_of(t);
    uint32_t more = level_within(t, t->ms, SPARE_MS);
    t->calm = ms <= VIEW_MOVING_MS && more < level ? t->calm + 1 : 0;
    if (ms > VIEW_MOVING_MS) {
        uint32_t fewer = level_within(t, t->ms, AIM_MS);
        t->level = fewer > level ? fewer : level + (level + 1 < VIEW_TIERS);
    } else if (t->calm >= CALM_LONG) {
        t->level = more;
        t->calm = 0;
    }
}

void view_tier_add_whole(struct view_tier *t, double ms)
{
    if (t->ms > 0)
        t->ratio = ms / t->ms;
    else
        t->level = level_within(t, ms / ratio_of(t), AIM_MS);
}

static void scale(const uint32_t whole[2], double by, uint32_t out[2])
{
    for (int i = 0; i < 2; i++) {
        out[i] = (uint32_t)lround((double)whole[i] * by);
        out[i] = out[i] ? out[i] : 1;
    }
}

struct view_pixels view_tier_pixels(const struct view_tier *t, uint32_t level, const uint32_t whole[2])
{
    struct view_pixels p;
    bool upsampled = t->upsamples && level > 0;
    scale(whole, pow(STEP, 0.5 * (upsampled ? level - 1 : level)), p.picture);
    scale(p.picture, upsampled ? 0.5 : 1, p.light);
    return p;
}

// The scene's clock in a person's hands: play, pause, scrub. Plain data; zero is a paused clock at 0 of a
// scene without animation.
#ifndef NG_APP_PLAYBACK_H
#define NG_APP_PLAYBACK_H

#include "base/extern_c.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct ng_playback {
    double time;     // seconds, what the scene is evaluated at
    double duration; // seconds; time wraps at it; 0: it runs on for ever
    bool playing;
    bool jumped; // the last change of time was a jump, so motion since the frame before means nothing
};

// Moves on by the time that has passed since the last frame, if playing.
void ng_playback_advance(struct ng_playback *p, double seconds);
// Jumps by some seconds, forwards or back, whether playing or not.
void ng_playback_scrub(struct ng_playback *p, double seconds);
// Jumps to a time.
void ng_playback_seek(struct ng_playback *p, double time);

NG_EXTERN_C_END

#endif

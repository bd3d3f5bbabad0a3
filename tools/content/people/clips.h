// What people do: poses as functions of the phase of a clip that loops.
#ifndef CONTENT_PEOPLE_CLIPS_H
#define CONTENT_PEOPLE_CLIPS_H

#include "skeleton.h"

#include <stdbool.h>

enum people_clip {
    CLIP_SING, // at a microphone on a stand
    CLIP_GUITAR,
    CLIP_DRUMS,      // seated
    CLIP_DANCE_STEP, // from side to side
    CLIP_DANCE_BOUNCE,
    CLIP_DANCE_SWAY,
    CLIP_CLAP,
    CLIP_ARMS_UP,
    CLIP_WALK, // on the spot: the ground moves back at people_walk_speed
    CLIP_TALK, // seated
    PEOPLE_CLIPS
};

struct clip {
    const char *name;
    double seconds;
    int keys; // intervals between keys
    bool seated;
};

extern const struct clip people_clips[PEOPLE_CLIPS];

// phase: 0 to 1. `p` is initialized and solved.
void people_pose(const struct skeleton *s, enum people_clip clip, double phase, struct pose *p);
// Metres a second, with `height`.
double people_walk_speed(const struct skeleton *s);

#endif

// Heads: skull, face with lids and lips that open, eyes, ears, brows, hair, beards.
#ifndef CONTENT_PEOPLE_HEAD_H
#define CONTENT_PEOPLE_HEAD_H

#include "body.h"

// What makes faces differ: 0 is a middling face, 1 and -1 are far from it.
struct face {
    double wide, long_jaw, jaw, chin, cheeks, brow, nose_long, nose_wide, nose_bridge, lips, mouth, eyes,
        eye_tilt, age;
};

struct hair {
    double front, side, back;  // heights of the hairline over the middle of the eyes
    double top, sides, behind; // thickness
    double parting;            // -1 right, 0 none, 1 left
    double curls, strands;     // how deep
    double length;             // of hair that hangs, below the eyes; 0: none
    double open;               // at which angle from the front it hangs
    double bun, tail;          // radius; length
    double beard;              // thickness
    double brows;              // thickness
};

void head_build(struct shape *s, const struct anatomy *a, const struct face *f, const struct hair *h,
                const double iris[3]);

#endif

// What tonemap.frag is told: how two layers become a picture (render/display.h).
#ifndef NG_SHARED_DISPLAY_H
#define NG_SHARED_DISPLAY_H

#include "types.h"

// How the texels of a layer are shown.
#define NG_SHOWN_RADIANCE  0 // exposure and tone map
#define NG_SHOWN_PLAIN     1 // linear 0..1
#define NG_SHOWN_RATIO     2 // of two images; 1 where the divisor is 0
#define NG_SHOWN_DIRECTION 3 // -1..1
#define NG_SHOWN_W         4 // the fourth channel, linear 0..1
#define NG_SHOWN_BEAUTY    5 // radiance; a background where nothing is seen

#define NG_COMPARE_NOTHING    0
#define NG_COMPARE_SPLIT      1 // left of a divider the one, right of it the other
#define NG_COMPARE_DIFFERENCE 2 // relative error of the left to the right

// Relative error that a difference shows in full colour.
#define NG_DIFFERENCE_FULL 0.5

struct ng_display_data {
    NG_UINT(encoding); // NG_SHOWN_*, of the left side
    NG_UINT(other_encoding);
    NG_UINT(comparison); // NG_COMPARE_*
    NG_FLOAT(divider);   // pixels from the left edge
    NG_FLOAT(cell);      // difference: pixels a side of a texel of both layers, at least 1
    NG_UINT(averaged);   // the map of positions is one of shares (render/antialias.h)
    NG_VEC3(background); // where nothing is seen: linear 0..1
};

#endif

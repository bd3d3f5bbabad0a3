// Where panels stand: in columns from the left, none over another, and the picture stays in view. Pure maths.
#ifndef NG_EDITOR_LAYOUT_H
#define NG_EDITOR_LAYOUT_H

#include "base/extern_c.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_panel {
    float wanted[2]; // width and height that would show all of it, pixels
    float at[2];     // what it gets: place and size; what does not fit in there is scrolled to
    float size[2];
};

// Places panels in a window of this size, first come first served. Each gets what it wants where there is
// room in a column; where there is none for another column, those in the last one share it.
void ng_layout_panels(float width, float height, struct ng_panel *panels, uint32_t count);

NG_EXTERN_C_END

#endif

// What upsample.frag is told (render/upsample.h).
#ifndef NG_SHARED_UPSAMPLE_H
#define NG_SHARED_UPSAMPLE_H

#include "types.h"

struct ng_upsample_data {
    NG_VEC2(scale); // pixels of light a pixel of the picture
    NG_VEC3(eye);
    NG_FLOAT(pixel);        // width of a pixel of light at distance 1
    NG_FLOAT(pixel_at_eye); // and at distance 0, metres: of orthographic cameras
};

#endif

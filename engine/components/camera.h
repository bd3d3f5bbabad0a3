// A pinhole camera at its entity's placement, looking along -Z with +Y up.
#ifndef NG_COMPONENTS_CAMERA_H
#define NG_COMPONENTS_CAMERA_H

#include "scene/component.h"

// Reverse-Z, infinite far plane. The aspect ratio is the picture's.
struct ng_camera {
    float fov_y;         // vertical field of view, radians
    float near_plane;    // metres
    float exposure;      // factor on radiance before the tone map
    bool auto_exposure;  // the factor is on what a light meter finds (render/meter.h)
    float background[3]; // linear, of a display: shown where neither a surface nor an environment is seen
};

#endif

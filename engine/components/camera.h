// A camera at its entity's placement, looking along -Z with +Y up: a pinhole, or orthographic.
#ifndef NG_COMPONENTS_CAMERA_H
#define NG_COMPONENTS_CAMERA_H

#include "scene/component.h"

enum ng_projection { NG_PROJECTION_PERSPECTIVE, NG_PROJECTION_ORTHOGRAPHIC };

// Nothing is too far to be seen. The aspect ratio is the picture's.
struct ng_camera {
    float fov_y;         // perspective: vertical field of view, radians
    uint32_t projection; // enum ng_projection
    float height;        // orthographic: of what is seen, metres
    float near_plane;    // metres
    float exposure;      // factor on radiance before the tone map
    bool auto_exposure;  // the factor is on what a light meter finds (render/meter.h)
    float background[3]; // linear, of a display: shown where neither a surface nor an environment is seen
};

#endif

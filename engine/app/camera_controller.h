// A camera in a person's hands: orbit around a point, or fly.
//
// Pure maths over plain data, no window. The two ways share one state, an eye that looks at a point in some
// distance: orbiting turns the eye about the point, flying turns the point about the eye.
#ifndef NG_APP_CAMERA_CONTROLLER_H
#define NG_APP_CAMERA_CONTROLLER_H

#include "app/input.h"
#include "base/extern_c.h"
#include "components/transform.h"

NG_EXTERN_C_BEGIN

// Zero is not valid: begin with ng_camera_controller_look.
struct ng_camera_controller {
    float eye[3];
    float yaw, pitch; // radians; 0, 0 looks along -Z; yaw turns to the left, pitch up
    float distance;   // metres to the point that orbits turn about
    float speed;      // of flight, metres a second
    bool mirrors;     // shows what a mirror would: left and right are exchanged on screen
};

// Takes over the view of a camera-to-world matrix (column-major; roll is dropped, a mirror stays), turning
// about the point `distance` metres ahead.
void ng_camera_controller_look(struct ng_camera_controller *c, const float matrix[16], float distance);

// Angles in radians. The pitch stops short of the poles.
void ng_camera_controller_orbit(struct ng_camera_controller *c, float yaw, float pitch);
void ng_camera_controller_turn(struct ng_camera_controller *c, float yaw, float pitch);
// Moves eye and point: metres right, up and ahead in the camera's own directions, which no mirror exchanges.
void ng_camera_controller_move(struct ng_camera_controller *c, float right, float up, float ahead);
// Brings the eye nearer to the point (positive) or away, a tenth of the distance a step.
void ng_camera_controller_zoom(struct ng_camera_controller *c, float steps);

// The keys and mouse of `lightformer view`: left drag orbits, right drag looks around, middle drag slides,
// the wheel zooms; W A S D fly, E and Q rise and sink, Shift flies four times as fast.
// `height` is the framebuffer's in pixels, `seconds` the time since the last frame.
void ng_camera_controller_update(struct ng_camera_controller *c, const struct ng_input *input, float height,
                                 float seconds);

// Where the camera is: what to write to its entity, which must have no parent.
struct ng_transform ng_camera_controller_transform(const struct ng_camera_controller *c);

NG_EXTERN_C_END

#endif

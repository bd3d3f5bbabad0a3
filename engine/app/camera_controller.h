// A camera in a person's hands: orbit around a point, slide, zoom, or fly.
//
// Pure maths over plain data, no window. All ways share one state, an eye and a point that it sees: orbiting
// turns the eye about the point, sliding and zooming move it past the point, and the point stays where it is
// on screen. Flying and looking around take the point along.
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
    float point[3];   // metres from the eye, in the camera's own directions: right, up, ahead
    float reach;      // metres: how far away things are where nobody knows
    float speed;      // of flight, metres a second
    bool mirrors;     // shows what a mirror would: left and right are exchanged on screen
    bool parallel;    // an orthographic view: as large whatever the distance
    float lens;       // height of what it shows over the distance; parallel: the height, metres
};

// Takes over the view of a camera-to-world matrix (column-major; roll is dropped, a mirror stays), with a
// point `reach` metres ahead. The lens is one of 90 degrees; ng_camera_controller_see gives it another.
void ng_camera_controller_look(struct ng_camera_controller *c, const float matrix[16], float reach);
// `lens` as above.
void ng_camera_controller_see(struct ng_camera_controller *c, float lens, bool parallel);
// The point from now on: what the pointer is on, in the world.
void ng_camera_controller_take(struct ng_camera_controller *c, const float world[3]);
// The same where the pointer is on nothing: `reach` away, under (x, y), from -1 to 1 to the right and down in
// a picture of this width over its height.
void ng_camera_controller_take_nothing(struct ng_camera_controller *c, float x, float y, float aspect);
void ng_camera_controller_point(const struct ng_camera_controller *c, float world[3]);

// Angles in radians. The pitch stops short of the poles.
void ng_camera_controller_orbit(struct ng_camera_controller *c, float yaw, float pitch);
void ng_camera_controller_turn(struct ng_camera_controller *c, float yaw, float pitch);
// Moves eye and point: metres right, up and ahead in the camera's own directions, which no mirror exchanges.
void ng_camera_controller_move(struct ng_camera_controller *c, float right, float up, float ahead);
// Moves the eye past the point: parts of the picture's height.
void ng_camera_controller_slide(struct ng_camera_controller *c, float right, float up);
// Brings the eye nearer to the point (positive) or away, a tenth of the distance a step.
void ng_camera_controller_zoom(struct ng_camera_controller *c, float steps);
// Shows all of a sphere, from the side that it is looked at from already; it orbits its centre.
void ng_camera_controller_frame(struct ng_camera_controller *c, const float center[3], float radius,
                                float aspect);

// Whether a person flies: the wheel is for the speed then.
bool ng_camera_controller_flies(const struct ng_input *input);
// The keys and mouse of `lightformer view`: left drag orbits, right drag looks around, middle drag slides,
// the wheel zooms; W A S D fly, E and Q rise and sink, Shift flies four times as fast; the wheel sets the
// speed while one of these or the right button is down. A key moves the eye by speed times the seconds that
// it was held. `height` is the framebuffer's in pixels.
void ng_camera_controller_update(struct ng_camera_controller *c, const struct ng_input *input, float height);

// Where the camera is: what to write to its entity, which must have no parent.
struct ng_transform ng_camera_controller_transform(const struct ng_camera_controller *c);

NG_EXTERN_C_END

#endif

// Where a camera stands and how it is turned, as text: what a window shows can be drawn again.
#ifndef LIGHTFORMER_POSE_H
#define LIGHTFORMER_POSE_H

#include "options.h"

#include "base/result.h"
#include "render/extract.h"
#include "scene/entity.h"

#define CLI_POSE(type_)                                                                                      \
    {                                                                                                        \
        .name = "--pose", .kind = CLI_TEXT, .flags = CLI_PICTURE, .offset = offsetof(type_, pose),           \
        .value = "X,Y,Z,YAW,PITCH[,H]",                                                                      \
        .doc = "the camera from another place, metres and radians; H: height of an orthographic view"        \
    }

// Yaw turns to the left, pitch up; 0, 0 looks along -Z.
struct pose {
    float eye[3], yaw, pitch;
    float height; // of what an orthographic camera sees, metres; 0: as the camera has it
};

static inline bool pose_same(const struct pose *a, const struct pose *b)
{
    return a->eye[0] == b->eye[0] && a->eye[1] == b->eye[1] && a->eye[2] == b->eye[2] && a->yaw == b->yaw &&
           a->pitch == b->pitch && a->height == b->height;
}

#define POSE_TEXT 128

// False, reported, if a text is none; null is one.
bool pose_check(const char *text, const char *command);
struct pose pose_read(const char *text);
void pose_write(const struct pose *pose, char out[POSE_TEXT]);

struct ng_camera;
struct ng_camera_controller;
struct ng_world;

struct pose pose_of(const struct ng_camera_controller *controller);
void pose_take(const struct pose *pose, struct ng_camera_controller *controller);

// A camera of a scene by its name; null: there is none.
ng_entity pose_find_camera(const struct ng_world *world, ng_entity root, const char *name);
// What such a camera sees, once it has been placed; false: it has not.
bool pose_look(const struct ng_world *world, ng_entity root, ng_entity camera,
               struct ng_camera_controller *out);

// A camera that stands where the controller has it, in no world. Its lens is like another, but for the height
// of a parallel view.
struct ng_free_camera pose_camera(const struct ng_camera_controller *controller,
                                  const struct ng_camera *like);

#endif

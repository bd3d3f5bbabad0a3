// Where the pictures of `lightformer view` are made: scene, methods and device, on a thread of their own.
//
// The window's thread hands an order in and gets a frame back; neither looks at the other's things.
#ifndef LIGHTFORMER_VIEW_STUDIO_H
#define LIGHTFORMER_VIEW_STUDIO_H

#include "opening.h"
#include "pose.h"
#include "view_picture.h"

#include "app/camera_controller.h"
#include "app/pick.h"
#include "base/array.h"

struct ng_gpu;
struct ng_watch;

// All that a picture follows from. Zero it before it is filled: orders are compared as bytes.
struct view_order {
    char scene[4096];       // path
    uint32_t opening;       // another number: open it, again if it is there already
    uint32_t camera, looks; // another number of looks: see what this camera of the scene sees
    uint32_t clip;          // NG_CLIPS_*, or one
    struct pose pose;
    float stops;
    uint32_t width, height;
    double time;
    struct view_side sides[VIEW_SIDES];
    uint32_t comparison;
    float divider;
};

// Whether its picture can be antialiased: what is compared and measured is seen through the middles of
// pixels, and so is what gets better by itself.
bool view_order_antialiases(const struct view_order *order);

struct view_clip {
    char name[64];
    float duration; // seconds
    bool plays;
};
struct view_camera {
    char name[64];
};
struct view_pass {
    char name[64];
    double cpu_ms, gpu_ms;
};

struct view_frame {
    ng_result result;        // NG_ABANDONED: nothing below has changed
    struct view_order order; // that it is of; with the pose that it has
    bool failed;             // the scene that was asked for cannot be shown; another one is
    char scene[4096];        // path of the one that is
    uint64_t scene_hash;
    struct ng_camera_controller home; // what the camera that was last looked through sees
    bool from_home;                   // so does this picture, wherever the order put the camera
    double duration;                  // of the scene's animation, seconds
    bool auto_exposure;
    uint32_t width, height;
    NG_ARRAY(uint8_t) pixels; // [height][width][4], as a display shows them
    struct ng_pick pick;
    char sides[VIEW_SIDES][256]; // "reference, direct: 12 spp, ..."
    bool unfinished;             // the same order again makes a better picture
    bool whole;                  // it has all the pixels that were asked for
    uint32_t averaged;           // so many pictures, antialiased; 0: none can be
    uint32_t samples;            // a pixel, of what is path traced; 0: a preview, or nothing is
    uint32_t cell;               // of a difference of it: means over so many pixels a side
    const char *weights;         // of the network, as asked for; borrowed from the parameters
    uint32_t light[2];           // pixels that light was computed for, across and down
    char tier[96];               // how many pixels were made of those that are shown, for people
    double ms, world_ms, extract_ms;
    NG_ARRAY(struct view_pass) passes; // that ran
    NG_ARRAY(struct view_clip) clips;
    NG_ARRAY(struct view_camera) cameras;
};
void view_frame_finish(struct view_frame *frame);

struct view_studio_params {
    const char *device, *weights, *pose; // as options have them; the latter are of the first scene
    uint32_t threads, samples;
    uint32_t method, other; // that must be at hand; others may lack weights
    bool compares;
    const struct opening *opening;
    struct ng_watch *watch; // borrowed: gets the scene's files
};

struct view_studio;

NG_NODISCARD ng_result view_studio_create(const struct view_studio_params *params, struct view_studio **out);
void view_studio_destroy(struct view_studio **studio);

// While it draws nothing: its device; null: none yet.
struct ng_gpu *view_studio_gpu(const struct view_studio *studio);

struct view_drawing {
    const struct view_order *order;
    bool jumped;       // the time did: no motion since the last frame
    bool moving;       // something does: fewer pixels, in time
    uint32_t averaged; // as in struct ng_render_params; only where the order can be (view_order_antialiases)
    float seconds;     // since the last frame, for the eye's adaptation; INFINITY: it has had all the time
    bool (*abandon)(void *user);
    void *user;
};
// Makes a picture. `frame` holds the last one that came from here, or zero.
void view_studio_draw(struct view_studio *studio, const struct view_drawing *drawing,
                      struct view_frame *frame);

#endif

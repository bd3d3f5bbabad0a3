// What is under the pointer in a window: where it is, and which thing. Taken from a picture that was
// drawn, so that it answers at once and for what one sees.
#ifndef NG_APP_PICK_H
#define NG_APP_PICK_H

#include "base/array.h"
#include "base/extern_c.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_graph;
struct ng_snapshot;

// A thing, or a part of it of one material.
struct ng_pick_bounds {
    uint32_t entity; // index half of its id
    float low[3], high[3];
};

// Zero to begin with: nothing is anywhere.
struct ng_pick {
    uint32_t width, height;
    NG_ARRAY(float) positions;   // [height][width][4]: world; w is 0 where there is nothing
    NG_ARRAY(uint32_t) entities; // [height][width]
    NG_ARRAY(struct ng_pick_bounds) things;
    float center[3], radius; // of the scene
};

// For struct ng_stage_frame: what a frame must hand out to be picked in.
extern const char *const ng_pick_resources[2];
// Remembers a frame; if there is no memory for it, that nothing is anywhere.
void ng_pick_remember(struct ng_pick *pick, struct ng_graph *graph, const struct ng_snapshot *snapshot);
void ng_pick_finish(struct ng_pick *pick);

// What is at (x, y) of the picture, pixels from its top left; false: nothing.
bool ng_pick_point(const struct ng_pick *pick, float x, float y, float world[3]);
// A sphere around the thing there.
bool ng_pick_thing(const struct ng_pick *pick, float x, float y, float center[3], float *radius);

NG_EXTERN_C_END

#endif

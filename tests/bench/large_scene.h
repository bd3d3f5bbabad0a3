// A room full of things of many triangles each: what costs grow with. The same bytes everywhere.
#ifndef NG_TESTS_BENCH_LARGE_SCENE_H
#define NG_TESTS_BENCH_LARGE_SCENE_H

#include "base/result.h"

#include <stdbool.h>
#include <stdint.h>

struct large_scene {
    uint32_t things;    // named "thing 0", "thing 1", ...
    uint32_t triangles; // of each, about
    bool copies;        // all of one mesh, or else each of a mesh of its own
};

// Writes it as GLB, with a camera and an area light.
NG_NODISCARD ng_result large_scene_write(const struct large_scene *scene, const char *path);

#endif

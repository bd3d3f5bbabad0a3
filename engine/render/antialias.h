// Antialiased pictures: the mean of several frames, whose rays pass elsewhere in the pixels (subpixel.h).
#ifndef NG_RENDER_ANTIALIAS_H
#define NG_RENDER_ANTIALIAS_H

#include "base/extern_c.h"
#include "graph/provider.h"

NG_EXTERN_C_BEGIN

struct ng_antialias;
struct ng_gpu;

struct ng_antialiased {
    struct ng_graph_ref beauty; // RGBA32F: radiance, called "beauty"
    struct ng_graph_ref shares; // RG32F: the parts of a pixel in which nothing is seen, and what is unlit
};

NG_NODISCARD ng_result ng_antialias_create(struct ng_gpu *gpu, struct ng_antialias **out);
void ng_antialias_destroy(struct ng_antialias **antialias);

// Declares the pass that makes a picture the mean of itself and of those before it, of which it is the
// `count`th; 1: the first. The count of the last frame once more: the same mean again. NG_ERROR_USAGE if the
// last frame was neither that nor the one before.
NG_NODISCARD ng_result ng_antialias_declare(struct ng_antialias *antialias, struct ng_composer *composer,
                                            struct ng_graph_ref beauty, uint32_t count,
                                            struct ng_antialiased *out);

NG_EXTERN_C_END

#endif

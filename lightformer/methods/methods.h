// The methods: how light is computed. One table, for every program that draws with them.
//
//     struct lf_method *method;
//     NG_TRY(lf_method_create(&(struct lf_method_params){.name = "neural",
//                                                        .composer = ng_renderer_composer(renderer),
//                                                        .jobs = jobs,
//                                                        .scene = "content/chess/chess.glb"},
//                             &method));
//     ... frames with .method = "neural" ...
//     lf_method_destroy(&method);
//
// Belongs to the thread of the renderer. To add a method, add a row to methods.c.
#ifndef LF_METHODS_METHODS_H
#define LF_METHODS_METHODS_H

#include "base/extern_c.h"
#include "graph/provider.h"
#include "lightformer/raycast/raycast.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct lf_neural;
struct ng_jobs;

// ---- The table

#define LF_METHODS     3u         // rows
#define LF_METHOD_NONE UINT32_MAX // index of none

struct lf_method_info {
    const char *name; // as frames ask for it (render/frame.h)
    bool indirect;    // it computes indirect light
    bool progressive; // its picture gets better from frame to frame (lf_method_progress_of)
};

// In order; null past the end.
const struct lf_method_info *lf_method_info(uint32_t index);
const char *lf_method_name(uint32_t index);
uint32_t lf_method_find(const char *name);
// Of a scene for which none is asked for: "neural" where there are weights, named or the scene's own
// (lf_neural_find_weights), else "raster".
const char *lf_method_default(const char *scene, const char *weights);

// ---- A method in a renderer

struct lf_method;

struct lf_method_params {
    const char *name;             // of the table
    struct ng_composer *composer; // of the renderer; borrowed, must outlive the method
    struct ng_jobs *jobs;         // borrowed; null: the caller's thread alone
    // Of "neural":
    const char *weights;         // path of a network; null: the scene's own
    const char *scene;           // path of what is drawn, to find those; may be null if weights are named
    enum lf_raycast_use gbuffer; // as in struct lf_neural_params
    // Without weights the method still joins, and computes nothing: where it is at hand unasked.
    bool optional;
    // Of progressive methods, as in struct lf_progressive_params:
    uint32_t samples;
    double slice;
};

// Makes the renderer know the method. Once a renderer.
NG_NODISCARD ng_result lf_method_create(const struct lf_method_params *params, struct lf_method **out);
// Leaves the renderer.
void lf_method_destroy(struct lf_method **method);

// What is behind "neural"; null for others, and without weights.
struct lf_neural *lf_method_neural(const struct lf_method *method);

struct lf_method_progress {
    bool unfinished;  // more frames of the same would make a better picture
    uint32_t samples; // a pixel, so far
};
struct lf_method_progress lf_method_progress_of(const struct lf_method *method);

// What there is to say of its picture so far, for people: "64 spp, 3.1 s". Empty: nothing.
void lf_method_describe(const struct lf_method *method, char *out, size_t size);

NG_EXTERN_C_END

#endif

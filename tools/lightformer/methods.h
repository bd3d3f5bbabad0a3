// The methods: how light is computed. One table, from which render, view and bench take what --method
// accepts. To add a method, add a row to methods.c.
//
// "auto", the default of --method, is neural where there are weights (--weights, or a file beside the scene:
// lf_neural_find_weights), and else raster.
#ifndef LIGHTFORMER_METHODS_H
#define LIGHTFORMER_METHODS_H

#include "base/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct ng_stage;

// What --gbuffer takes, as in enum lf_raycast_use of lightformer/raycast/raycast.h; null-terminated.
extern const char *const method_gbuffers[];

// Where a method can be used.
enum { METHOD_RENDER = 1, METHOD_VIEW = 2, METHOD_BENCH = 4 };

struct method_params {
    struct ng_stage *stage; // borrowed; with a device
    const char *scene;      // path of what is on it
    const char *weights;    // path of a network; null: the scene's own
    uint32_t gbuffer;       // of method_gbuffers
    // Without weights the method still joins, and computes nothing: where it is at hand unasked (view).
    bool optional;
    uint32_t samples; // of methods that refine their picture: a pixel, at which they rest; 0: never
};

struct method_progress {
    bool unfinished;  // more frames of the same would make a better picture
    uint32_t samples; // a pixel, so far
};

struct method {
    const char *name; // of --method, and of the frame (render/frame.h)
    char key;         // that chooses it in view
    unsigned uses;    // METHOD_*
    bool indirect;    // it computes indirect light
    const char *doc;  // a few words
    // Joins the stage's renderer. Null: the renderer has it. `*state` is what the others take.
    ng_result (*create)(const struct method_params *params, void **state);
    void (*destroy)(void **state);
    // What there is to say of its picture so far, for people: "64 spp, 3.1 s". Null: nothing.
    void (*describe)(const void *state, char *out, size_t size);
    // How far its picture has come. Null: each is finished.
    struct method_progress (*progress)(const void *state);
};

#define METHOD_MAX 8 // rows of the table at most

// The methods of one use, in order; null past the end.
const struct method *method_of(unsigned use, uint32_t index);
// Their names.
const char *method_render_name(uint32_t index);
const char *method_view_name(uint32_t index);
const char *method_bench_name(uint32_t index);
// For tables of options: the names, then "auto".
const char *method_render_option(uint32_t index);
const char *method_view_option(uint32_t index);
const char *method_bench_option(uint32_t index);
// The method that such an option means.
uint32_t method_choose(unsigned use, uint32_t option, const char *scene, const char *weights);

// Makes a stage's renderer know a method. Close it before the stage.
NG_NODISCARD ng_result method_open(const struct method *method, const struct method_params *params,
                                   void **state);
// What is behind the method "neural"; null for others, and without weights.
struct lf_neural *method_neural(const struct method *method, void *state);
void method_close(const struct method *method, void **state);
struct method_progress method_progress(const struct method *method, const void *state);
// Empty if there is nothing to say.
void method_describe(const struct method *method, const void *state, char *out, size_t size);

#endif

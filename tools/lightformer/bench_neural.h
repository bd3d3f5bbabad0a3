// What the method "neural" costs: the sections of `lightformer bench --method neural` beside those of any
// method. Everything is measured with all of it redone in every frame: every light's surroundings, every
// clue, every encoding. Each part is printed once it is known.
#ifndef LIGHTFORMER_BENCH_NEURAL_H
#define LIGHTFORMER_BENCH_NEURAL_H

#include "base/result.h"
#include "bench_paths.h"
#include "json.h"

#include <stdbool.h>
#include <stdint.h>

struct opening;

struct bench_neural_params {
    const char *scene, *device, *weights; // weights: a path, or null: the scene's own
    const struct opening *opening;
    uint32_t gbuffer; // of method_gbuffers (method_options.h)
    uint32_t threads, width, height;
    uint32_t frames; // of each measurement, at most
    double seconds;  // that all measurements of the command should take
    bool budget;     // only what a frame takes: no growth, memory, first picture
    bool silent;     // nothing is printed
};

#define BENCH_STAGES 11
#define BENCH_STEPS  5

struct bench_neural {
    bool budget_only; // all that follows frame_ratio is 0
    // Of a frame with the scene's own lights, milliseconds, in order of work; the last is what remains.
    struct {
        const char *name;
        double ms;
    } budget[BENCH_STAGES];
    uint32_t stage_count;
    double frame_ms;    // whole
    double sample_ms;   // one sample a pixel of the path tracer, depth 5, between the same frames
    double frame_ratio; // median over frames of frame_ms / sample_ms
    struct bench_neural_step {
        uint32_t count; // lights, or pieces
        double frame_ms, encode_ms, gather_ms, network_ms;
    } lights[BENCH_STEPS], pieces[2];
    double fixed_ms, light_ms;               // of a frame: what no light adds to, and what each adds
    double encode_slope_ms, gather_slope_ms; // a light
    double encode_curve, gather_curve;       // largest distance from the line, as a share of the value
    double many_ms[2], many_ratio;           // of half the size: frames of 7 and of 100 lights
    struct bench_paths paths;                // each kind of work and its bound
    // Of a room with seven lamps: a frame in which one of them moves, one in which all is redone, a sample a
    // pixel of the path tracer, and the medians of quotients.
    double drag_ms, redo_ms, room_sample_ms, drag_ratio, room_ratio;
    double memory_mib; // peak of a process that draws 7 lights; 0: not measured
    double plan_mib;   // what the graph of the room's frames holds
    // From the start of a process to its first picture, and the processor time that it took; 0: not measured.
    double first_frame_s, first_frame_cpu_s;
};

// Both show progress; errors were logged by the part that met them. First what processes of their own do,
// while the caller has not made any thread; then the rest.
NG_NODISCARD ng_result bench_neural_measure_processes(const struct bench_neural_params *params,
                                                      struct bench_neural *out);
NG_NODISCARD ng_result bench_neural_measure(const struct bench_neural_params *params,
                                            struct bench_neural *out);
// Members of the object that is open: "neural".
void bench_neural_write(const struct bench_neural *b, struct json *j);
// The i-th ratio; false past the end.
bool bench_neural_ratio(const struct bench_neural *b, uint32_t index, char *name, size_t size, double *value);

#endif

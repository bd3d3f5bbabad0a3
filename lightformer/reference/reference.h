// Ground truth: an unbiased path-traced picture of a snapshot, refined for as long as one likes.
//
//     struct lf_reference *reference;
//     NG_TRY(lf_reference_create(&params, &reference));
//     NG_TRY(lf_reference_begin(reference, tracer));                 // tracer: already at the snapshot
//     NG_TRY(lf_reference_run(reference, &(struct lf_reference_run_params){.samples = 64}));
//     NG_TRY(lf_reference_layer(reference, "indirect", &layer));
//
// Every pixel takes the same number of samples. Sums are kept in fp64 and in the order of the samples, so
// that the picture is the same for any number of threads, any division into runs, and across a checkpoint.
// Without antialiasing all samples of a pixel start at the hit of the ray through its centre; with it they
// spread over the pixels around (a tent), and only layers of light are filtered: positions, normals and the
// like stay those of the centre.
//
// One thread calls; the work is spread over its jobs.
#ifndef LF_REFERENCE_REFERENCE_H
#define LF_REFERENCE_REFERENCE_H

#include "base/extern_c.h"
#include "lightformer/reference/path.h"
#include "lightformer/trace/tracer.h"

NG_EXTERN_C_BEGIN

struct ng_jobs;
struct lf_reference;

// A part of a picture, pixels; zero size: all of it. A pixel is the same in any region that holds it.
struct lf_region {
    uint32_t x, y, width, height;
};

struct lf_reference_params {
    uint32_t width, height; // of the whole picture, 1 to 16,384
    struct lf_region region;
    uint32_t depth; // segments of a path, the camera's included: 1 emission, 2 direct light; 0: no limit
    enum lf_sampler_kind sampler;
    uint64_t seed;
    float clamp; // largest indirect radiance of one sample; biased; 0: none
    bool antialias;
    bool timed;           // measure where the time goes (lf_reference_stats.paths), at a cost of about 1 %
    struct ng_jobs *jobs; // borrowed; null: this thread
};

// Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_reference_create(const struct lf_reference_params *params,
                                           struct lf_reference **out);
void lf_reference_destroy(struct lf_reference **reference);

// Forgets all samples and starts on what the tracer holds, which must stay as it is until the last layer is
// fetched. Borrowed.
NG_NODISCARD ng_result lf_reference_begin(struct lf_reference *reference, const struct lf_tracer *tracer);

struct lf_reference_progress {
    uint32_t samples, target; // a pixel
    double seconds, seconds_left;
    uint64_t rays;
};

struct lf_reference_run_params {
    uint32_t samples;  // a pixel, in all, earlier runs included
    double time_limit; // seconds; stops after the pass in which they end; 0: none
    // Called between passes, at most about once a second; false stops. May be null.
    bool (*progress)(void *user, const struct lf_reference_progress *progress);
    void *user;
    // A file in which the samples are kept: continued if it is there, written now and then and at the end.
    // One that cannot be written (a full disk) costs no samples: lf_reference_stats.unsaved. It must be of
    // the same picture: parameters and `picture`, a hash of all else that it follows from.
    const char *checkpoint;
    uint64_t picture;
    double checkpoint_interval; // seconds; 0: 60
};

// Adds samples. Errors, logged: NG_ERROR_FORMAT (a sample that is not a number, with its pixel and seed; a
// checkpoint that is damaged or of another picture), NG_ERROR_IO (one that cannot be read).
NG_NODISCARD ng_result lf_reference_run(struct lf_reference *reference,
                                        const struct lf_reference_run_params *params);

struct lf_reference_stats {
    uint32_t samples; // a pixel
    bool unsaved;     // the last run could not write its checkpoint, which was logged
    // Of the runs since lf_reference_begin:
    uint64_t rays; // path and shadow rays
    double seconds;
    struct lf_path_stats paths;
};
struct lf_reference_stats lf_reference_stats_of(const struct lf_reference *reference);

// ---- Layers ----------------------------------------------------------------------------------------------
// Those of engine/README.md, "Layers of a picture"; and "variance" (of the mean, of beauty,
// by channel) and "samples".
struct lf_layer_info {
    const char *name;
    const char *channels[4]; // within the layer: "R", "G", "B"; "X"; "Z"; "id"; null-terminated
    bool uint;               // 32-bit unsigned instead of float
    const char *doc;         // one line
};
const struct lf_layer_info *lf_reference_layer_info(uint32_t index);   // null past the end
const struct lf_layer_info *lf_reference_find_layer(const char *name); // null if there is none

struct lf_layer {
    const struct lf_layer_info *info;
    uint32_t width, height, channels; // size of the region
    void *pixels;                     // [height][width][channels], float or uint32_t; the caller's, free()
};
// Errors, logged: NG_ERROR_NOT_FOUND, NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_reference_layer(const struct lf_reference *reference, const char *name,
                                          struct lf_layer *out);
// Beauty as a display shows it, through the project's tone map at the camera's exposure: [height][width][4]
// bytes, sRGB-encoded; the caller's, free(). Errors, logged: NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_reference_display(const struct lf_reference *reference, uint8_t **rgba);

NG_EXTERN_C_END

#endif

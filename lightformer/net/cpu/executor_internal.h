// What the executor's two halves share: memory and order (executor.c), tiles (run.c).
#ifndef LF_NET_CPU_EXECUTOR_INTERNAL_H
#define LF_NET_CPU_EXECUTOR_INTERNAL_H

#include "lightformer/net/cpu/plan_internal.h"

#include "base/jobs.h"
#include "lightformer/net/memory.h"

struct lf_stored_image {
    struct lf_image image;
    void *memory;
    size_t capacity; // bytes
};

// Images of a picture's size: by slot, or by light and slot. Their borders are zero when they are laid out,
// and nobody writes there.
struct lf_image_store {
    struct lf_memory memory;
    NG_ARRAY(struct lf_stored_image) images;
    uint32_t width, height, lights; // that they are laid out for; 0: they are not
};

// What a light is while a stage runs.
struct lf_run_light {
    const struct lf_net_values *inputs;
    float *vectors;                       // its block
    const struct lf_stored_image *images; // of its encoding
};

// Of the kinds of codes; the last is that of convolutions.
#define LF_FIGURE_CONV  LF_CODE_COUNT
#define LF_FIGURE_COUNT (LF_CODE_COUNT + 1)

struct lf_figures {
    uint64_t ns[LF_FIGURE_COUNT], tiles[LF_FIGURE_COUNT], multiplications[LF_FIGURE_COUNT];
};

struct lf_worker {
    float *tile;                   // memory of a tile
    struct lf_stored_image *local; // by slot
    struct lf_figures figures[LF_STAGE_COUNT];
};

struct lf_net_executor {
    const struct lf_net *net;
    struct ng_jobs *jobs;
    const struct lf_kernel *kernel;
    struct lf_plan plan;
    void **weights; // by product
    float **biases; // by product, padded
    NG_ARRAY(struct lf_worker) workers;
    struct lf_image_store work, by_light;  // shared images of pictures, by slot; by light and slot
    NG_ARRAY(struct lf_stored_image) rows; // shared images of rows, by slot
    NG_ARRAY(struct lf_image) shared;      // by number in the plan
    NG_ARRAY(float) frame, vectors, light_biases, sums;
    NG_ARRAY(struct lf_run_light) lights;
    bool profiling;
};

// A vector of a light, or of the frame.
static inline float *lf_vector_of(const struct lf_net_executor *e, uint32_t value, uint32_t light)
{
    bool of_light = e->net->values.items[value].domain == LF_DOMAIN_LIGHT;
    return (of_light ? e->lights.items[light].vectors : e->frame.items) + e->plan.vectors.items[value];
}

struct lf_net_encoding {
    struct lf_net_executor *executor; // borrowed
    float *vectors, *own_vectors;     // the kept part of a light's block; where it is if nothing was lent
    struct lf_image_store images;     // by slot
    bool has_light, has_view;
    uint32_t width, height;
};

// A stage on its way.
struct lf_run {
    struct lf_net_executor *executor;
    const struct lf_segment *segment;
    enum lf_stage stage;
    const struct lf_net_values *pixels; // frame and pixel inputs
    uint32_t picture_width, picture_height;
    uint32_t width, height, tiles, tile; // of the segment's grid; tiles a row, the width of each
    uint32_t inner_width, inner_height;  // of the inner segment's grid
    uint32_t light_count;
    uint32_t vpl_count, texel_count; // of the light that is encoded
    float *outputs[3];
};

// Runs the segment's codes over all its tiles.
void lf_run_segment(struct lf_run *run);
uint32_t lf_level_size(uint32_t size, uint32_t level);

#endif

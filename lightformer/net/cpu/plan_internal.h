// How a program runs: three stages (a light's encoding of rows, of pictures, the gather), each a list of
// segments.
//
// A segment is a list of codes that runs over all tiles of a grid. Within a tile all values are in cache;
// what a later segment, a stage or a neighbourhood reads is stored in an image (pictures, rows) or a vector
// (of a light or the frame).
#ifndef LF_NET_CPU_PLAN_INTERNAL_H
#define LF_NET_CPU_PLAN_INTERNAL_H

#include "lightformer/net/cpu/kernel_internal.h"

enum lf_stage { LF_STAGE_LIGHT, LF_STAGE_VIEW, LF_STAGE_GATHER, LF_STAGE_COUNT };

enum lf_code_kind {
    LF_CODE_LOAD_INPUT,  // value -> out
    LF_CODE_LOAD_VECTOR, // of the lights or the frame themselves, value -> out
    LF_CODE_SPREAD,      // a vector repeated, value -> out
    LF_CODE_LOAD_IMAGE,  // image -> out, fp32 rows
    LF_CODE_LOAD_PACKED, // image -> packed
    LF_CODE_PACK,        // a list of rows -> packed
    LF_CODE_PRODUCT,     // packed or image -> out, packed
    LF_CODE_PAIRWISE,
    LF_CODE_EACH,
    LF_CODE_COPY, // a -> out
    LF_CODE_DOT,
    LF_CODE_NORMALIZE,
    LF_CODE_RESAMPLE,   // image -> out
    LF_CODE_CLEAR,      // out = 0
    LF_CODE_ADD_SCALED, // a weight -> out
    LF_CODE_ATTEND,
    LF_CODE_ATTEND_END,
    LF_CODE_STORE_IMAGE,  // a -> image
    LF_CODE_STORE_PACKED, // packed -> image
    LF_CODE_STORE_VECTOR, // a -> the lights or the frame
    LF_CODE_STORE_OUTPUT, // a -> output number `value`
    LF_CODE_REDUCE,       // a, summed over the tile's columns
    LF_CODE_COUNT
};

// Rows of the tile's memory: while planning, of a buffer; then buffer is 0.
struct lf_place {
    uint32_t buffer, row;
};
#define LF_NOWHERE ((struct lf_place){UINT32_MAX, 0})

struct lf_code {
    enum lf_code_kind kind;
    const struct lf_op *op; // that it is part of; null: loads and stores
    uint32_t value, image, product, channels, b_channels, rows;
    struct lf_place a, b, c, out, packed;
    enum lf_op_kind each;      // of LF_CODE_EACH: it may be an operation's act
    uint32_t list, list_count; // of LF_CODE_PACK, in plan->lists; of a reduction, its place in the sums
};

struct lf_constant {
    uint32_t value, column; // a vector that multiplies weights from this column on
};

struct lf_product {
    const struct lf_op *op;
    uint32_t outputs, inputs, taps, rows;
    NG_ARRAY(uint32_t) columns; // as struct lf_weights_call
    NG_ARRAY(struct lf_constant) constants;
    bool by_light;             // a constant is a light's
    uint32_t bias_at;          // in the block of biases of a light
    uint32_t weights_channels; // that a multiplication reads, for figures
};

struct lf_phase {
    uint32_t begin, lights, end; // codes [begin, lights) once, [lights, end) once a light
};

struct lf_segment {
    enum lf_net_domain domain; // of its grid: VIEW stands for both pictures
    uint32_t level, rank;
    uint32_t code_begin, code_end;
    uint32_t phase_begin, phase_end;
    uint32_t product_begin, product_end;
    uint32_t rows;                     // of tile memory
    uint32_t sums;                     // floats that a tile reduces to
    uint32_t reduce_begin, reduce_end; // in plan->reductions
    uint32_t inner; // a segment of the next finer level whose tiles run before each of this one; LF_NO_VALUE
    bool nested;    // it is such an inner one: it does not run by itself
};

struct lf_reduction {
    uint32_t value, channels, at; // where its sums begin
    bool mean;
};

// Who owns an image, and how many there are.
enum lf_image_owner {
    LF_IMAGE_SHARED,   // the executor: used again for the next light
    LF_IMAGE_ENCODING, // a light's encoding
    LF_IMAGE_LIGHT,    // the executor: one a light of the gather
    LF_IMAGE_LOCAL,    // a worker: what a tile's inner segment makes for it
    LF_IMAGE_OWNERS
};

struct lf_image_plan {
    uint32_t value, rows, slot; // slot: number among those of its owner; shared ones may have the same
    uint32_t first;             // of a shared one: the segment from which on its slot is its own
    enum lf_image_owner owner;
    bool compact; // pairs of channels (kernel_internal.h), whatever the kernel's products read
};

struct lf_plan {
    const struct lf_net *net;
    uint32_t group;
    NG_ARRAY(struct lf_segment) segments;
    uint32_t stage_begin[LF_STAGE_COUNT + 1]; // in segments
    NG_ARRAY(struct lf_phase) phases;
    NG_ARRAY(struct lf_code) codes;
    NG_ARRAY(struct lf_place) lists;
    NG_ARRAY(struct lf_product) products;
    NG_ARRAY(struct lf_reduction) reductions;
    NG_ARRAY(struct lf_image_plan) images;
    uint32_t image_counts[LF_IMAGE_OWNERS];
    NG_ARRAY(uint32_t) vectors; // by value: where its vector begins in its block; LF_NO_VALUE
    uint32_t frame_floats, light_floats, kept_floats; // of the blocks; the first kept_floats of a light are
                                                      // its encoding's
    uint32_t bias_floats, rows, sums;                 // the largest of any segment
};

NG_NODISCARD ng_result lf_plan_init(struct lf_plan *plan, const struct lf_net *net,
                                    const struct lf_kernel *kernel, bool compact);
void lf_plan_finish(struct lf_plan *plan);
// Makes those compact that are stored and loaded as a whole, but for those that stay in a core's cache.
void lf_plan_compact_images(struct lf_plan *plan);
// Gives shared images their slots; false: out of memory.
bool lf_plan_share_images(struct lf_plan *plan);

#endif

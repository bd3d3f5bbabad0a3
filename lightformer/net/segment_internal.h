// What the two halves of planning share: the stages (plan.c) and the codes of a segment (segment.c).
#ifndef LF_NET_SEGMENT_INTERNAL_H
#define LF_NET_SEGMENT_INTERNAL_H

#include "lightformer/net/plan_internal.h"

struct lf_grid {
    enum lf_net_domain domain; // VIEW: pictures of both domains
    uint32_t level;
};

// Rows of a tile's memory while they are needed: codes [first, last].
struct lf_buffer {
    uint32_t rows, first, last, offset;
};

// Where a segment has a value.
struct lf_residence {
    struct lf_place rows, packed;
};

// Where a product's operands are put together.
struct lf_panel {
    struct lf_place place;
    uint32_t product; // LF_NO_VALUE: not yet
};

enum lf_answer { LF_UNKNOWN, LF_YES, LF_NO };

struct lf_planner {
    struct lf_plan *plan;
    const struct lf_net *net;
    const struct lf_kernel *kernel;
    enum lf_stage stage;
    NG_ARRAY(bool) runs[LF_STAGE_COUNT]; // by operation
    NG_ARRAY(bool) kept;                 // by value: a later stage reads it
    NG_ARRAY(uint32_t) effort;           // by operation; of one that is made anew wherever it is read, else 0
    NG_ARRAY(uint32_t) rank, phase;      // by operation, in this stage
    NG_ARRAY(enum lf_answer) waits;      // by operation
    NG_ARRAY(bool) stored;               // by operation: something outside of its segment reads it
    NG_ARRAY(uint32_t) image;            // by value

    // Of a segment:
    struct lf_segment *segment;
    NG_ARRAY(struct lf_buffer) buffers;
    NG_ARRAY(struct lf_residence) once, light; // by value: for the tile, for the light at hand
    NG_ARRAY(struct lf_panel) panels;          // by operation
    NG_ARRAY(struct lf_code) codes[2];         // of the phase: once, a light
    NG_ARRAY(bool) wanted;                     // by operation: in the loop over lights of the phase
    bool failed;
};

bool lf_op_reduces(const struct lf_net *net, const struct lf_op *op);
// Where an operation runs: the grid of what it makes, of a reduction that of what it reads.
struct lf_grid lf_op_grid(const struct lf_net *net, const struct lf_op *op);

// Whether an operation of this stage belongs to a segment: it does not if it is made anew wherever it is
// read.
bool lf_op_has_home(const struct lf_planner *p, size_t op);

// False: out of memory.
bool lf_segment_emit(struct lf_planner *p, struct lf_segment *segment);
void lf_planner_finish_segments(struct lf_planner *p);

#endif

// What the parts of planning share: the stages (plan.c), the codes of a segment (segment.c,
// segment_product.c) and its memory (segment_memory.c).
#ifndef LF_NET_CPU_SEGMENT_INTERNAL_H
#define LF_NET_CPU_SEGMENT_INTERNAL_H

#include "lightformer/net/cpu/plan_internal.h"

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

// What runs once a tile, and what runs for each light of it.
enum lf_scope { LF_SCOPE_TILE, LF_SCOPE_LIGHT, LF_SCOPES };

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
    NG_ARRAY(struct lf_residence) once, light; // by value: of the tile, of the light at hand
    NG_ARRAY(struct lf_panel) panels;          // by operation
    NG_ARRAY(struct lf_code) codes[LF_SCOPES]; // of the phase
    NG_ARRAY(bool) wanted;                     // by operation: in the loop over lights of the phase
    bool failed;
};

static inline const struct lf_value *lf_value_at(const struct lf_planner *p, uint32_t value)
{
    return &p->net->values.items[value];
}

static inline bool lf_is_here(struct lf_place place)
{
    return place.buffer != UINT32_MAX;
}

static inline struct lf_place lf_at_row(struct lf_place place, uint32_t row)
{
    place.row += row;
    return place;
}

static inline uint32_t lf_packed_rows(const struct lf_planner *p, uint32_t channels)
{
    return (channels + p->plan->group - 1) / p->plan->group;
}

// ---- plan.c ---------------------------------------------------------------------------------------------

bool lf_op_reduces(const struct lf_net *net, const struct lf_op *op);
// Where an operation runs: the grid of what it makes, of a reduction that of what it reads.
struct lf_grid lf_op_grid(const struct lf_net *net, const struct lf_op *op);

// Whether an operation of this stage belongs to a segment: it does not if it is made anew wherever it is
// read.
bool lf_op_has_home(const struct lf_planner *p, size_t op);
bool lf_op_in_segment(const struct lf_planner *p, size_t op, const struct lf_segment *segment);

// ---- segment.c ------------------------------------------------------------------------------------------

// False: out of memory.
bool lf_segment_emit(struct lf_planner *p, struct lf_segment *segment);
void lf_planner_finish_segments(struct lf_planner *p);

// In the segment whose codes are made.
static inline bool lf_in_segment(const struct lf_planner *p, size_t op)
{
    return lf_op_in_segment(p, op, p->segment);
}
// The operation of this segment that makes a value, or null.
const struct lf_op *lf_segment_maker(const struct lf_planner *p, uint32_t value);
// The same in the whole tile: a vector of the light or of the frame.
bool lf_is_constant(const struct lf_planner *p, uint32_t value);
// Little arithmetic on inputs: made where it is read (plan.c). What an earlier stage keeps is read from
// there.
bool lf_is_made_anywhere(const struct lf_planner *p, uint32_t value);
enum lf_scope lf_scope_of(const struct lf_planner *p, uint32_t value);
struct lf_residence *lf_residence_of(struct lf_planner *p, uint32_t value);
// Says where a value's fp32 rows are. In groups of one channel they are its packed rows, too.
struct lf_place lf_set_rows(struct lf_planner *p, uint32_t value, struct lf_place rows);

// Want of memory sets p->failed, here and below.
struct lf_place lf_add_buffer(struct lf_planner *p, uint32_t rows);
struct lf_code lf_blank_code(enum lf_code_kind kind, const struct lf_op *op);
void lf_put_code(struct lf_planner *p, enum lf_scope scope, struct lf_code code);
void lf_emit_clear(struct lf_planner *p, enum lf_scope scope, struct lf_place out, uint32_t rows);
void lf_emit_copy(struct lf_planner *p, enum lf_scope scope, struct lf_place from, struct lf_place to,
                  uint32_t rows);
// Where a value's fp32 rows are; loads or makes them if they are not in the tile.
struct lf_place lf_rows_of(struct lf_planner *p, uint32_t value);

// ---- segment_product.c, segment_memory.c ----------------------------------------------------------------

void lf_emit_product(struct lf_planner *p, const struct lf_op *op);
// Gives all buffers their place. `list_begin`: the first of the plan's lists that belongs to the segment.
void lf_place_buffers(struct lf_planner *p, uint32_t list_begin);

#endif

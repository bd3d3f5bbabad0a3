// From a program to segments, stage by stage.
//
// collect: which operations a stage runs. What follows from a light belongs to its encoding, what follows
// from a gather to the gather; what is of pixels or the frame alone is cheap and runs where it is needed.
//
// effort: what follows from inputs by little arithmetic is cheaper made again than stored and read back.
//
// rank: an operation that reads a neighbourhood, or a value of another grid, runs after the segment that
// makes it. Operations of one rank and grid are a segment. One that only later segments read, and that reads
// nothing which would have to be stored for it, moves there.
//
// nest: where the next coarser level alone reads what a segment makes (pool, pack), the finer tiles run right
// before the coarser one that covers them, and what only that one reads is never stored whole.
//
// emit: codes over buffers; see segment.c.
#include "lightformer/net/cpu/segment_internal.h"

#include "base/log.h"

#include <string.h>

static const struct lf_op *op_at(const struct lf_planner *p, size_t op)
{
    return &p->net->ops.items[op];
}

bool lf_op_reduces(const struct lf_net *net, const struct lf_op *op)
{
    return op->kind == LF_OP_MEAN ||
           (op->kind == LF_OP_SUM && net->values.items[op->in[0]].domain == LF_DOMAIN_LIGHT);
}

struct lf_grid lf_op_grid(const struct lf_net *net, const struct lf_op *op)
{
    const struct lf_value *v = &net->values.items[lf_op_reduces(net, op) ? op->in[0] : op->out];
    struct lf_grid grid = {v->domain, v->level};
    if (lf_is_picture(grid.domain))
        grid.domain = LF_DOMAIN_VIEW;
    else
        grid.level = 0;
    return grid;
}

static bool same_grid(struct lf_grid a, struct lf_grid b)
{
    return a.domain == b.domain && a.level == b.level;
}

// ---- Which operations a stage runs ----------------------------------------------------------------------

// LF_STAGE_COUNT: any.
static enum lf_stage home_of(const struct lf_value *v)
{
    if (v->gather)
        return LF_STAGE_GATHER;
    if (v->domain == LF_DOMAIN_VIEW)
        return LF_STAGE_VIEW;
    return v->domain == LF_DOMAIN_PIXEL || v->domain == LF_DOMAIN_FRAME ? LF_STAGE_COUNT : LF_STAGE_LIGHT;
}

static void collect(struct lf_planner *p, enum lf_stage stage, uint32_t value)
{
    const struct lf_value *v = lf_value_at(p, value);
    enum lf_stage home = home_of(v);
    if (v->op == LF_NO_VALUE)
        return;
    if (home != LF_STAGE_COUNT && home != stage) {
        p->kept.items[value] = true;
        stage = home;
    }
    bool *there = &p->runs[stage].items[v->op];
    if (*there)
        return;
    *there = true;
    const struct lf_op *op = op_at(p, v->op);
    for (uint32_t i = 0; i < op->in_count; i++)
        collect(p, stage, op->in[i]);
}

// ---- What is made again ---------------------------------------------------------------------------------

#define LF_MOST_EFFORT 160

// Of one number; 0: more than arithmetic.
static uint32_t effort_of(enum lf_op_kind kind)
{
    switch (kind) {
    case LF_OP_LINEAR:
    case LF_OP_CONV:
    case LF_OP_MEAN:
    case LF_OP_POOL:
    case LF_OP_PACK:
    case LF_OP_UP:
    case LF_OP_UNPACK:
    case LF_OP_SUM:
    case LF_OP_ATTEND:
        return 0;
    case LF_OP_SIGMOID:
    case LF_OP_SOFTPLUS:
    case LF_OP_TANH:
    case LF_OP_EXP:
    case LF_OP_LOG:
    case LF_OP_LOG1P:
        return 12;
    default:
        return 1;
    }
}

// Of a picture's operation and all that it follows from.
static void find_efforts(struct lf_planner *p)
{
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *op = op_at(p, i);
        uint32_t effort = effort_of(op->kind) * lf_value_at(p, op->out)->channels;
        bool cheap = effort && lf_is_picture(lf_value_at(p, op->out)->domain);
        for (uint32_t k = 0; cheap && k < op->in_count; k++) {
            const struct lf_value *in = lf_value_at(p, op->in[k]);
            bool picture = lf_is_picture(in->domain) && in->op != LF_NO_VALUE;
            cheap = !picture || p->effort.items[in->op];
            effort += picture ? p->effort.items[in->op] : in->channels;
        }
        p->effort.items[i] = cheap && effort <= LF_MOST_EFFORT ? effort : 0;
    }
}

// ---- Ranks ----------------------------------------------------------------------------------------------

// The operation of this stage that makes a value, or null.
static const struct lf_op *stage_maker(const struct lf_planner *p, uint32_t value)
{
    uint32_t op = lf_value_at(p, value)->op;
    return op != LF_NO_VALUE && p->runs[p->stage].items[op] ? op_at(p, op) : NULL;
}

static uint32_t index_of(const struct lf_planner *p, const struct lf_op *op)
{
    return (uint32_t)(op - p->net->ops.items);
}

// How many segments `op` must wait after the one that makes its operand: for its neighbours, for all rows,
// for what is set to zero where there are no rows, or because it runs on another grid.
static uint32_t distance(const struct lf_planner *p, const struct lf_op *op, const struct lf_op *from)
{
    return lf_op_is_spatial(op->kind) || lf_op_reduces(p->net, from) ||
           lf_value_at(p, from->out)->rows != LF_NO_VALUE ||
           !same_grid(lf_op_grid(p->net, op), lf_op_grid(p->net, from));
}

// Whether `reader` makes what `op` makes itself.
static bool is_made_again(const struct lf_planner *p, const struct lf_op *op, const struct lf_op *reader)
{
    return p->effort.items[index_of(p, op)] > 0 && !lf_op_is_spatial(reader->kind);
}

static void rank_early(struct lf_planner *p)
{
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *op = op_at(p, i);
        p->rank.items[i] = 0;
        for (uint32_t k = 0; p->runs[p->stage].items[i] && k < op->in_count; k++) {
            const struct lf_op *from = stage_maker(p, op->in[k]);
            uint32_t rank = from ? p->rank.items[index_of(p, from)] + distance(p, op, from) : 0;
            if (rank > p->rank.items[i])
                p->rank.items[i] = rank;
        }
    }
}

// The earliest rank at which something in this stage reads what `op` makes; UINT32_MAX: nothing does.
static uint32_t first_reader(const struct lf_planner *p, const struct lf_op *op, bool *stored)
{
    uint32_t first = UINT32_MAX;
    for (size_t i = index_of(p, op) + 1; i < p->net->ops.count; i++) {
        const struct lf_op *reader = op_at(p, i);
        for (uint32_t k = 0; p->runs[p->stage].items[i] && k < reader->in_count; k++) {
            if (reader->in[k] != op->out || is_made_again(p, op, reader))
                continue;
            uint32_t rank = p->rank.items[i] - distance(p, reader, op);
            first = rank < first ? rank : first;
            *stored |= distance(p, reader, op) > 0;
        }
    }
    return first;
}

static bool may_wait(struct lf_planner *p, const struct lf_op *op, uint32_t rank);

// A question may come up along many paths; the answer of one round of questions is remembered.
static bool judge_wait(struct lf_planner *p, const struct lf_op *op, uint32_t rank)
{
    bool stored = p->kept.items[op->out];
    if (op->kind == LF_OP_POOL ||
        op->kind == LF_OP_PACK) // then their operand would wait, four times as large
        return false;
    if (lf_op_reduces(p->net, op) || lf_op_grid(p->net, op).domain != LF_DOMAIN_VIEW)
        return false;
    uint32_t first = first_reader(p, op, &stored);
    if (stored || first < rank || first == UINT32_MAX)
        return false;
    for (uint32_t k = 0; k < op->in_count; k++) {
        const struct lf_op *from = stage_maker(p, op->in[k]);
        bool lies_stored = p->kept.items[op->in[k]];
        if (!from || is_made_again(p, from, op) || !lf_is_picture(lf_value_at(p, op->in[k])->domain) ||
            lf_op_is_spatial(op->kind))
            continue;
        first_reader(p, from, &lies_stored);
        if (!lies_stored && !may_wait(p, from, rank))
            return false;
    }
    return true;
}

// Whether an operation may wait until `rank` without anything more having to be stored.
static bool may_wait(struct lf_planner *p, const struct lf_op *op, uint32_t rank)
{
    enum lf_answer *answer = &p->waits.items[index_of(p, op)];
    if (*answer == LF_UNKNOWN)
        *answer = judge_wait(p, op, rank) ? LF_YES : LF_NO;
    return *answer == LF_YES;
}

static void rank_late(struct lf_planner *p)
{
    for (size_t i = p->net->ops.count; i-- > 0;) {
        const struct lf_op *op = op_at(p, i);
        bool stored = false;
        if (!p->runs[p->stage].items[i])
            continue;
        memset(p->waits.items, 0, p->waits.count * sizeof *p->waits.items);
        uint32_t rank = first_reader(p, op, &stored);
        if (rank != UINT32_MAX && rank > p->rank.items[i] && may_wait(p, op, rank))
            p->rank.items[i] = rank;
    }
}

// ---- What is stored -------------------------------------------------------------------------------------

static bool read_elsewhere(const struct lf_planner *p, const struct lf_op *op)
{
    uint32_t rank = p->rank.items[index_of(p, op)];
    for (size_t i = index_of(p, op) + 1; i < p->net->ops.count; i++) {
        const struct lf_op *reader = op_at(p, i);
        for (uint32_t k = 0; p->runs[p->stage].items[i] && k < reader->in_count; k++)
            if (reader->in[k] == op->out && !is_made_again(p, op, reader) &&
                (p->rank.items[i] != rank || distance(p, reader, op)))
                return true;
    }
    return p->kept.items[op->out];
}

static bool add_image(struct lf_planner *p, uint32_t value)
{
    const struct lf_value *v = lf_value_at(p, value);
    enum lf_image_owner owner = p->stage == LF_STAGE_VIEW && p->kept.items[value] ? LF_IMAGE_ENCODING
                                : p->stage == LF_STAGE_GATHER && v->domain == LF_DOMAIN_VIEW
                                    ? LF_IMAGE_LIGHT
                                    : LF_IMAGE_SHARED;
    struct lf_image_plan image = {.value = value,
                                  .rows = p->kernel->pad_rows(lf_packed_rows(p, v->channels)),
                                  .slot = p->plan->image_counts[owner]++,
                                  .owner = owner};
    p->image.items[value] = (uint32_t)p->plan->images.count;
    return ng_array_push(&p->plan->images, image);
}

// Images of earlier stages stay known: of those, only the encoding's are read again.
static bool find_stored(struct lf_planner *p)
{
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *op = op_at(p, i);
        if (!p->runs[p->stage].items[i])
            continue;
        p->stored.items[i] = read_elsewhere(p, op) && !lf_op_reduces(p->net, op);
        enum lf_net_domain domain = lf_value_at(p, op->out)->domain;
        bool vector = domain == LF_DOMAIN_FRAME || domain == LF_DOMAIN_LIGHT;
        if (p->stored.items[i] && !vector && !add_image(p, op->out))
            return false;
    }
    return true;
}

static bool place_vectors(struct lf_planner *p)
{
    struct lf_plan *plan = p->plan;
    if (!ng_array_resize(&plan->vectors, p->net->values.count))
        return false;
    for (int gather = 0; gather < 2; gather++) {
        for (size_t i = 0; i < p->net->values.count; i++) {
            const struct lf_value *v = &p->net->values.items[i];
            if (v->domain == LF_DOMAIN_FRAME && !gather) {
                plan->vectors.items[i] = plan->frame_floats;
                plan->frame_floats += v->channels;
            } else if (v->domain == LF_DOMAIN_LIGHT && v->gather == (gather != 0)) {
                plan->vectors.items[i] = plan->light_floats;
                plan->light_floats += v->channels;
            } else if (!gather) {
                plan->vectors.items[i] = LF_NO_VALUE;
            }
        }
        if (!gather)
            plan->kept_floats = plan->light_floats;
    }
    return true;
}

// ---- Segments -------------------------------------------------------------------------------------------

bool lf_op_has_home(const struct lf_planner *p, size_t op)
{
    bool output = false;
    for (uint32_t i = 0; p->stage == LF_STAGE_GATHER && i < NG_COUNT(p->net->outputs); i++)
        output |= p->net->outputs[i] == p->net->ops.items[op].out;
    return p->runs[p->stage].items[op] && (!p->effort.items[op] || p->stored.items[op] || output);
}

bool lf_op_in_segment(const struct lf_planner *p, size_t op, const struct lf_segment *s)
{
    struct lf_grid grid = lf_op_grid(p->net, op_at(p, op));
    return lf_op_has_home(p, op) && p->rank.items[op] == s->rank && grid.domain == s->domain &&
           grid.level == s->level;
}

static bool add_segments(struct lf_planner *p)
{
    struct lf_plan *plan = p->plan;
    size_t begin = plan->segments.count;
    for (size_t i = 0; i < p->net->ops.count; i++) {
        if (!lf_op_has_home(p, i))
            continue;
        struct lf_grid grid = lf_op_grid(p->net, op_at(p, i));
        struct lf_segment segment = {
            .domain = grid.domain, .level = grid.level, .rank = p->rank.items[i], .inner = LF_NO_VALUE};
        size_t at = begin;
        while (at < plan->segments.count && (plan->segments.items[at].rank != segment.rank ||
                                             plan->segments.items[at].domain != segment.domain ||
                                             plan->segments.items[at].level != segment.level))
            at++;
        if (at == plan->segments.count && !ng_array_push(&plan->segments, segment))
            return false;
    }
    // By rank; few.
    for (size_t i = begin; i < plan->segments.count; i++)
        for (size_t k = i; k > begin && plan->segments.items[k].rank < plan->segments.items[k - 1].rank;
             k--) {
            struct lf_segment swap = plan->segments.items[k];
            plan->segments.items[k] = plan->segments.items[k - 1];
            plan->segments.items[k - 1] = swap;
        }
    return true;
}

// ---- Segments within segments ---------------------------------------------------------------------------

static bool reads(const struct lf_op *op, uint32_t value)
{
    for (uint32_t i = 0; i < op->in_count; i++)
        if (op->in[i] == value)
            return true;
    return false;
}

// What reads a value of `inner` outside of it: whether `outer` does, whether anything else does before or
// after it.
struct readers {
    bool outer, before, after;
};

static struct readers find_readers(const struct lf_planner *p, const struct lf_op *op,
                                   const struct lf_segment *inner, const struct lf_segment *outer)
{
    struct readers r = {.after = p->kept.items[op->out]};
    for (size_t i = index_of(p, op) + 1; i < p->net->ops.count; i++) {
        if (!lf_op_has_home(p, i) || !reads(op_at(p, i), op->out) || lf_op_in_segment(p, i, inner) ||
            is_made_again(p, op, op_at(p, i)))
            continue;
        r.outer |= lf_op_in_segment(p, i, outer);
        r.before |= !lf_op_in_segment(p, i, outer) && p->rank.items[i] <= outer->rank;
        r.after |= p->rank.items[i] > outer->rank;
    }
    return r;
}

// A tile of the coarser level covers the pixels that its pools and packs read, and no others.
static bool may_nest(const struct lf_planner *p, const struct lf_segment *inner,
                     const struct lf_segment *outer)
{
    bool any = false;
    if (inner->domain != LF_DOMAIN_VIEW || outer->domain != LF_DOMAIN_VIEW ||
        outer->level != inner->level + 1 || inner->inner != LF_NO_VALUE || inner->nested || outer->nested ||
        outer->inner != LF_NO_VALUE)
        return false;
    for (size_t i = 0; i < p->net->ops.count; i++) {
        if (!lf_op_in_segment(p, i, inner))
            continue;
        struct readers r = find_readers(p, op_at(p, i), inner, outer);
        if (r.before)
            return false;
        any |= r.outer;
    }
    return any;
}

static void make_local(struct lf_planner *p, const struct lf_segment *inner, const struct lf_segment *outer)
{
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *op = op_at(p, i);
        if (!lf_op_in_segment(p, i, inner) || p->image.items[op->out] == LF_NO_VALUE || !p->stored.items[i])
            continue;
        struct lf_image_plan *image = &p->plan->images.items[p->image.items[op->out]];
        if (image->owner != LF_IMAGE_SHARED || find_readers(p, op, inner, outer).after)
            continue;
        image->owner = LF_IMAGE_LOCAL;
        image->slot = p->plan->image_counts[LF_IMAGE_LOCAL]++;
    }
}

static void nest_segments(struct lf_planner *p)
{
    struct lf_plan *plan = p->plan;
    for (uint32_t i = plan->stage_begin[p->stage]; i < plan->segments.count; i++)
        for (uint32_t k = i + 1; k < plan->segments.count; k++) {
            struct lf_segment *inner = &plan->segments.items[i], *outer = &plan->segments.items[k];
            if (!may_nest(p, inner, outer))
                continue;
            outer->inner = i;
            inner->nested = true;
            make_local(p, inner, outer);
        }
}

// ---- The whole ------------------------------------------------------------------------------------------

static bool plan_stage(struct lf_planner *p, enum lf_stage stage)
{
    struct lf_plan *plan = p->plan;
    p->stage = stage;
    plan->stage_begin[stage] = (uint32_t)plan->segments.count;
    rank_early(p);
    rank_late(p);
    if (!find_stored(p) || !add_segments(p))
        return false;
    nest_segments(p);
    for (size_t i = plan->stage_begin[stage]; i < plan->segments.count; i++)
        if (!lf_segment_emit(p, &plan->segments.items[i]))
            return false;
    plan->stage_begin[stage + 1] = (uint32_t)plan->segments.count;
    return true;
}

static bool prepare(struct lf_planner *p)
{
    size_t values = p->net->values.count, ops = p->net->ops.count;
    for (uint32_t i = 0; i < LF_STAGE_COUNT; i++)
        if (!ng_array_resize(&p->runs[i], ops + 1))
            return false;
    if (!ng_array_resize(&p->kept, values) || !ng_array_resize(&p->rank, ops + 1) ||
        !ng_array_resize(&p->effort, ops + 1) || !ng_array_resize(&p->phase, ops + 1) ||
        !ng_array_resize(&p->stored, ops + 1) || !ng_array_resize(&p->waits, ops + 1) ||
        !ng_array_resize(&p->image, values) || !place_vectors(p))
        return false;
    for (size_t i = 0; i < values; i++)
        p->image.items[i] = LF_NO_VALUE;
    find_efforts(p);
    for (uint32_t i = 0; i < NG_COUNT(p->net->outputs); i++)
        collect(p, LF_STAGE_GATHER, p->net->outputs[i]);
    return true;
}

static void finish(struct lf_planner *p)
{
    for (uint32_t i = 0; i < LF_STAGE_COUNT; i++)
        ng_array_finish(&p->runs[i]);
    ng_array_finish(&p->kept);
    ng_array_finish(&p->effort);
    ng_array_finish(&p->rank);
    ng_array_finish(&p->phase);
    ng_array_finish(&p->stored);
    ng_array_finish(&p->waits);
    ng_array_finish(&p->image);
    lf_planner_finish_segments(p);
}

ng_result lf_plan_init(struct lf_plan *plan, const struct lf_net *net, const struct lf_kernel *kernel,
                       bool compact)
{
    struct lf_planner planner = {.plan = plan, .net = net, .kernel = kernel};
    *plan = (struct lf_plan){.net = net, .group = kernel->group};
    bool ok = prepare(&planner);
    for (uint32_t i = 0; ok && i < LF_STAGE_COUNT; i++)
        ok = plan_stage(&planner, (enum lf_stage)i);
    if (ok && compact)
        lf_plan_compact_images(plan);
    ok = ok && lf_plan_share_images(plan);
    finish(&planner);
    if (ok)
        return NG_OK;
    lf_plan_finish(plan);
    return ng_out_of_memory("the plan of a network");
}

void lf_plan_finish(struct lf_plan *plan)
{
    for (size_t i = 0; i < plan->products.count; i++) {
        ng_array_finish(&plan->products.items[i].columns);
        ng_array_finish(&plan->products.items[i].constants);
    }
    ng_array_finish(&plan->segments);
    ng_array_finish(&plan->phases);
    ng_array_finish(&plan->codes);
    ng_array_finish(&plan->lists);
    ng_array_finish(&plan->products);
    ng_array_finish(&plan->reductions);
    ng_array_finish(&plan->images);
    ng_array_finish(&plan->vectors);
    *plan = (struct lf_plan){0};
}

// The codes of a segment. Values appear where they are first needed, as fp32 rows, packed, or both; buffers
// get their place in the tile's memory last, when it is known how long each lives.
//
// In the gather a tile works in phases: what is of pixels once, then, light by light, what its sums over
// lights need; a sum is finished by the next phase. What a light needs in two phases is computed in both:
// tiles keep nothing by light.
#include "lightformer/net/cpu/segment_internal.h"

#include <assert.h>
#include <string.h>

// ---- Where things belong --------------------------------------------------------------------------------

const struct lf_op *lf_segment_maker(const struct lf_planner *p, uint32_t value)
{
    uint32_t op = lf_value_at(p, value)->op;
    if (op == LF_NO_VALUE || !lf_in_segment(p, op) || lf_op_reduces(p->net, &p->net->ops.items[op]))
        return NULL;
    return &p->net->ops.items[op];
}

bool lf_is_constant(const struct lf_planner *p, uint32_t value)
{
    enum lf_net_domain domain = lf_value_at(p, value)->domain;
    return (domain == LF_DOMAIN_FRAME || domain == LF_DOMAIN_LIGHT) && domain != p->segment->domain;
}

bool lf_is_made_anywhere(const struct lf_planner *p, uint32_t value)
{
    uint32_t op = lf_value_at(p, value)->op;
    return op != LF_NO_VALUE && p->runs[p->stage].items[op] && p->effort.items[op];
}

enum lf_scope lf_scope_of(const struct lf_planner *p, uint32_t value)
{
    enum lf_net_domain domain = lf_value_at(p, value)->domain;
    return p->stage == LF_STAGE_GATHER && p->segment->domain == LF_DOMAIN_VIEW &&
                   (domain == LF_DOMAIN_VIEW || domain == LF_DOMAIN_LIGHT)
               ? LF_SCOPE_LIGHT
               : LF_SCOPE_TILE;
}

static bool gathers(const struct lf_planner *p, const struct lf_op *op)
{
    return op->kind == LF_OP_ATTEND || (op->kind == LF_OP_SUM && !lf_op_reduces(p->net, op));
}

struct lf_residence *lf_residence_of(struct lf_planner *p, uint32_t value)
{
    return lf_scope_of(p, value) == LF_SCOPE_LIGHT ? &p->light.items[value] : &p->once.items[value];
}

struct lf_place lf_set_rows(struct lf_planner *p, uint32_t value, struct lf_place rows)
{
    struct lf_residence *r = lf_residence_of(p, value);
    r->rows = rows;
    if (p->plan->group == 1)
        r->packed = rows;
    return rows;
}

// ---- Buffers and codes ----------------------------------------------------------------------------------

struct lf_place lf_add_buffer(struct lf_planner *p, uint32_t rows)
{
    struct lf_buffer buffer = {.rows = rows, .first = UINT32_MAX};
    if (!ng_array_push(&p->buffers, buffer))
        p->failed = true;
    return (struct lf_place){(uint32_t)p->buffers.count - 1, 0};
}

struct lf_code lf_blank_code(enum lf_code_kind kind, const struct lf_op *op)
{
    return (struct lf_code){.kind = kind,
                            .op = op,
                            .value = LF_NO_VALUE,
                            .image = LF_NO_VALUE,
                            .product = LF_NO_VALUE,
                            .a = LF_NOWHERE,
                            .b = LF_NOWHERE,
                            .c = LF_NOWHERE,
                            .out = LF_NOWHERE,
                            .packed = LF_NOWHERE,
                            .each = LF_OP_COUNT};
}

void lf_put_code(struct lf_planner *p, enum lf_scope scope, struct lf_code code)
{
    if (!ng_array_push(&p->codes[scope], code))
        p->failed = true;
}

void lf_emit_clear(struct lf_planner *p, enum lf_scope scope, struct lf_place out, uint32_t rows)
{
    struct lf_code code = lf_blank_code(LF_CODE_CLEAR, NULL);
    code.out = out;
    code.rows = rows;
    if (rows)
        lf_put_code(p, scope, code);
}

void lf_emit_copy(struct lf_planner *p, enum lf_scope scope, struct lf_place from, struct lf_place to,
                  uint32_t rows)
{
    struct lf_code code = lf_blank_code(LF_CODE_COPY, NULL);
    assert(lf_is_here(from) && lf_is_here(to));
    code.a = from;
    code.out = to;
    code.rows = rows;
    lf_put_code(p, scope, code);
}

// ---- Values as fp32 rows --------------------------------------------------------------------------------

static void load(struct lf_planner *p, uint32_t value, struct lf_place out)
{
    const struct lf_value *v = lf_value_at(p, value);
    bool vector = v->domain == LF_DOMAIN_FRAME || v->domain == LF_DOMAIN_LIGHT;
    struct lf_code code = lf_blank_code(lf_is_constant(p, value) ? LF_CODE_SPREAD
                                        : vector                 ? LF_CODE_LOAD_VECTOR
                                        : v->op == LF_NO_VALUE   ? LF_CODE_LOAD_INPUT
                                                                 : LF_CODE_LOAD_IMAGE,
                                        NULL);
    code.value = value;
    code.channels = v->channels;
    code.out = out;
    if (code.kind == LF_CODE_LOAD_IMAGE)
        code.image = p->image.items[value];
    lf_put_code(p, lf_scope_of(p, value), code);
}

static void emit_op(struct lf_planner *p, const struct lf_op *op);

struct lf_place lf_rows_of(struct lf_planner *p, uint32_t value)
{
    struct lf_residence *r = lf_residence_of(p, value);
    uint32_t op = lf_value_at(p, value)->op;
    if (!lf_is_here(r->rows) && lf_is_made_anywhere(p, value)) {
        emit_op(p, &p->net->ops.items[op]);
    } else if (!lf_is_here(r->rows)) {
        load(p, value, lf_set_rows(p, value, lf_add_buffer(p, lf_value_at(p, value)->channels)));
    }
    return r->rows;
}

// ---- Other operations -----------------------------------------------------------------------------------

static void emit_concat(struct lf_planner *p, const struct lf_op *op)
{
    uint32_t row = 0;
    if (op->in_count == 1 && lf_scope_of(p, op->in[0]) == lf_scope_of(p, op->out)) {
        lf_set_rows(p, op->out, lf_rows_of(p, op->in[0]));
        return;
    }
    struct lf_place out = lf_set_rows(p, op->out, lf_add_buffer(p, lf_value_at(p, op->out)->channels));
    for (uint32_t i = 0; i < op->in_count; i++) {
        uint32_t channels = lf_value_at(p, op->in[i])->channels;
        lf_emit_copy(p, lf_scope_of(p, op->out), lf_rows_of(p, op->in[i]), lf_at_row(out, row), channels);
        row += channels;
    }
}

static void emit_rows(struct lf_planner *p, const struct lf_op *op, enum lf_code_kind kind)
{
    struct lf_code code = lf_blank_code(kind, op);
    if (kind == LF_CODE_RESAMPLE) {
        code.image = p->image.items[op->in[0]];
        code.value = op->in[0];
    } else {
        code.a = lf_rows_of(p, op->in[0]);
        code.channels = lf_value_at(p, op->in[0])->channels;
    }
    if (op->in_count == 2) {
        code.b = lf_rows_of(p, op->in[1]);
        code.b_channels = lf_value_at(p, op->in[1])->channels;
    }
    code.each = op->kind;
    code.out = lf_set_rows(p, op->out, lf_add_buffer(p, lf_value_at(p, op->out)->channels));
    lf_put_code(p, lf_scope_of(p, op->out), code);
}

static void emit_reduce(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_segment *s = p->segment;
    struct lf_code code = lf_blank_code(LF_CODE_REDUCE, op);
    uint32_t channels = lf_value_at(p, op->in[0])->channels;
    code.a = lf_rows_of(p, op->in[0]);
    if (op->in_count == 2) {
        struct lf_code weighted = lf_blank_code(LF_CODE_PAIRWISE, op);
        weighted.each = LF_OP_MUL;
        weighted.a = code.a;
        weighted.b = lf_rows_of(p, op->in[1]);
        weighted.channels = channels;
        weighted.b_channels = 1;
        weighted.out = code.a = lf_add_buffer(p, channels);
        lf_put_code(p, LF_SCOPE_TILE, weighted);
    }
    code.channels = channels;
    code.list = s->sums;
    lf_put_code(p, LF_SCOPE_TILE, code);
    if (!ng_array_push(&p->plan->reductions,
                       (struct lf_reduction){op->out, channels, s->sums, op->kind == LF_OP_MEAN}))
        p->failed = true;
    s->sums += channels;
}

// A sum over lights: zeros before the loop, each light's part in it.
static void emit_sum(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_code code = lf_blank_code(LF_CODE_ADD_SCALED, op);
    uint32_t channels = lf_value_at(p, op->out)->channels;
    code.out = lf_set_rows(p, op->out, lf_add_buffer(p, channels));
    lf_emit_clear(p, LF_SCOPE_TILE, code.out, channels);
    code.a = lf_rows_of(p, op->in[0]);
    code.channels = channels;
    code.value = op->in_count == 2 ? op->in[1] : LF_NO_VALUE;
    lf_put_code(p, LF_SCOPE_LIGHT, code);
}

static struct lf_place vector_or_rows(struct lf_planner *p, uint32_t value)
{
    return lf_value_at(p, value)->domain == LF_DOMAIN_LIGHT ? LF_NOWHERE : lf_rows_of(p, value);
}

static void emit_attend(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_code code = lf_blank_code(LF_CODE_ATTEND, op);
    uint32_t channels = lf_value_at(p, op->out)->channels, state = op->softmax ? 2 * op->heads : 0;
    code.out = lf_set_rows(p, op->out, lf_add_buffer(p, channels));
    lf_emit_clear(p, LF_SCOPE_TILE, code.out, channels);
    if (state) {
        code.packed = lf_add_buffer(p, state);
        lf_emit_clear(p, LF_SCOPE_TILE, code.packed, state);
    }
    code.a = lf_rows_of(p, op->in[0]);
    code.b = vector_or_rows(p, op->in[1]);
    code.c = vector_or_rows(p, op->in[2]);
    code.value = op->in_count == 4 ? op->in[3] : LF_NO_VALUE;
    code.channels = channels;
    lf_put_code(p, LF_SCOPE_LIGHT, code);
}

static void emit_attend_end(struct lf_planner *p, const struct lf_op *op)
{
    for (size_t i = 0; op->softmax && i < p->plan->codes.count; i++) {
        struct lf_code code = p->plan->codes.items[i];
        if (i < p->segment->code_begin || code.kind != LF_CODE_ATTEND || code.op != op)
            continue;
        code.kind = LF_CODE_ATTEND_END;
        code.a = code.b = code.c = LF_NOWHERE;
        lf_put_code(p, LF_SCOPE_TILE, code);
    }
}

static void emit_stores(struct lf_planner *p, const struct lf_op *op)
{
    size_t index = (size_t)(op - p->net->ops.items);
    enum lf_scope scope = lf_scope_of(p, op->out);
    struct lf_code code = lf_blank_code(LF_CODE_STORE_OUTPUT, NULL);
    code.channels = lf_value_at(p, op->out)->channels;
    for (uint32_t i = 0; p->stage == LF_STAGE_GATHER && i < NG_COUNT(p->net->outputs); i++) {
        if (p->net->outputs[i] != op->out || !lf_in_segment(p, index))
            continue;
        code.value = i;
        code.a = lf_rows_of(p, op->out);
        lf_put_code(p, scope, code);
    }
    if (!p->stored.items[index] || !lf_in_segment(p, index))
        return;
    enum lf_net_domain domain = lf_value_at(p, op->out)->domain;
    code.value = op->out;
    if (domain == LF_DOMAIN_FRAME || domain == LF_DOMAIN_LIGHT) {
        code.kind = LF_CODE_STORE_VECTOR;
        code.a = lf_rows_of(p, op->out);
    } else {
        struct lf_residence *r = lf_residence_of(p, op->out);
        bool packed = lf_is_here(r->packed);
        code.kind = packed ? LF_CODE_STORE_PACKED : LF_CODE_STORE_IMAGE;
        code.image = p->image.items[op->out];
        code.a = packed ? LF_NOWHERE : lf_rows_of(p, op->out);
        code.packed = r->packed;
        code.rows = lf_packed_rows(p, code.channels);
    }
    lf_put_code(p, scope, code);
}

static void emit_op(struct lf_planner *p, const struct lf_op *op)
{
    if (lf_op_reduces(p->net, op)) {
        emit_reduce(p, op);
        return;
    }
    switch (op->kind) {
    case LF_OP_LINEAR:
    case LF_OP_CONV:
        lf_emit_product(p, op);
        break;
    case LF_OP_CONCAT:
        emit_concat(p, op);
        break;
    case LF_OP_SLICE:
        lf_set_rows(p, op->out, lf_at_row(lf_rows_of(p, op->in[0]), op->from));
        break;
    case LF_OP_DOT:
    case LF_OP_LENGTH:
        emit_rows(p, op, LF_CODE_DOT);
        break;
    case LF_OP_NORMALIZE:
        emit_rows(p, op, LF_CODE_NORMALIZE);
        break;
    case LF_OP_POOL:
    case LF_OP_PACK:
    case LF_OP_UP:
    case LF_OP_UNPACK:
        emit_rows(p, op, LF_CODE_RESAMPLE);
        break;
    case LF_OP_SUM:
        emit_sum(p, op);
        return;
    case LF_OP_ATTEND:
        emit_attend(p, op);
        return;
    default:
        emit_rows(p, op, op->in_count == 2 ? LF_CODE_PAIRWISE : LF_CODE_EACH);
        break;
    }
    emit_stores(p, op);
}

// ---- Phases ---------------------------------------------------------------------------------------------

// The phase in which an operation's result is there.
static uint32_t find_phases(struct lf_planner *p)
{
    uint32_t most = 0;
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *op = &p->net->ops.items[i];
        if (!lf_in_segment(p, i))
            continue;
        p->phase.items[i] = 0;
        for (uint32_t k = 0; k < op->in_count; k++) {
            const struct lf_op *from = lf_segment_maker(p, op->in[k]);
            uint32_t phase = from ? p->phase.items[from - p->net->ops.items] : 0;
            if (phase > p->phase.items[i])
                p->phase.items[i] = phase;
        }
        p->phase.items[i] += gathers(p, op);
        most = p->phase.items[i] > most ? p->phase.items[i] : most;
    }
    return most;
}

// What the loop over lights of a phase runs: sums, stored pictures, and what those follow from.
static void find_wanted(struct lf_planner *p, uint32_t phase)
{
    for (size_t i = p->net->ops.count; i-- > 0;) {
        const struct lf_op *op = &p->net->ops.items[i];
        bool root =
            lf_in_segment(p, i) &&
            ((gathers(p, op) && p->phase.items[i] == phase + 1) ||
             (lf_scope_of(p, op->out) == LF_SCOPE_LIGHT && p->stored.items[i] && p->phase.items[i] == phase));
        p->wanted.items[i] |= root;
        for (uint32_t k = 0; p->wanted.items[i] && k < op->in_count; k++) {
            const struct lf_op *from = lf_segment_maker(p, op->in[k]);
            if (from && lf_scope_of(p, op->in[k]) == LF_SCOPE_LIGHT)
                p->wanted.items[from - p->net->ops.items] = true;
        }
    }
}

static void forget_light(struct lf_planner *p)
{
    for (size_t i = 0; i < p->light.count; i++)
        p->light.items[i] = (struct lf_residence){LF_NOWHERE, LF_NOWHERE};
    for (size_t i = 0; i < p->panels.count; i++)
        if (lf_scope_of(p, p->net->ops.items[i].out) == LF_SCOPE_LIGHT)
            p->panels.items[i].product = LF_NO_VALUE;
    memset(p->wanted.items, 0, p->wanted.count * sizeof *p->wanted.items);
}

static bool append(struct lf_planner *p, enum lf_scope scope)
{
    for (size_t i = 0; i < p->codes[scope].count; i++)
        if (!ng_array_push(&p->plan->codes, p->codes[scope].items[i]))
            return false;
    p->codes[scope].count = 0;
    return true;
}

static bool emit_phase(struct lf_planner *p, uint32_t phase)
{
    struct lf_phase range = {.begin = (uint32_t)p->plan->codes.count};
    forget_light(p);
    find_wanted(p, phase);
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *op = &p->net->ops.items[i];
        if (!lf_in_segment(p, i) || lf_scope_of(p, op->out) != LF_SCOPE_TILE || p->phase.items[i] != phase)
            continue;
        if (lf_is_made_anywhere(p, op->out) && lf_is_here(lf_residence_of(p, op->out)->rows))
            continue; // on demand, before
        if (gathers(p, op)) {
            emit_attend_end(p, op);
            emit_stores(p, op);
        } else {
            emit_op(p, op);
        }
    }
    for (size_t i = 0; i < p->net->ops.count; i++) {
        uint32_t out = p->net->ops.items[i].out;
        if (p->wanted.items[i] && !(lf_is_made_anywhere(p, out) && lf_is_here(lf_residence_of(p, out)->rows)))
            emit_op(p, &p->net->ops.items[i]);
    }
    if (!append(p, LF_SCOPE_TILE))
        return false;
    range.lights = (uint32_t)p->plan->codes.count;
    if (!append(p, LF_SCOPE_LIGHT))
        return false;
    range.end = (uint32_t)p->plan->codes.count;
    return ng_array_push(&p->plan->phases, range);
}

// ---- The whole ------------------------------------------------------------------------------------------

static bool prepare(struct lf_planner *p)
{
    size_t values = p->net->values.count, ops = p->net->ops.count;
    p->buffers.count = p->codes[LF_SCOPE_TILE].count = p->codes[LF_SCOPE_LIGHT].count = 0;
    if (!ng_array_resize(&p->once, values) || !ng_array_resize(&p->light, values) ||
        !ng_array_resize(&p->panels, ops) || !ng_array_resize(&p->wanted, ops + 1))
        return false;
    for (size_t i = 0; i < values; i++)
        p->once.items[i] = (struct lf_residence){LF_NOWHERE, LF_NOWHERE};
    for (size_t i = 0; i < ops; i++)
        p->panels.items[i] = (struct lf_panel){LF_NOWHERE, LF_NO_VALUE};
    return true;
}

bool lf_segment_emit(struct lf_planner *p, struct lf_segment *segment)
{
    struct lf_plan *plan = p->plan;
    p->segment = segment;
    if (!prepare(p))
        return false;
    segment->code_begin = (uint32_t)plan->codes.count;
    segment->phase_begin = (uint32_t)plan->phases.count;
    segment->product_begin = (uint32_t)plan->products.count;
    segment->reduce_begin = (uint32_t)plan->reductions.count;
    uint32_t list_begin = (uint32_t)plan->lists.count, last = find_phases(p);
    for (uint32_t phase = 0; phase <= last; phase++)
        if (!emit_phase(p, phase))
            return false;
    if (p->failed)
        return false;
    lf_place_buffers(p, list_begin);
    segment->code_end = (uint32_t)plan->codes.count;
    segment->phase_end = (uint32_t)plan->phases.count;
    segment->product_end = (uint32_t)plan->products.count;
    segment->reduce_end = (uint32_t)plan->reductions.count;
    plan->rows = segment->rows > plan->rows ? segment->rows : plan->rows;
    plan->sums = segment->sums > plan->sums ? segment->sums : plan->sums;
    return true;
}

void lf_planner_finish_segments(struct lf_planner *p)
{
    ng_array_finish(&p->buffers);
    ng_array_finish(&p->once);
    ng_array_finish(&p->light);
    ng_array_finish(&p->panels);
    for (int i = 0; i < LF_SCOPES; i++)
        ng_array_finish(&p->codes[i]);
    ng_array_finish(&p->wanted);
}

// The codes of a segment. Values appear where they are first needed, as fp32 rows, packed, or both; buffers
// get their place in the tile's memory last, when it is known how long each lives.
//
// In the gather a tile works in phases: what is of pixels once, then, light by light, what its sums over
// lights need; a sum is finished by the next phase. What a light needs in two phases is computed in both:
// tiles keep nothing by light.
#include "lightformer/net/segment_internal.h"

#include <assert.h>
#include <string.h>

#define IN_ONCE   0
#define IN_LIGHTS 1

static const struct lf_value *value_at(const struct lf_planner *p, uint32_t value)
{
    return &p->net->values.items[value];
}

static bool is_here(struct lf_place place)
{
    return place.buffer != UINT32_MAX;
}

static struct lf_place at_row(struct lf_place place, uint32_t row)
{
    place.row += row;
    return place;
}

static bool same_place(struct lf_place a, struct lf_place b)
{
    return a.buffer == b.buffer && a.row == b.row;
}

// ---- Where things belong --------------------------------------------------------------------------------

static bool in_segment(const struct lf_planner *p, size_t op)
{
    struct lf_grid grid = lf_op_grid(p->net, &p->net->ops.items[op]);
    return lf_op_has_home(p, op) && p->rank.items[op] == p->segment->rank &&
           grid.domain == p->segment->domain && grid.level == p->segment->level;
}

// The operation of this segment that makes a value, or null.
static const struct lf_op *maker(const struct lf_planner *p, uint32_t value)
{
    uint32_t op = value_at(p, value)->op;
    if (op == LF_NO_VALUE || !in_segment(p, op) || lf_op_reduces(p->net, &p->net->ops.items[op]))
        return NULL;
    return &p->net->ops.items[op];
}

// The same in the whole tile: a vector of the light or of the frame.
static bool is_constant(const struct lf_planner *p, uint32_t value)
{
    enum lf_net_domain domain = value_at(p, value)->domain;
    return (domain == LF_DOMAIN_FRAME || domain == LF_DOMAIN_LIGHT) && domain != p->segment->domain;
}

// Little arithmetic on inputs: made where it is read (plan.c). What an earlier stage keeps is read from
// there.
static bool is_made_anywhere(const struct lf_planner *p, uint32_t value)
{
    uint32_t op = value_at(p, value)->op;
    return op != LF_NO_VALUE && p->runs[p->stage].items[op] && p->effort.items[op];
}

static int scope_of(const struct lf_planner *p, uint32_t value)
{
    enum lf_net_domain domain = value_at(p, value)->domain;
    return p->stage == LF_STAGE_GATHER && p->segment->domain == LF_DOMAIN_VIEW &&
                   (domain == LF_DOMAIN_VIEW || domain == LF_DOMAIN_LIGHT)
               ? IN_LIGHTS
               : IN_ONCE;
}

static bool gathers(const struct lf_planner *p, const struct lf_op *op)
{
    return op->kind == LF_OP_ATTEND || (op->kind == LF_OP_SUM && !lf_op_reduces(p->net, op));
}

static struct lf_residence *residence(struct lf_planner *p, uint32_t value)
{
    return scope_of(p, value) == IN_LIGHTS ? &p->light.items[value] : &p->once.items[value];
}

// ---- Buffers and codes ----------------------------------------------------------------------------------

static struct lf_place add_buffer(struct lf_planner *p, uint32_t rows)
{
    struct lf_buffer buffer = {.rows = rows, .first = UINT32_MAX};
    if (!ng_array_push(&p->buffers, buffer))
        p->failed = true;
    return (struct lf_place){(uint32_t)p->buffers.count - 1, 0};
}

static struct lf_code blank(enum lf_code_kind kind, const struct lf_op *op)
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

static void put(struct lf_planner *p, int scope, struct lf_code code)
{
    if (!ng_array_push(&p->codes[scope], code))
        p->failed = true;
}

static uint32_t packed_rows(const struct lf_planner *p, uint32_t channels)
{
    return (channels + p->plan->group - 1) / p->plan->group;
}

static void clear(struct lf_planner *p, int scope, struct lf_place out, uint32_t rows)
{
    struct lf_code code = blank(LF_CODE_CLEAR, NULL);
    code.out = out;
    code.rows = rows;
    if (rows)
        put(p, scope, code);
}

static void copy(struct lf_planner *p, int scope, struct lf_place from, struct lf_place to, uint32_t rows)
{
    struct lf_code code = blank(LF_CODE_COPY, NULL);
    assert(is_here(from) && is_here(to));
    code.a = from;
    code.out = to;
    code.rows = rows;
    put(p, scope, code);
}

// ---- Values as fp32 rows --------------------------------------------------------------------------------

static void load(struct lf_planner *p, uint32_t value, struct lf_place out)
{
    const struct lf_value *v = value_at(p, value);
    bool vector = v->domain == LF_DOMAIN_FRAME || v->domain == LF_DOMAIN_LIGHT;
    struct lf_code code = blank(is_constant(p, value)  ? LF_CODE_SPREAD
                                : vector               ? LF_CODE_LOAD_VECTOR
                                : v->op == LF_NO_VALUE ? LF_CODE_LOAD_INPUT
                                                       : LF_CODE_LOAD_IMAGE,
                                NULL);
    code.value = value;
    code.channels = v->channels;
    code.out = out;
    if (code.kind == LF_CODE_LOAD_IMAGE)
        code.image = p->image.items[value];
    put(p, scope_of(p, value), code);
}

static void emit_op(struct lf_planner *p, const struct lf_op *op);

// Where its fp32 rows are; loads or makes them if they are not in the tile.
static struct lf_place rows_of(struct lf_planner *p, uint32_t value)
{
    struct lf_residence *r = residence(p, value);
    uint32_t op = value_at(p, value)->op;
    if (!is_here(r->rows) && is_made_anywhere(p, value)) {
        emit_op(p, &p->net->ops.items[op]);
    } else if (!is_here(r->rows)) {
        r->rows = add_buffer(p, value_at(p, value)->channels);
        load(p, value, r->rows);
        if (p->plan->group == 1)
            r->packed = r->rows;
    }
    return r->rows;
}

// ---- Products -------------------------------------------------------------------------------------------

// Whether a product that makes this value can write it packed.
static bool act_is_simple(const struct lf_op *op)
{
    return op->act == LF_OP_COUNT || op->act == LF_OP_RELU || op->act == LF_OP_LEAKY;
}

// Whether a value arrives packed: from a product, or from an image. The others are packed row by row, so that
// one of a single channel does not take the place of two.
static bool arrives_packed(const struct lf_planner *p, uint32_t value)
{
    const struct lf_op *op = maker(p, value);
    if (p->plan->group == 1)
        return true;
    if (value_at(p, value)->channels % p->plan->group)
        return false;
    if (op)
        return (op->kind == LF_OP_LINEAR || op->kind == LF_OP_CONV) && act_is_simple(op);
    return value_at(p, value)->op != LF_NO_VALUE && !is_made_anywhere(p, value) && !is_constant(p, value) &&
           lf_is_picture(value_at(p, value)->domain) == (p->segment->domain == LF_DOMAIN_VIEW) &&
           value_at(p, value)->domain != LF_DOMAIN_LIGHT && value_at(p, value)->domain != LF_DOMAIN_FRAME;
}

static void add_column(struct lf_planner *p, struct lf_product *product, uint32_t column)
{
    if (!ng_array_push(&product->columns, column))
        p->failed = true;
}

// The columns of operands [of one kind], in the order of their rows.
static void add_columns(struct lf_planner *p, struct lf_product *product, bool packed)
{
    uint32_t column = 0;
    for (uint32_t i = 0; i < product->op->in_count; i++) {
        uint32_t value = product->op->in[i], channels = value_at(p, value)->channels;
        if (!is_constant(p, value) && arrives_packed(p, value) == packed)
            for (uint32_t c = 0; c < channels; c++)
                add_column(p, product, column + c);
        column += channels;
    }
    while (product->columns.count % p->plan->group)
        add_column(p, product, LF_NO_VALUE);
}

static void add_constants(struct lf_planner *p, struct lf_product *product)
{
    uint32_t column = 0;
    for (uint32_t i = 0; i < product->op->in_count; i++) {
        uint32_t value = product->op->in[i];
        if (is_constant(p, value)) {
            product->by_light |= value_at(p, value)->domain == LF_DOMAIN_LIGHT;
            if (!ng_array_push(&product->constants, (struct lf_constant){value, column}))
                p->failed = true;
        }
        column += value_at(p, value)->channels;
    }
}

static uint32_t add_product(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_product product = {.op = op, .taps = op->kind == LF_OP_CONV ? 9 : 1};
    product.outputs = value_at(p, op->out)->channels;
    for (uint32_t i = 0; i < op->in_count; i++)
        product.inputs += value_at(p, op->in[i])->channels;
    if (op->kind == LF_OP_LINEAR) {
        add_constants(p, &product);
        add_columns(p, &product, true);
        add_columns(p, &product, false);
    } else {
        for (uint32_t c = 0; c < product.inputs; c++)
            add_column(p, &product, c);
    }
    product.weights_channels = (uint32_t)product.columns.count;
    for (uint32_t i = 0; i < product.columns.count; i++)
        product.weights_channels -= product.columns.items[i] == LF_NO_VALUE;
    product.rows = p->kernel->pad_rows(packed_rows(p, (uint32_t)product.columns.count));
    while (product.columns.count < (size_t)product.rows * p->plan->group && !p->failed)
        add_column(p, &product, LF_NO_VALUE);
    if (product.constants.count) {
        product.bias_at = p->plan->bias_floats;
        p->plan->bias_floats += (product.outputs + LF_OUTPUTS - 1) / LF_OUTPUTS * LF_OUTPUTS;
    }
    if (!ng_array_push(&p->plan->products, product))
        p->failed = true;
    return (uint32_t)p->plan->products.count - 1;
}

// Operands that are put together; with one that arrives packed nothing is.
static uint32_t operand_count(const struct lf_planner *p, const struct lf_op *op)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < op->in_count; i++)
        count += !is_constant(p, op->in[i]);
    return count;
}

static struct lf_panel *panel_of(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_panel *panel = &p->panels.items[op - p->net->ops.items];
    if (panel->product == LF_NO_VALUE) {
        panel->product = add_product(p, op);
        if (!p->failed)
            panel->place = add_buffer(p, p->plan->products.items[panel->product].rows);
    }
    return panel;
}

// Where a value's packed rows belong in a panel.
static struct lf_place place_in(const struct lf_planner *p, const struct lf_op *op,
                                const struct lf_panel *panel, uint32_t operand)
{
    uint32_t row = 0;
    for (uint32_t i = 0; i < operand; i++)
        if (!is_constant(p, op->in[i]) && arrives_packed(p, op->in[i]))
            row += packed_rows(p, value_at(p, op->in[i])->channels);
    return at_row(panel->place, row);
}

static bool runs_in_scope(const struct lf_planner *p, const struct lf_op *op)
{
    size_t index = (size_t)(op - p->net->ops.items);
    return op->kind == LF_OP_LINEAR && in_segment(p, index) &&
           (scope_of(p, op->out) == IN_ONCE || p->wanted.items[index]);
}

// Room for packed rows: in the panel of the first product that puts this value together with others, so that
// nothing needs to be copied; else on its own.
static struct lf_place room_for_packed(struct lf_planner *p, uint32_t value)
{
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *op = &p->net->ops.items[i];
        if (!runs_in_scope(p, op) || operand_count(p, op) < 2)
            continue;
        for (uint32_t k = 0; k < op->in_count; k++)
            if (op->in[k] == value && arrives_packed(p, value))
                return place_in(p, op, panel_of(p, op), k);
    }
    uint32_t rows = packed_rows(p, value_at(p, value)->channels), padded = p->kernel->pad_rows(rows);
    struct lf_place place = add_buffer(p, padded);
    clear(p, scope_of(p, value), at_row(place, rows), padded - rows);
    return place;
}

// Where its packed rows are; only of a value that arrives packed.
static struct lf_place packed_of(struct lf_planner *p, uint32_t value)
{
    struct lf_residence *r = residence(p, value);
    if (p->plan->group == 1)
        return rows_of(p, value);
    if (!is_here(r->packed)) {
        struct lf_code code = blank(LF_CODE_LOAD_PACKED, NULL);
        code.image = p->image.items[value];
        code.value = value;
        code.rows = packed_rows(p, value_at(p, value)->channels);
        code.packed = r->packed = room_for_packed(p, value);
        put(p, scope_of(p, value), code);
    }
    return r->packed;
}

static void pack_rest(struct lf_planner *p, const struct lf_op *op, const struct lf_panel *panel,
                      uint32_t row, int scope)
{
    struct lf_code code = blank(LF_CODE_PACK, op);
    uint32_t begin = (uint32_t)p->plan->lists.count, count = 0;
    for (uint32_t i = 0; i < op->in_count; i++) {
        if (is_constant(p, op->in[i]) || arrives_packed(p, op->in[i]))
            continue;
        struct lf_place rows = rows_of(p, op->in[i]);
        for (uint32_t c = 0; c < value_at(p, op->in[i])->channels; c++, count++)
            if (!ng_array_push(&p->plan->lists, at_row(rows, c)))
                p->failed = true;
    }
    code.list = begin;
    code.list_count = count;
    code.packed = at_row(panel->place, row);
    if (count)
        put(p, scope, code);
    row += packed_rows(p, count);
    if (!p->failed)
        clear(p, scope, at_row(panel->place, row), p->plan->products.items[panel->product].rows - row);
}

// The operands of a product below one another.
static struct lf_place assemble(struct lf_planner *p, const struct lf_op *op, int scope, uint32_t *product)
{
    uint32_t row = 0;
    struct lf_panel *panel = &p->panels.items[op - p->net->ops.items];
    if (operand_count(p, op) == 1)
        for (uint32_t i = 0; i < op->in_count; i++) {
            uint32_t rows = packed_rows(p, value_at(p, op->in[i])->channels);
            if (!is_constant(p, op->in[i]) && arrives_packed(p, op->in[i]) &&
                p->kernel->pad_rows(rows) == rows) {
                if (panel->product == LF_NO_VALUE)
                    panel->product = add_product(p, op);
                *product = panel->product;
                return packed_of(p, op->in[i]);
            }
        }
    panel = panel_of(p, op);
    for (uint32_t i = 0; i < op->in_count; i++) {
        if (is_constant(p, op->in[i]) || !arrives_packed(p, op->in[i]))
            continue;
        uint32_t rows = packed_rows(p, value_at(p, op->in[i])->channels);
        struct lf_place from = packed_of(p, op->in[i]), to = at_row(panel->place, row);
        if (!same_place(from, to))
            copy(p, scope, from, to, rows);
        row += rows;
    }
    pack_rest(p, op, panel, row, scope);
    *product = panel->product;
    return panel->place;
}

// Whether anything in this segment reads a value's fp32 rows, its packed rows.
static void find_wants(const struct lf_planner *p, const struct lf_op *op, bool *rows, bool *packed)
{
    bool stored = p->stored.items[op - p->net->ops.items], vector = p->image.items[op->out] == LF_NO_VALUE;
    *rows = *packed = false;
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *reader = &p->net->ops.items[i];
        for (uint32_t k = 0; in_segment(p, i) && k < reader->in_count; k++)
            if (reader->in[k] == op->out && !lf_op_is_spatial(reader->kind))
                *(reader->kind == LF_OP_LINEAR && arrives_packed(p, op->out) ? packed : rows) = true;
    }
    for (uint32_t i = 0; i < NG_COUNT(p->net->outputs); i++)
        *rows |= p->net->outputs[i] == op->out;
    *(arrives_packed(p, op->out) && !vector ? packed : rows) |= stored;
    *rows |= !act_is_simple(op);
}

static void emit_product(struct lf_planner *p, const struct lf_op *op)
{
    int scope = scope_of(p, op->out);
    struct lf_code code = blank(LF_CODE_PRODUCT, op);
    struct lf_residence *r = residence(p, op->out);
    uint32_t channels = value_at(p, op->out)->channels;
    bool rows, packed;
    if (op->kind == LF_OP_LINEAR) {
        code.a = assemble(p, op, scope, &code.product);
    } else {
        code.product = add_product(p, op);
        code.image = p->image.items[op->in[0]];
        code.value = op->in[0];
    }
    find_wants(p, op, &rows, &packed);
    if (packed)
        r->packed = code.packed = room_for_packed(p, op->out);
    if (p->plan->group == 1 && packed) {
        r->rows = code.out = code.packed;
        code.packed = LF_NOWHERE;
    } else if (rows || !packed) {
        r->rows = code.out = add_buffer(p, channels);
        if (p->plan->group == 1)
            r->packed = r->rows;
    }
    code.channels = channels;
    code.each = act_is_simple(op) ? op->act : LF_OP_COUNT;
    put(p, scope, code);
    if (!act_is_simple(op)) {
        struct lf_code act = blank(LF_CODE_EACH, op);
        act.a = act.out = code.out;
        act.channels = channels;
        act.each = op->act;
        put(p, scope, act);
    }
}

// ---- Other operations -----------------------------------------------------------------------------------

static void emit_concat(struct lf_planner *p, const struct lf_op *op, struct lf_place out)
{
    uint32_t row = 0;
    for (uint32_t i = 0; i < op->in_count; i++) {
        uint32_t channels = value_at(p, op->in[i])->channels;
        copy(p, scope_of(p, op->out), rows_of(p, op->in[i]), at_row(out, row), channels);
        row += channels;
    }
}

static void emit_rows(struct lf_planner *p, const struct lf_op *op, enum lf_code_kind kind)
{
    struct lf_code code = blank(kind, op);
    struct lf_residence *r = residence(p, op->out);
    if (kind == LF_CODE_RESAMPLE) {
        code.image = p->image.items[op->in[0]];
        code.value = op->in[0];
    } else {
        code.a = rows_of(p, op->in[0]);
        code.channels = value_at(p, op->in[0])->channels;
    }
    if (op->in_count == 2) {
        code.b = rows_of(p, op->in[1]);
        code.b_channels = value_at(p, op->in[1])->channels;
    }
    code.each = op->kind;
    code.out = r->rows = add_buffer(p, value_at(p, op->out)->channels);
    if (p->plan->group == 1)
        r->packed = r->rows;
    put(p, scope_of(p, op->out), code);
}

static void emit_reduce(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_segment *s = p->segment;
    struct lf_code code = blank(LF_CODE_REDUCE, op);
    uint32_t channels = value_at(p, op->in[0])->channels;
    code.a = rows_of(p, op->in[0]);
    if (op->in_count == 2) {
        struct lf_code weighted = blank(LF_CODE_PAIRWISE, op);
        weighted.each = LF_OP_MUL;
        weighted.a = code.a;
        weighted.b = rows_of(p, op->in[1]);
        weighted.channels = channels;
        weighted.b_channels = 1;
        weighted.out = code.a = add_buffer(p, channels);
        put(p, IN_ONCE, weighted);
    }
    code.channels = channels;
    code.list = s->sums;
    put(p, IN_ONCE, code);
    if (!ng_array_push(&p->plan->reductions,
                       (struct lf_reduction){op->out, channels, s->sums, op->kind == LF_OP_MEAN}))
        p->failed = true;
    s->sums += channels;
}

// A sum over lights: zeros before the loop, each light's part in it.
static void emit_sum(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_code code = blank(LF_CODE_ADD_SCALED, op);
    struct lf_residence *r = residence(p, op->out);
    uint32_t channels = value_at(p, op->out)->channels;
    code.out = r->rows = add_buffer(p, channels);
    clear(p, IN_ONCE, code.out, channels);
    code.a = rows_of(p, op->in[0]);
    code.channels = channels;
    code.value = op->in_count == 2 ? op->in[1] : LF_NO_VALUE;
    put(p, IN_LIGHTS, code);
    if (p->plan->group == 1)
        r->packed = r->rows;
}

static struct lf_place vector_or_rows(struct lf_planner *p, uint32_t value)
{
    return value_at(p, value)->domain == LF_DOMAIN_LIGHT ? LF_NOWHERE : rows_of(p, value);
}

static void emit_attend(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_code code = blank(LF_CODE_ATTEND, op);
    struct lf_residence *r = residence(p, op->out);
    uint32_t channels = value_at(p, op->out)->channels, state = op->softmax ? 2 * op->heads : 0;
    code.out = r->rows = add_buffer(p, channels);
    clear(p, IN_ONCE, code.out, channels);
    if (state) {
        code.packed = add_buffer(p, state);
        clear(p, IN_ONCE, code.packed, state);
    }
    code.a = rows_of(p, op->in[0]);
    code.b = vector_or_rows(p, op->in[1]);
    code.c = vector_or_rows(p, op->in[2]);
    code.value = op->in_count == 4 ? op->in[3] : LF_NO_VALUE;
    code.channels = channels;
    put(p, IN_LIGHTS, code);
    if (p->plan->group == 1)
        r->packed = r->rows;
}

static void emit_attend_end(struct lf_planner *p, const struct lf_op *op)
{
    for (size_t i = 0; op->softmax && i < p->plan->codes.count; i++) {
        struct lf_code code = p->plan->codes.items[i];
        if (i < p->segment->code_begin || code.kind != LF_CODE_ATTEND || code.op != op)
            continue;
        code.kind = LF_CODE_ATTEND_END;
        code.a = code.b = code.c = LF_NOWHERE;
        put(p, IN_ONCE, code);
    }
}

static void emit_stores(struct lf_planner *p, const struct lf_op *op)
{
    size_t index = (size_t)(op - p->net->ops.items);
    int scope = scope_of(p, op->out);
    struct lf_code code = blank(LF_CODE_STORE_OUTPUT, NULL);
    code.channels = value_at(p, op->out)->channels;
    for (uint32_t i = 0; p->stage == LF_STAGE_GATHER && i < NG_COUNT(p->net->outputs); i++) {
        if (p->net->outputs[i] != op->out || !in_segment(p, index))
            continue;
        code.value = i;
        code.a = rows_of(p, op->out);
        put(p, scope, code);
    }
    if (!p->stored.items[index] || !in_segment(p, index))
        return;
    enum lf_net_domain domain = value_at(p, op->out)->domain;
    code.value = op->out;
    if (domain == LF_DOMAIN_FRAME || domain == LF_DOMAIN_LIGHT) {
        code.kind = LF_CODE_STORE_VECTOR;
        code.a = rows_of(p, op->out);
    } else {
        struct lf_residence *r = residence(p, op->out);
        bool packed = is_here(r->packed);
        code.kind = packed ? LF_CODE_STORE_PACKED : LF_CODE_STORE_IMAGE;
        code.image = p->image.items[op->out];
        code.a = packed ? LF_NOWHERE : rows_of(p, op->out);
        code.packed = r->packed;
        code.rows = packed_rows(p, code.channels);
    }
    put(p, scope, code);
}

static void emit_op(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_residence *r = residence(p, op->out);
    if (lf_op_reduces(p->net, op)) {
        emit_reduce(p, op);
        return;
    }
    switch (op->kind) {
    case LF_OP_LINEAR:
    case LF_OP_CONV:
        emit_product(p, op);
        break;
    case LF_OP_CONCAT:
        if (op->in_count == 1 && scope_of(p, op->in[0]) == scope_of(p, op->out)) {
            r->rows = rows_of(p, op->in[0]);
            r->packed = p->plan->group == 1 ? r->rows : LF_NOWHERE;
            break;
        }
        r->rows = add_buffer(p, value_at(p, op->out)->channels);
        emit_concat(p, op, r->rows);
        r->packed = p->plan->group == 1 ? r->rows : LF_NOWHERE;
        break;
    case LF_OP_SLICE:
        r->rows = at_row(rows_of(p, op->in[0]), op->from);
        r->packed = p->plan->group == 1 ? r->rows : LF_NOWHERE;
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
        if (!in_segment(p, i))
            continue;
        p->phase.items[i] = 0;
        for (uint32_t k = 0; k < op->in_count; k++) {
            const struct lf_op *from = maker(p, op->in[k]);
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
        bool root = in_segment(p, i) &&
                    ((gathers(p, op) && p->phase.items[i] == phase + 1) ||
                     (scope_of(p, op->out) == IN_LIGHTS && p->stored.items[i] && p->phase.items[i] == phase));
        p->wanted.items[i] |= root;
        for (uint32_t k = 0; p->wanted.items[i] && k < op->in_count; k++) {
            const struct lf_op *from = maker(p, op->in[k]);
            if (from && scope_of(p, op->in[k]) == IN_LIGHTS)
                p->wanted.items[from - p->net->ops.items] = true;
        }
    }
}

static void forget_light(struct lf_planner *p)
{
    for (size_t i = 0; i < p->light.count; i++)
        p->light.items[i] = (struct lf_residence){LF_NOWHERE, LF_NOWHERE};
    for (size_t i = 0; i < p->panels.count; i++)
        if (scope_of(p, p->net->ops.items[i].out) == IN_LIGHTS)
            p->panels.items[i].product = LF_NO_VALUE;
    memset(p->wanted.items, 0, p->wanted.count * sizeof *p->wanted.items);
}

static bool append(struct lf_planner *p, int scope)
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
        if (!in_segment(p, i) || scope_of(p, op->out) != IN_ONCE || p->phase.items[i] != phase)
            continue;
        if (is_made_anywhere(p, op->out) && is_here(residence(p, op->out)->rows))
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
        if (p->wanted.items[i] && !(is_made_anywhere(p, out) && is_here(residence(p, out)->rows)))
            emit_op(p, &p->net->ops.items[i]);
    }
    if (!append(p, IN_ONCE))
        return false;
    range.lights = (uint32_t)p->plan->codes.count;
    if (!append(p, IN_LIGHTS))
        return false;
    range.end = (uint32_t)p->plan->codes.count;
    return ng_array_push(&p->plan->phases, range);
}

// ---- Memory of a tile -----------------------------------------------------------------------------------

static void touch(struct lf_planner *p, struct lf_place place, uint32_t code)
{
    if (!is_here(place))
        return;
    struct lf_buffer *b = &p->buffers.items[place.buffer];
    b->first = b->first < code ? b->first : code;
    b->last = b->last > code ? b->last : code;
}

// What is made before a loop over lights and read in it must last through all lights.
static void find_lives(struct lf_planner *p)
{
    const struct lf_plan *plan = p->plan;
    for (uint32_t i = p->segment->code_begin; i < plan->codes.count; i++) {
        const struct lf_code *c = &plan->codes.items[i];
        const struct lf_place places[] = {c->a, c->b, c->c, c->out, c->packed};
        for (size_t k = 0; k < NG_COUNT(places); k++)
            touch(p, places[k], i);
        for (uint32_t k = 0; c->kind == LF_CODE_PACK && k < c->list_count; k++)
            touch(p, plan->lists.items[c->list + k], i);
    }
    for (uint32_t i = p->segment->phase_begin; i < plan->phases.count; i++) {
        const struct lf_phase *phase = &plan->phases.items[i];
        for (size_t k = 0; k < p->buffers.count; k++) {
            struct lf_buffer *b = &p->buffers.items[k];
            if (b->first < phase->lights && b->last >= phase->lights && b->last < phase->end)
                b->last = phase->end - 1;
        }
    }
}

// The first gap among those that live at the same time.
static void place_buffer(struct lf_planner *p, size_t index)
{
    struct lf_buffer *b = &p->buffers.items[index];
    bool moved = true;
    b->offset = 0;
    while (moved) {
        moved = false;
        for (size_t i = 0; i < index; i++) {
            const struct lf_buffer *o = &p->buffers.items[i];
            if (o->first <= b->last && b->first <= o->last && o->offset < b->offset + b->rows &&
                b->offset < o->offset + o->rows) {
                b->offset = o->offset + o->rows;
                moved = true;
            }
        }
    }
    if (b->offset + b->rows > p->segment->rows)
        p->segment->rows = b->offset + b->rows;
}

static void resolve(const struct lf_planner *p, struct lf_place *place)
{
    if (!is_here(*place))
        return;
    place->row += p->buffers.items[place->buffer].offset;
    place->buffer = 0;
}

static void place_all(struct lf_planner *p, uint32_t list_begin)
{
    struct lf_plan *plan = p->plan;
    find_lives(p);
    for (size_t i = 0; i < p->buffers.count; i++)
        if (p->buffers.items[i].first != UINT32_MAX)
            place_buffer(p, i);
        else
            p->buffers.items[i].last = 0;
    for (uint32_t i = p->segment->code_begin; i < plan->codes.count; i++) {
        struct lf_code *c = &plan->codes.items[i];
        struct lf_place *places[] = {&c->a, &c->b, &c->c, &c->out, &c->packed};
        for (size_t k = 0; k < NG_COUNT(places); k++)
            resolve(p, places[k]);
    }
    for (size_t i = list_begin; i < plan->lists.count; i++)
        resolve(p, &plan->lists.items[i]);
}

// ---- The whole ------------------------------------------------------------------------------------------

static bool prepare(struct lf_planner *p)
{
    size_t values = p->net->values.count, ops = p->net->ops.count;
    p->buffers.count = p->codes[0].count = p->codes[1].count = 0;
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
    place_all(p, list_begin);
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
    ng_array_finish(&p->codes[0]);
    ng_array_finish(&p->codes[1]);
    ng_array_finish(&p->wanted);
}

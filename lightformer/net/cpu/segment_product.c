// The products of a segment, linear or convolution: columns of weights in the order in which operands arrive,
// and a panel where several operands lie below one another, packed. What makes a value writes it where the
// first panel wants it.
#include "lightformer/net/cpu/segment_internal.h"

static bool same_place(struct lf_place a, struct lf_place b)
{
    return a.buffer == b.buffer && a.row == b.row;
}

// ---- Columns and constants ------------------------------------------------------------------------------

// Whether a product that makes this value can write it packed.
static bool act_is_simple(const struct lf_op *op)
{
    return op->act == LF_OP_COUNT || op->act == LF_OP_RELU || op->act == LF_OP_LEAKY;
}

// Whether a value arrives packed: from a product, or from an image. The others are packed row by row, so that
// one of a single channel does not take the place of two.
static bool arrives_packed(const struct lf_planner *p, uint32_t value)
{
    const struct lf_op *op = lf_segment_maker(p, value);
    if (p->plan->group == 1)
        return true;
    if (lf_value_at(p, value)->channels % p->plan->group)
        return false;
    if (op)
        return (op->kind == LF_OP_LINEAR || op->kind == LF_OP_CONV) && act_is_simple(op);
    return lf_value_at(p, value)->op != LF_NO_VALUE && !lf_is_made_anywhere(p, value) &&
           !lf_is_constant(p, value) &&
           lf_is_picture(lf_value_at(p, value)->domain) == (p->segment->domain == LF_DOMAIN_VIEW) &&
           lf_value_at(p, value)->domain != LF_DOMAIN_LIGHT &&
           lf_value_at(p, value)->domain != LF_DOMAIN_FRAME;
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
        uint32_t value = product->op->in[i], channels = lf_value_at(p, value)->channels;
        if (!lf_is_constant(p, value) && arrives_packed(p, value) == packed)
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
        if (lf_is_constant(p, value)) {
            product->by_light |= lf_value_at(p, value)->domain == LF_DOMAIN_LIGHT;
            if (!ng_array_push(&product->constants, (struct lf_constant){value, column}))
                p->failed = true;
        }
        column += lf_value_at(p, value)->channels;
    }
}

static uint32_t add_product(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_product product = {.op = op, .taps = op->kind == LF_OP_CONV ? 9 : 1};
    product.outputs = lf_value_at(p, op->out)->channels;
    for (uint32_t i = 0; i < op->in_count; i++)
        product.inputs += lf_value_at(p, op->in[i])->channels;
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
    product.rows = p->kernel->pad_rows(lf_packed_rows(p, (uint32_t)product.columns.count));
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

// ---- Operands -------------------------------------------------------------------------------------------

// Operands that are put together; with one that arrives packed nothing is.
static uint32_t operand_count(const struct lf_planner *p, const struct lf_op *op)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < op->in_count; i++)
        count += !lf_is_constant(p, op->in[i]);
    return count;
}

static struct lf_panel *panel_of(struct lf_planner *p, const struct lf_op *op)
{
    struct lf_panel *panel = &p->panels.items[op - p->net->ops.items];
    if (panel->product == LF_NO_VALUE) {
        panel->product = add_product(p, op);
        if (!p->failed)
            panel->place = lf_add_buffer(p, p->plan->products.items[panel->product].rows);
    }
    return panel;
}

// Where a value's packed rows belong in a panel.
static struct lf_place place_in(const struct lf_planner *p, const struct lf_op *op,
                                const struct lf_panel *panel, uint32_t operand)
{
    uint32_t row = 0;
    for (uint32_t i = 0; i < operand; i++)
        if (!lf_is_constant(p, op->in[i]) && arrives_packed(p, op->in[i]))
            row += lf_packed_rows(p, lf_value_at(p, op->in[i])->channels);
    return lf_at_row(panel->place, row);
}

static bool runs_in_scope(const struct lf_planner *p, const struct lf_op *op)
{
    size_t index = (size_t)(op - p->net->ops.items);
    return op->kind == LF_OP_LINEAR && lf_in_segment(p, index) &&
           (lf_scope_of(p, op->out) == LF_SCOPE_TILE || p->wanted.items[index]);
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
    uint32_t rows = lf_packed_rows(p, lf_value_at(p, value)->channels), padded = p->kernel->pad_rows(rows);
    struct lf_place place = lf_add_buffer(p, padded);
    lf_emit_clear(p, lf_scope_of(p, value), lf_at_row(place, rows), padded - rows);
    return place;
}

// Where its packed rows are; only of a value that arrives packed.
static struct lf_place packed_of(struct lf_planner *p, uint32_t value)
{
    struct lf_residence *r = lf_residence_of(p, value);
    if (p->plan->group == 1)
        return lf_rows_of(p, value);
    if (!lf_is_here(r->packed)) {
        struct lf_code code = lf_blank_code(LF_CODE_LOAD_PACKED, NULL);
        code.image = p->image.items[value];
        code.value = value;
        code.rows = lf_packed_rows(p, lf_value_at(p, value)->channels);
        code.packed = r->packed = room_for_packed(p, value);
        lf_put_code(p, lf_scope_of(p, value), code);
    }
    return r->packed;
}

static void pack_rest(struct lf_planner *p, const struct lf_op *op, const struct lf_panel *panel,
                      uint32_t row, enum lf_scope scope)
{
    struct lf_code code = lf_blank_code(LF_CODE_PACK, op);
    uint32_t begin = (uint32_t)p->plan->lists.count, count = 0;
    for (uint32_t i = 0; i < op->in_count; i++) {
        if (lf_is_constant(p, op->in[i]) || arrives_packed(p, op->in[i]))
            continue;
        struct lf_place rows = lf_rows_of(p, op->in[i]);
        for (uint32_t c = 0; c < lf_value_at(p, op->in[i])->channels; c++, count++)
            if (!ng_array_push(&p->plan->lists, lf_at_row(rows, c)))
                p->failed = true;
    }
    code.list = begin;
    code.list_count = count;
    code.packed = lf_at_row(panel->place, row);
    if (count)
        lf_put_code(p, scope, code);
    row += lf_packed_rows(p, count);
    if (!p->failed)
        lf_emit_clear(p, scope, lf_at_row(panel->place, row),
                      p->plan->products.items[panel->product].rows - row);
}

// The operands of a product below one another.
static struct lf_place assemble(struct lf_planner *p, const struct lf_op *op, enum lf_scope scope,
                                uint32_t *product)
{
    uint32_t row = 0;
    struct lf_panel *panel = &p->panels.items[op - p->net->ops.items];
    if (operand_count(p, op) == 1)
        for (uint32_t i = 0; i < op->in_count; i++) {
            uint32_t rows = lf_packed_rows(p, lf_value_at(p, op->in[i])->channels);
            if (!lf_is_constant(p, op->in[i]) && arrives_packed(p, op->in[i]) &&
                p->kernel->pad_rows(rows) == rows) {
                if (panel->product == LF_NO_VALUE)
                    panel->product = add_product(p, op);
                *product = panel->product;
                return packed_of(p, op->in[i]);
            }
        }
    panel = panel_of(p, op);
    for (uint32_t i = 0; i < op->in_count; i++) {
        if (lf_is_constant(p, op->in[i]) || !arrives_packed(p, op->in[i]))
            continue;
        uint32_t rows = lf_packed_rows(p, lf_value_at(p, op->in[i])->channels);
        struct lf_place from = packed_of(p, op->in[i]), to = lf_at_row(panel->place, row);
        if (!same_place(from, to))
            lf_emit_copy(p, scope, from, to, rows);
        row += rows;
    }
    pack_rest(p, op, panel, row, scope);
    *product = panel->product;
    return panel->place;
}

// ---- Codes ----------------------------------------------------------------------------------------------

// Whether anything in this segment reads a value's fp32 rows, its packed rows.
static void find_wants(const struct lf_planner *p, const struct lf_op *op, bool *rows, bool *packed)
{
    bool stored = p->stored.items[op - p->net->ops.items], vector = p->image.items[op->out] == LF_NO_VALUE;
    *rows = *packed = false;
    for (size_t i = 0; i < p->net->ops.count; i++) {
        const struct lf_op *reader = &p->net->ops.items[i];
        for (uint32_t k = 0; lf_in_segment(p, i) && k < reader->in_count; k++)
            if (reader->in[k] == op->out && !lf_op_is_spatial(reader->kind))
                *(reader->kind == LF_OP_LINEAR && arrives_packed(p, op->out) ? packed : rows) = true;
    }
    for (uint32_t i = 0; i < NG_COUNT(p->net->outputs); i++)
        *rows |= p->net->outputs[i] == op->out;
    *(arrives_packed(p, op->out) && !vector ? packed : rows) |= stored;
    *rows |= !act_is_simple(op);
}

void lf_emit_product(struct lf_planner *p, const struct lf_op *op)
{
    enum lf_scope scope = lf_scope_of(p, op->out);
    struct lf_code code = lf_blank_code(LF_CODE_PRODUCT, op);
    struct lf_residence *r = lf_residence_of(p, op->out);
    uint32_t channels = lf_value_at(p, op->out)->channels;
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
        code.out = lf_set_rows(p, op->out, lf_add_buffer(p, channels));
    }
    code.channels = channels;
    code.each = act_is_simple(op) ? op->act : LF_OP_COUNT;
    lf_put_code(p, scope, code);
    if (!act_is_simple(op)) {
        struct lf_code act = lf_blank_code(LF_CODE_EACH, op);
        act.a = act.out = code.out;
        act.channels = channels;
        act.each = op->act;
        lf_put_code(p, scope, act);
    }
}

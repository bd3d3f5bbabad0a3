// The same function for less, operation by operation in order (each is exact but for rounding):
//
//   linear(concat(a, b))       -> linear(a, b)          nothing is copied
//   mean(linear(a, b))         -> linear(mean a, mean b) once a light, not once a row; where act is none
//   twice the same             -> once
//   conv(a, b), pool(input)... -> conv(concat(a, b))    what reads a neighbourhood reads one stored picture
//
// and what no output needs is dropped.
#include "lightformer/net/program_internal.h"

#include "base/log.h"

#include <stdio.h>
#include <string.h>

struct rewrite {
    struct lf_net *net;
    NG_ARRAY(struct lf_op) ops; // the new program
    NG_ARRAY(uint32_t) uses;    // by value: how many operations of the old program read it
    NG_ARRAY(uint32_t) same;    // by value of the old program: the one that is read in its place
    bool failed;
};

static struct lf_value *value_of(const struct rewrite *r, uint32_t value)
{
    return &r->net->values.items[value];
}

static bool is_same(const struct lf_op *a, const struct lf_op *b)
{
    return a->kind == b->kind && a->in_count == b->in_count && a->act == b->act && a->from == b->from &&
           a->to == b->to && a->heads == b->heads && a->softmax == b->softmax && a->scale == b->scale &&
           a->offset == b->offset && a->low == b->low && a->high == b->high && a->weight == b->weight &&
           a->bias == b->bias && memcmp(a->in, b->in, a->in_count * sizeof *a->in) == 0;
}

// Adds an operation, unless there is one like it. Returns the value that has its result.
static uint32_t put(struct rewrite *r, const struct lf_op *op)
{
    for (size_t i = 0; i < r->ops.count; i++)
        if (is_same(&r->ops.items[i], op))
            return r->ops.items[i].out;
    if (!ng_array_push(&r->ops, *op))
        r->failed = true;
    return op->out;
}

// A value that an inserted operation makes of `like`.
static uint32_t add_value(struct rewrite *r, struct lf_value like, const char *how)
{
    snprintf(like.name, sizeof like.name, "(%s)", how);
    like.input = like.op = LF_NO_VALUE;
    if (!ng_array_push(&r->net->values, like))
        r->failed = true;
    return (uint32_t)r->net->values.count - 1;
}

static const struct lf_op *maker(const struct rewrite *r, uint32_t value)
{
    uint32_t op = value_of(r, value)->op;
    return op == LF_NO_VALUE ? NULL : &r->net->ops.items[op];
}

static void flatten(const struct rewrite *r, struct lf_op *op)
{
    for (uint32_t i = 0; i < op->in_count;) {
        const struct lf_op *concat = maker(r, op->in[i]);
        if (!concat || concat->kind != LF_OP_CONCAT ||
            op->in_count + concat->in_count - 1 > LF_MAX_OPERANDS) {
            i++;
            continue;
        }
        uint32_t after = op->in_count - i - 1;
        memmove(op->in + i + concat->in_count, op->in + i + 1, after * sizeof *op->in);
        for (uint32_t k = 0; k < concat->in_count; k++)
            op->in[i + k] = r->same.items[concat->in[k]];
        op->in_count += concat->in_count - 1;
    }
}

static uint32_t put_linear_of_means(struct rewrite *r, const struct lf_op *mean, const struct lf_op *linear)
{
    struct lf_op after = *linear;
    flatten(r, &after);
    after.out = mean->out;
    for (uint32_t i = 0; i < after.in_count; i++) {
        struct lf_value value = *value_of(r, after.in[i]);
        if (!lf_is_rows(value.domain))
            continue;
        struct lf_op part = {.kind = LF_OP_MEAN, .act = LF_OP_COUNT, .in = {after.in[i]}, .in_count = 1};
        value.rows = (uint32_t)value.domain;
        value.domain = LF_DOMAIN_LIGHT;
        part.out = add_value(r, value, "mean");
        after.in[i] = put(r, &part);
    }
    return put(r, &after);
}

// One operand, stored: a copy of several, or of an input, which is nowhere stored with a border.
static uint32_t put_stored(struct rewrite *r, struct lf_op *op)
{
    if (op->in_count > 1 || value_of(r, op->in[0])->input != LF_NO_VALUE) {
        struct lf_op copy = {.kind = LF_OP_CONCAT, .act = LF_OP_COUNT, .in_count = op->in_count};
        struct lf_value value = *value_of(r, op->in[0]);
        memcpy(copy.in, op->in, sizeof copy.in);
        for (uint32_t i = 1; i < op->in_count; i++) {
            const struct lf_value *next = value_of(r, op->in[i]);
            value.level = lf_is_picture(next->domain) ? next->level : value.level;
            lf_domain_join(value.domain, next->domain, &value.domain);
            value.channels += next->channels;
            value.gather |= next->gather;
        }
        copy.out = add_value(r, value, "copy");
        memset(op->in, 0, sizeof op->in);
        op->in[0] = put(r, &copy);
        op->in_count = 1;
    }
    return put(r, op);
}

static uint32_t rewrite_op(struct rewrite *r, struct lf_op op)
{
    const struct lf_op *from = maker(r, op.in[0]);
    for (uint32_t i = 0; i < op.in_count; i++)
        op.in[i] = r->same.items[op.in[i]];
    if (op.kind == LF_OP_MEAN && from && from->kind == LF_OP_LINEAR && from->act == LF_OP_COUNT &&
        r->uses.items[op.in[0]] == 1) {
        struct lf_op linear = *from;
        for (uint32_t i = 0; i < linear.in_count; i++)
            linear.in[i] = r->same.items[linear.in[i]];
        return put_linear_of_means(r, &op, &linear);
    }
    if (lf_op_is_spatial(op.kind))
        return put_stored(r, &op);
    if (op.kind == LF_OP_LINEAR || op.kind == LF_OP_CONCAT)
        flatten(r, &op);
    return put(r, &op);
}

static ng_result prepare(struct rewrite *r)
{
    if (!ng_array_resize(&r->uses, r->net->values.count) || !ng_array_resize(&r->same, r->net->values.count))
        return ng_out_of_memory("a network");
    for (size_t i = 0; i < r->same.count; i++)
        r->same.items[i] = (uint32_t)i;
    for (size_t i = 0; i < r->net->ops.count; i++)
        for (uint32_t k = 0; k < r->net->ops.items[i].in_count; k++)
            r->uses.items[r->net->ops.items[i].in[k]]++;
    return NG_OK;
}

// Keeps what the outputs follow from, in order, and says which operation makes what.
static ng_result keep_needed(struct rewrite *r)
{
    struct lf_net *net = r->net;
    NG_ARRAY(bool) needed = {0};
    if (!ng_array_resize(&needed, net->values.count))
        return ng_out_of_memory("a network");
    for (uint32_t i = 0; i < NG_COUNT(net->outputs); i++)
        needed.items[net->outputs[i]] = true;
    for (size_t i = r->ops.count; i-- > 0;) {
        const struct lf_op *op = &r->ops.items[i];
        for (uint32_t k = 0; needed.items[op->out] && k < op->in_count; k++)
            needed.items[op->in[k]] = true;
    }
    size_t count = 0;
    for (size_t i = 0; i < r->ops.count; i++)
        if (needed.items[r->ops.items[i].out])
            r->ops.items[count++] = r->ops.items[i];
    r->ops.count = count;
    for (size_t i = 0; i < count; i++)
        net->values.items[r->ops.items[i].out].op = (uint32_t)i;
    ng_array_finish(&needed);
    return NG_OK;
}

ng_result lf_program_simplify(struct lf_net *net)
{
    struct rewrite r = {.net = net};
    ng_result result = prepare(&r);
    for (size_t i = 0; result == NG_OK && i < net->ops.count; i++)
        r.same.items[net->ops.items[i].out] = rewrite_op(&r, net->ops.items[i]);
    for (size_t i = 0; result == NG_OK && i < NG_COUNT(net->outputs); i++)
        net->outputs[i] = r.same.items[net->outputs[i]];
    if (result == NG_OK)
        result = r.failed ? ng_out_of_memory("a network") : keep_needed(&r);
    if (result == NG_OK) {
        ng_array_finish(&net->ops);
        net->ops.items = r.ops.items;
        net->ops.count = r.ops.count;
        net->ops.capacity = r.ops.capacity;
    } else {
        ng_array_finish(&r.ops);
    }
    ng_array_finish(&r.uses);
    ng_array_finish(&r.same);
    return result;
}

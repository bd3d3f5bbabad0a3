// The same function for less, operation by operation in order (each is exact but for rounding):
//
//   linear(concat(a, b))       -> linear(a, b)          nothing is copied
//   mean(linear(a, b))         -> linear(mean a, mean b) once a light, not once a row; where act is none
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
    bool failed;
};

static struct lf_value *value_of(const struct rewrite *r, uint32_t value)
{
    return &r->net->values.items[value];
}

static void put(struct rewrite *r, const struct lf_op *op)
{
    if (!ng_array_push(&r->ops, *op))
        r->failed = true;
}

// A value that an inserted operation makes of `like`.
static uint32_t add_value(struct rewrite *r, struct lf_value like, const char *how)
{
    snprintf(like.name, sizeof like.name, "(%s)", how);
    like.input = LF_NO_VALUE;
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
        memcpy(op->in + i, concat->in, concat->in_count * sizeof *op->in);
        op->in_count += concat->in_count - 1;
    }
}

static void put_linear_of_means(struct rewrite *r, const struct lf_op *mean, const struct lf_op *linear)
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
        part.out = after.in[i] = add_value(r, value, "mean");
        put(r, &part);
    }
    put(r, &after);
}

// One operand, stored: a copy of several, or of an input, which is nowhere stored with a border.
static void put_stored(struct rewrite *r, struct lf_op *op)
{
    const struct lf_op *only = op->in_count == 1 ? maker(r, op->in[0]) : NULL;
    if (!only) {
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
        copy.out = op->in[0] = add_value(r, value, "copy");
        op->in_count = 1;
        put(r, &copy);
    }
    put(r, op);
}

static void rewrite_op(struct rewrite *r, struct lf_op op)
{
    const struct lf_op *from = maker(r, op.in[0]);
    if (op.kind == LF_OP_MEAN && from && from->kind == LF_OP_LINEAR && from->act == LF_OP_COUNT &&
        r->uses.items[op.in[0]] == 1) {
        put_linear_of_means(r, &op, from);
    } else if (lf_op_is_spatial(op.kind)) {
        put_stored(r, &op);
    } else {
        if (op.kind == LF_OP_LINEAR || op.kind == LF_OP_CONCAT)
            flatten(r, &op);
        put(r, &op);
    }
}

static ng_result count_uses(struct rewrite *r)
{
    if (!ng_array_resize(&r->uses, r->net->values.count))
        return ng_out_of_memory("a network");
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
    ng_result result = count_uses(&r);
    for (size_t i = 0; result == NG_OK && i < net->ops.count; i++)
        rewrite_op(&r, net->ops.items[i]);
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
    return result;
}

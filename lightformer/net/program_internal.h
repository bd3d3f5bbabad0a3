// A program as read: values and the operations that make them, checked and with their weights.
#ifndef LF_NET_PROGRAM_INTERNAL_H
#define LF_NET_PROGRAM_INTERNAL_H

#include "lightformer/net/net.h"
#include "lightformer/tensors/tensors.h"

#define LF_MAX_OPS      1024
#define LF_MAX_OPERANDS 32
#define LF_MAX_CHANNELS 4096
#define LF_MAX_LEVEL    8
#define LF_NAME         48
#define LF_NO_VALUE     UINT32_MAX

// name, enumerator, operands at least, at most
#define LF_OPS(X)                                                                                            \
    X("linear", LINEAR, 1, LF_MAX_OPERANDS)                                                                  \
    X("conv", CONV, 1, LF_MAX_OPERANDS)                                                                      \
    X("concat", CONCAT, 1, LF_MAX_OPERANDS)                                                                  \
    X("slice", SLICE, 1, 1)                                                                                  \
    X("add", ADD, 2, 2)                                                                                      \
    X("sub", SUB, 2, 2)                                                                                      \
    X("mul", MUL, 2, 2)                                                                                      \
    X("div", DIV, 2, 2)                                                                                      \
    X("min", MIN, 2, 2)                                                                                      \
    X("max", MAX, 2, 2)                                                                                      \
    X("affine", AFFINE, 1, 1)                                                                                \
    X("clamp", CLAMP, 1, 1)                                                                                  \
    X("relu", RELU, 1, 1)                                                                                    \
    X("leaky", LEAKY, 1, 1)                                                                                  \
    X("sigmoid", SIGMOID, 1, 1)                                                                              \
    X("softplus", SOFTPLUS, 1, 1)                                                                            \
    X("tanh", TANH, 1, 1)                                                                                    \
    X("exp", EXP, 1, 1)                                                                                      \
    X("log", LOG, 1, 1)                                                                                      \
    X("log1p", LOG1P, 1, 1)                                                                                  \
    X("sqrt", SQRT, 1, 1)                                                                                    \
    X("abs", ABS, 1, 1)                                                                                      \
    X("dot", DOT, 2, 2)                                                                                      \
    X("length", LENGTH, 1, 1)                                                                                \
    X("normalize", NORMALIZE, 1, 1)                                                                          \
    X("mean", MEAN, 1, 1)                                                                                    \
    X("pool", POOL, 1, 1)                                                                                    \
    X("pack", PACK, 1, 1)                                                                                    \
    X("up", UP, 1, 1)                                                                                        \
    X("unpack", UNPACK, 1, 1)                                                                                \
    X("sum", SUM, 1, 2)                                                                                      \
    X("attend", ATTEND, 3, 4)

enum lf_op_kind {
#define X(name, id, least, most) LF_OP_##id,
    LF_OPS(X)
#undef X
        LF_OP_COUNT
};

struct lf_value {
    char name[LF_NAME];
    enum lf_net_domain domain;
    uint32_t channels, level;
    bool gather;    // follows from a gather: belongs to no light's encoding
    uint32_t op;    // that makes it, or LF_NO_VALUE
    uint32_t input; // enum lf_net_input, where there is no op
    uint32_t rows;  // a domain: where it has no row, the value is 0; LF_NO_VALUE
};

struct lf_op {
    enum lf_op_kind kind;
    uint32_t in[LF_MAX_OPERANDS], in_count, out;
    enum lf_op_kind act;      // LF_OP_COUNT: none
    uint32_t from, to, heads; // slice; attend
    bool softmax;
    float scale, offset, low, high;
    const float *weight, *bias; // [N][K] or [N][K][3][3]; [N]
    char name[LF_NAME];         // of the weights
};

struct lf_net {
    struct lf_tensors file;
    NG_ARRAY(float *) widened; // tensors that the file has as halfs
    NG_ARRAY(struct lf_value) values;
    NG_ARRAY(struct lf_op) ops; // in order, needed ones only
    uint32_t outputs[3];        // unshadowed, direct, indirect
    uint64_t parameters;
};

const char *lf_op_name(enum lf_op_kind kind);
bool lf_is_picture(enum lf_net_domain domain);
bool lf_is_rows(enum lf_net_domain domain); // vpl, texel
// The domain in which values of both meet; false if there is none.
bool lf_domain_join(enum lf_net_domain a, enum lf_net_domain b, enum lf_net_domain *out);
// Reads a neighbourhood of its operand, which must be whole before.
bool lf_op_is_spatial(enum lf_op_kind kind);

// Checks a program and finds its weights in net->file. NG_ERROR_FORMAT, logged with `path`.
NG_NODISCARD ng_result lf_program_read(struct lf_net *net, const char *path, const char *json);
// Rewrites it into one that gives the same and costs less.
NG_NODISCARD ng_result lf_program_simplify(struct lf_net *net);

#endif

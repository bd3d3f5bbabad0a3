// From JSON to a checked program. Operations are read one by one; each finds its operands among the values
// that exist by then, so that a program is in order by construction. A rule that is broken is told in one
// line with the operation's number and output.
#include "lightformer/net/program_internal.h"

#include "base/half.h"
#include "base/log.h"
#include "lightformer/tensors/json_reader.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct lf_net_input_info lf_net_inputs[LF_INPUT_COUNT] = {
#define ENCODE                                     false
#define GATHER                                     true
#define LF_INPUT(id, name, domain, channels, when) {name, LF_DOMAIN_##domain, channels, when},
#include "lightformer/net/inputs.inc"
#undef LF_INPUT
#undef ENCODE
#undef GATHER
};

static const struct {
    const char *name;
    uint32_t least, most;
} ops[LF_OP_COUNT] = {
#define X(name, id, least, most) {name, least, most},
    LF_OPS(X)
#undef X
};

const char *lf_op_name(enum lf_op_kind kind)
{
    return kind < LF_OP_COUNT ? ops[kind].name : "none";
}

bool lf_is_picture(enum lf_net_domain domain)
{
    return domain == LF_DOMAIN_PIXEL || domain == LF_DOMAIN_VIEW;
}

bool lf_is_rows(enum lf_net_domain domain)
{
    return domain == LF_DOMAIN_VPL || domain == LF_DOMAIN_TEXEL;
}

bool lf_op_is_spatial(enum lf_op_kind kind)
{
    return kind == LF_OP_CONV || kind == LF_OP_POOL || kind == LF_OP_PACK || kind == LF_OP_UP ||
           kind == LF_OP_UNPACK;
}

bool lf_domain_join(enum lf_net_domain a, enum lf_net_domain b, enum lf_net_domain *out)
{
    if (a > b) {
        enum lf_net_domain swap = a;
        a = b;
        b = swap;
    }
    *out = b;
    if (a == b || a == LF_DOMAIN_FRAME)
        return true;
    if (a == LF_DOMAIN_LIGHT) {
        *out = b == LF_DOMAIN_PIXEL ? LF_DOMAIN_VIEW : b;
        return true;
    }
    return a == LF_DOMAIN_PIXEL; // with a view
}

// ---- What is being read ---------------------------------------------------------------------------------

struct reader {
    struct lf_net *net;
    const char *path;
    struct lf_json json;
    struct lf_op op; // the one being read
    char out[LF_NAME];
    uint32_t channels; // that it asks for
    uint32_t index, seen;
    NG_ARRAY(bool) used; // tensors
};

NG_PRINTF(2, 3) static ng_result refuse(const struct reader *r, const char *format, ...)
{
    char what[256];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    ng_log_error("%s: operation %" PRIu32 " (%s \"%s\") %s", r->path, r->index, lf_op_name(r->op.kind),
                 r->out, what);
    return NG_ERROR_FORMAT;
}

static ng_result refuse_text(const struct reader *r)
{
    ng_log_error(
        "%s: the program is not a JSON array of operations (README of lightformer/net), at operation "
        "%" PRIu32,
        r->path, r->index);
    return NG_ERROR_FORMAT;
}

static uint32_t find_value(const struct lf_net *net, const char *name)
{
    for (size_t i = 0; i < net->values.count; i++)
        if (strcmp(net->values.items[i].name, name) == 0)
            return (uint32_t)i;
    return LF_NO_VALUE;
}

static bool add_input_values(struct lf_net *net)
{
    for (uint32_t i = 0; i < LF_INPUT_COUNT; i++) {
        const struct lf_net_input_info *info = &lf_net_inputs[i];
        struct lf_value value = {.domain = info->domain,
                                 .channels = info->channels,
                                 .gather = info->gather,
                                 .op = LF_NO_VALUE,
                                 .input = i,
                                 .rows = LF_NO_VALUE};
        snprintf(value.name, sizeof value.name, "%s", info->name);
        if (!ng_array_push(&net->values, value))
            return false;
    }
    return true;
}

// ---- The text of an operation ---------------------------------------------------------------------------

static bool find_op(const char *name, enum lf_op_kind *out)
{
    for (uint32_t i = 0; i < LF_OP_COUNT; i++)
        if (strcmp(ops[i].name, name) == 0) {
            *out = (enum lf_op_kind)i;
            return true;
        }
    return false;
}

static ng_result read_operands(struct reader *r)
{
    lf_json_open(&r->json, '[');
    while (lf_json_more(&r->json, ']')) {
        char name[LF_NAME];
        if (!lf_json_string(&r->json, name, sizeof name))
            break;
        uint32_t value = find_value(r->net, name);
        if (value == LF_NO_VALUE)
            return refuse(r, "reads \"%s\", which is neither an input nor made before it", name);
        if (r->op.in_count == LF_MAX_OPERANDS)
            return refuse(r, "reads more than %d values", LF_MAX_OPERANDS);
        r->op.in[r->op.in_count++] = value;
    }
    return r->json.failed ? refuse_text(r) : NG_OK;
}

static ng_result read_act(struct reader *r)
{
    char name[16];
    if (!lf_json_string(&r->json, name, sizeof name))
        return refuse_text(r);
    bool known = find_op(name, &r->op.act) &&
                 (r->op.act == LF_OP_RELU || r->op.act == LF_OP_LEAKY || r->op.act == LF_OP_SIGMOID ||
                  r->op.act == LF_OP_SOFTPLUS || r->op.act == LF_OP_TANH);
    if (!known)
        r->op.act = LF_OP_COUNT;
    return known || strcmp(name, "none") == 0 ? NG_OK : refuse(r, "has an unknown act \"%s\"", name);
}

static ng_result read_gate(struct reader *r)
{
    char name[16];
    if (!lf_json_string(&r->json, name, sizeof name))
        return refuse_text(r);
    r->op.softmax = strcmp(name, "softmax") == 0;
    return r->op.softmax || strcmp(name, "sigmoid") == 0 ? NG_OK
                                                         : refuse(r, "has an unknown gate \"%s\"", name);
}

static ng_result read_count(struct reader *r, uint32_t *out)
{
    uint64_t number;
    if (!lf_json_number(&r->json, &number))
        return refuse_text(r);
    if (number > LF_MAX_CHANNELS)
        return refuse(r, "has a number over %d", LF_MAX_CHANNELS);
    *out = (uint32_t)number;
    return NG_OK;
}

static ng_result read_real(struct reader *r, float *out)
{
    double number;
    if (!lf_json_real(&r->json, &number))
        return refuse_text(r);
    *out = (float)number;
    return NG_OK;
}

static ng_result read_name(struct reader *r, char *out)
{
    return lf_json_string(&r->json, out, LF_NAME) ? NG_OK : refuse_text(r);
}

static ng_result read_kind(struct reader *r)
{
    char name[LF_NAME];
    NG_TRY(read_name(r, name));
    if (find_op(name, &r->op.kind))
        return NG_OK;
    ng_log_error("%s: operation %" PRIu32 " is \"%s\", which this program does not know", r->path, r->index,
                 name);
    return NG_ERROR_FORMAT;
}

// The members of an operation, and which operations have them.
enum member {
    OP,
    IN,
    OUT,
    NAME,
    CHANNELS,
    ACT,
    FROM,
    TO,
    SCALE,
    OFFSET,
    LOW,
    HIGH,
    HEADS,
    GATE,
    MEMBER_COUNT
};
#define BIT(x) (1u << (x))
static const char *const members[MEMBER_COUNT] = {"op",  "in",   "out",   "name",  "channels",
                                                  "act", "from", "to",    "scale", "offset",
                                                  "low", "high", "heads", "gate"};

static ng_result read_member(struct reader *r, enum member member)
{
    switch (member) {
    case OP:
        return read_kind(r);
    case IN:
        return read_operands(r);
    case OUT:
        return read_name(r, r->out);
    case NAME:
        return read_name(r, r->op.name);
    case CHANNELS:
        return read_count(r, &r->channels);
    case ACT:
        return read_act(r);
    case FROM:
        return read_count(r, &r->op.from);
    case TO:
        return read_count(r, &r->op.to);
    case SCALE:
        return read_real(r, &r->op.scale);
    case OFFSET:
        return read_real(r, &r->op.offset);
    case LOW:
        return read_real(r, &r->op.low);
    case HIGH:
        return read_real(r, &r->op.high);
    case HEADS:
        return read_count(r, &r->op.heads);
    case GATE:
        return read_gate(r);
    case MEMBER_COUNT:
        break;
    }
    return refuse_text(r);
}

static ng_result read_text(struct reader *r)
{
    r->op = (struct lf_op){.kind = LF_OP_COUNT, .act = LF_OP_COUNT};
    r->out[0] = 0;
    r->channels = r->seen = 0;
    lf_json_open(&r->json, '{');
    while (lf_json_more(&r->json, '}')) {
        char key[LF_NAME];
        uint32_t member = 0;
        if (!lf_json_key(&r->json, key, sizeof key))
            return refuse_text(r);
        while (member < MEMBER_COUNT && strcmp(members[member], key) != 0)
            member++;
        if (member == MEMBER_COUNT || (r->seen & BIT(member)))
            return refuse(r, "has \"%s\", which is unknown or there twice", key);
        r->seen |= BIT(member);
        NG_TRY(read_member(r, (enum member)member));
    }
    return r->json.failed ? refuse_text(r) : NG_OK;
}

static uint32_t members_needed(enum lf_op_kind kind)
{
    uint32_t all = BIT(OP) | BIT(IN) | BIT(OUT);
    switch (kind) {
    case LF_OP_LINEAR:
    case LF_OP_CONV:
        return all | BIT(NAME) | BIT(CHANNELS);
    case LF_OP_SLICE:
        return all | BIT(FROM) | BIT(TO);
    case LF_OP_AFFINE:
        return all | BIT(SCALE) | BIT(OFFSET);
    case LF_OP_CLAMP:
        return all | BIT(LOW) | BIT(HIGH);
    case LF_OP_ATTEND:
        return all | BIT(HEADS) | BIT(GATE);
    default:
        return all;
    }
}

static ng_result check_members(const struct reader *r)
{
    bool product = r->op.kind == LF_OP_LINEAR || r->op.kind == LF_OP_CONV;
    uint32_t needed = members_needed(r->op.kind), allowed = needed | (product ? BIT(ACT) : 0);
    for (uint32_t i = 0; i < MEMBER_COUNT; i++) {
        if (needed & ~r->seen & BIT(i))
            return refuse(r, "lacks \"%s\"", members[i]);
        if (r->seen & ~allowed & BIT(i))
            return refuse(r, "has \"%s\", which it does not take", members[i]);
    }
    if (!r->out[0] || find_value(r->net, r->out) != LF_NO_VALUE)
        return refuse(r, "makes a value whose name is empty or taken");
    if (r->op.in_count < ops[r->op.kind].least || r->op.in_count > ops[r->op.kind].most)
        return refuse(r, "reads %" PRIu32 " values, not %" PRIu32 " to %" PRIu32, r->op.in_count,
                      ops[r->op.kind].least, ops[r->op.kind].most);
    return NG_OK;
}

// ---- What an operation makes ----------------------------------------------------------------------------

static const struct lf_value *operand(const struct reader *r, uint32_t i)
{
    return &r->net->values.items[r->op.in[i]];
}

// Domain and level in which the operands [0, count) meet.
static ng_result join(const struct reader *r, uint32_t count, struct lf_value *out)
{
    bool picture = false;
    *out = *operand(r, 0);
    for (uint32_t i = 0; i < count; i++) {
        const struct lf_value *in = operand(r, i);
        if (!lf_domain_join(out->domain, in->domain, &out->domain))
            return refuse(r, "reads \"%s\" beside values of a domain that it does not meet", in->name);
        if (lf_is_picture(in->domain)) {
            if (picture && in->level != out->level)
                return refuse(r, "reads \"%s\" of level %" PRIu32 " beside level %" PRIu32, in->name,
                              in->level, out->level);
            out->level = in->level;
            picture = true;
        }
        out->gather |= in->gather;
    }
    return NG_OK;
}

static uint64_t sum_of_channels(const struct reader *r)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < r->op.in_count; i++)
        sum += operand(r, i)->channels;
    return sum;
}

static ng_result infer_pairwise(const struct reader *r, struct lf_value *out)
{
    uint32_t a = operand(r, 0)->channels, b = operand(r, 1)->channels;
    out->channels = a > b ? a : b;
    if (a != b && ((a != 1 && b != 1) || r->op.kind == LF_OP_DOT))
        return refuse(r, "meets %" PRIu32 " channels with %" PRIu32, a, b);
    if (r->op.kind == LF_OP_DOT)
        out->channels = 1;
    return NG_OK;
}

static ng_result infer_picture(const struct reader *r, struct lf_value *out)
{
    if (!lf_is_picture(out->domain))
        return refuse(r, "reads \"%s\", which is not a picture", operand(r, 0)->name);
    bool down = r->op.kind == LF_OP_POOL || r->op.kind == LF_OP_PACK;
    if (down ? out->level == LF_MAX_LEVEL : out->level == 0)
        return refuse(r, "leaves the levels 0 to %d", LF_MAX_LEVEL);
    if (r->op.kind == LF_OP_UNPACK && out->channels % 4)
        return refuse(r, "reads %" PRIu32 " channels, not a multiple of 4", out->channels);
    out->level = down ? out->level + 1 : out->level - 1;
    if (r->op.kind == LF_OP_PACK)
        out->channels *= 4;
    if (r->op.kind == LF_OP_UNPACK)
        out->channels /= 4;
    return NG_OK;
}

static ng_result check_weight(const struct reader *r, uint32_t i)
{
    const struct lf_value *weight = operand(r, i);
    if (weight->domain != LF_DOMAIN_LIGHT || weight->channels != 1)
        return refuse(r, "has the weight \"%s\", which is not one channel of a light", weight->name);
    return NG_OK;
}

static ng_result infer_sum(const struct reader *r, struct lf_value *out)
{
    const struct lf_value *x = operand(r, 0);
    if (x->domain != LF_DOMAIN_VIEW && x->domain != LF_DOMAIN_LIGHT)
        return refuse(r, "sums \"%s\", which is not of a light", x->name);
    if (r->op.in_count == 2)
        NG_TRY(check_weight(r, 1));
    out->domain = x->domain == LF_DOMAIN_VIEW ? LF_DOMAIN_PIXEL : LF_DOMAIN_FRAME;
    out->gather = true;
    return NG_OK;
}

static ng_result infer_attend(const struct reader *r, struct lf_value *out)
{
    const struct lf_value *query = operand(r, 0), *key = operand(r, 1), *value = operand(r, 2);
    if (query->domain != LF_DOMAIN_PIXEL)
        return refuse(r, "has the query \"%s\", which is not of a pixel", query->name);
    for (uint32_t i = 1; i < 3; i++)
        if (operand(r, i)->domain != LF_DOMAIN_LIGHT && operand(r, i)->domain != LF_DOMAIN_VIEW)
            return refuse(r, "reads \"%s\", which is not of a light", operand(r, i)->name);
    if (r->op.heads == 0 || key->channels != query->channels || key->channels % r->op.heads ||
        value->channels % r->op.heads)
        return refuse(
            r, "cannot share %" PRIu32 ", %" PRIu32 " and %" PRIu32 " channels among %" PRIu32 " heads",
            query->channels, key->channels, value->channels, r->op.heads);
    if (r->op.in_count == 4)
        NG_TRY(check_weight(r, 3));
    *out = (struct lf_value){
        .domain = LF_DOMAIN_PIXEL, .channels = value->channels, .level = query->level, .gather = true};
    return NG_OK;
}

static ng_result infer_mean(const struct reader *r, struct lf_value *out)
{
    if (!lf_is_rows(out->domain))
        return refuse(r, "averages \"%s\", which has no rows", operand(r, 0)->name);
    out->rows = (uint32_t)out->domain;
    out->domain = LF_DOMAIN_LIGHT;
    return NG_OK;
}

static ng_result infer_kind(const struct reader *r, struct lf_value *out)
{
    switch (r->op.kind) {
    case LF_OP_CONV:
        if (!lf_is_picture(out->domain))
            return refuse(r, "reads no picture");
        break;
    case LF_OP_CONCAT: {
        uint64_t sum = sum_of_channels(r);
        if (sum > LF_MAX_CHANNELS)
            return refuse(r, "makes more than %d channels", LF_MAX_CHANNELS);
        out->channels = (uint32_t)sum;
        break;
    }
    case LF_OP_SLICE:
        if (r->op.from >= r->op.to || r->op.to > out->channels)
            return refuse(r, "takes channels %" PRIu32 " to %" PRIu32 " of %" PRIu32, r->op.from, r->op.to,
                          out->channels);
        out->channels = r->op.to - r->op.from;
        break;
    case LF_OP_CLAMP:
        if (!(r->op.low <= r->op.high))
            return refuse(r, "has low above high");
        break;
    case LF_OP_ADD:
    case LF_OP_SUB:
    case LF_OP_MUL:
    case LF_OP_DIV:
    case LF_OP_MIN:
    case LF_OP_MAX:
    case LF_OP_DOT:
        return infer_pairwise(r, out);
    case LF_OP_LENGTH:
        out->channels = 1;
        break;
    case LF_OP_MEAN:
        return infer_mean(r, out);
    case LF_OP_POOL:
    case LF_OP_PACK:
    case LF_OP_UP:
    case LF_OP_UNPACK:
        return infer_picture(r, out);
    case LF_OP_SUM:
        return infer_sum(r, out);
    case LF_OP_ATTEND:
        return infer_attend(r, out);
    default:
        break;
    }
    return NG_OK;
}

static ng_result infer(const struct reader *r, struct lf_value *out)
{
    NG_TRY(join(r, r->op.in_count, out));
    out->rows = LF_NO_VALUE;
    NG_TRY(infer_kind(r, out));
    if (out->channels == 0 || out->channels > LF_MAX_CHANNELS)
        return refuse(r, "makes %" PRIu32 " channels; 1 to %d can be", out->channels, LF_MAX_CHANNELS);
    if (lf_is_rows(out->domain) && out->gather)
        return refuse(r, "makes rows of what only the gather knows");
    return NG_OK;
}

// ---- Weights --------------------------------------------------------------------------------------------

static ng_result widen(struct lf_net *net, const struct lf_tensor *t, const float **out)
{
    size_t count = (size_t)(t->size / 2);
    float *wide = malloc(count * sizeof *wide + 1);
    if (!wide || !ng_array_push(&net->widened, wide)) {
        free(wide);
        return ng_out_of_memory("the weights of a network");
    }
    for (size_t i = 0; i < count; i++)
        wide[i] = ng_half_to_float(((const uint16_t *)t->data)[i]);
    *out = wide;
    return NG_OK;
}

static ng_result find_tensor(struct reader *r, const char *suffix, uint32_t rank, const uint64_t *shape,
                             const float **out)
{
    char name[LF_NAME + 8];
    snprintf(name, sizeof name, "%s%s", r->op.name, suffix);
    const struct lf_tensor *t = lf_tensors_find(&r->net->file, name);
    if (!t)
        return refuse(r, "has no tensor \"%s\"", name);
    if (t->dtype != LF_F32 && t->dtype != LF_F16)
        return refuse(r, "has a tensor \"%s\" of type %s, not F32 or F16", name, lf_dtype_name(t->dtype));
    bool fits = t->rank == rank;
    uint64_t count = 1;
    for (uint32_t i = 0; fits && i < rank; i++) {
        fits = t->shape[i] == shape[i];
        count *= shape[i];
    }
    if (!fits)
        return refuse(r, "has a tensor \"%s\" of another shape: %" PRIu64 " x %" PRIu64 " is wanted", name,
                      shape[0], rank > 1 ? shape[1] : 1);
    if (t->dtype == LF_F16)
        NG_TRY(widen(r->net, t, out));
    else
        *out = t->data;
    for (uint64_t i = 0; i < count; i++)
        if (!isfinite((*out)[i]))
            return refuse(r, "has a tensor \"%s\" with a number that is not finite", name);
    bool *used = &r->used.items[t - r->net->file.list.items];
    r->net->parameters += *used ? 0 : count;
    *used = true;
    return NG_OK;
}

static ng_result find_weights(struct reader *r)
{
    uint64_t in = sum_of_channels(r);
    if (in > LF_MAX_CHANNELS || r->channels == 0)
        return refuse(r, "multiplies %" PRIu64 " by %" PRIu32 " channels; 1 to %d can be", in, r->channels,
                      LF_MAX_CHANNELS);
    bool conv = r->op.kind == LF_OP_CONV;
    const uint64_t shape[] = {r->channels, in, 3, 3};
    NG_TRY(find_tensor(r, ".weight", conv ? 4 : 2, shape, &r->op.weight));
    return find_tensor(r, ".bias", 1, shape, &r->op.bias);
}

static ng_result check_tensors(const struct reader *r)
{
    for (size_t i = 0; i < r->net->file.list.count; i++)
        if (!r->used.items[i]) {
            ng_log_error("%s: no operation names its tensor \"%s\"", r->path,
                         r->net->file.list.items[i].name);
            return NG_ERROR_FORMAT;
        }
    return NG_OK;
}

// ---- The whole ------------------------------------------------------------------------------------------

static ng_result read_op(struct reader *r)
{
    struct lf_value out;
    NG_TRY(read_text(r));
    NG_TRY(check_members(r));
    NG_TRY(infer(r, &out));
    if (r->op.kind == LF_OP_LINEAR || r->op.kind == LF_OP_CONV) {
        NG_TRY(find_weights(r));
        out.channels = r->channels;
    }
    memcpy(out.name, r->out, sizeof out.name);
    out.op = (uint32_t)r->net->ops.count;
    out.input = LF_NO_VALUE;
    r->op.out = (uint32_t)r->net->values.count;
    if (!ng_array_push(&r->net->values, out) || !ng_array_push(&r->net->ops, r->op))
        return ng_out_of_memory("a network");
    return NG_OK;
}

static ng_result find_outputs(const struct reader *r)
{
    static const char *const names[] = {"unshadowed", "direct", "indirect"};
    for (uint32_t i = 0; i < NG_COUNT(names); i++) {
        uint32_t value = find_value(r->net, names[i]);
        const struct lf_value *v = value == LF_NO_VALUE ? NULL : &r->net->values.items[value];
        if (!v || v->domain != LF_DOMAIN_PIXEL || v->level != 0 || v->channels != 3) {
            ng_log_error("%s: the program makes no \"%s\" of 3 channels a pixel", r->path, names[i]);
            return NG_ERROR_FORMAT;
        }
        r->net->outputs[i] = value;
    }
    return NG_OK;
}

static ng_result read_ops(struct reader *r)
{
    lf_json_open(&r->json, '[');
    for (; lf_json_more(&r->json, ']'); r->index++) {
        if (r->index == LF_MAX_OPS) {
            ng_log_error("%s: the program has more than %d operations", r->path, LF_MAX_OPS);
            return NG_ERROR_FORMAT;
        }
        NG_TRY(read_op(r));
    }
    if (!lf_json_end(&r->json))
        return refuse_text(r);
    NG_TRY(find_outputs(r));
    return check_tensors(r);
}

ng_result lf_program_read(struct lf_net *net, const char *path, const char *json)
{
    struct reader r = {.net = net, .path = path, .json = lf_json_begin(json, strlen(json))};
    ng_result result = NG_ERROR_MEMORY;
    if (!add_input_values(net) || !ng_array_resize(&r.used, net->file.list.count))
        result = ng_out_of_memory("a network");
    else
        result = read_ops(&r);
    ng_array_finish(&r.used);
    return result;
}

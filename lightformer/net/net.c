// Reading a network: the file, its metadata, its program.
#include "lightformer/net/program_internal.h"

#include "base/log.h"

#include <stdlib.h>
#include <string.h>

#define FORMAT  "lightformer-net"
#define VERSION "1"

static ng_result check_notes(const struct lf_net *net, const char *path)
{
    const char *format = lf_net_note(net, "format"), *version = lf_net_note(net, "version");
    if (!format || strcmp(format, FORMAT) != 0) {
        ng_log_error("%s: is no network: its metadata says format \"%s\", not \"" FORMAT "\"", path,
                     format ? format : "");
        return NG_ERROR_FORMAT;
    }
    if (!version || strcmp(version, VERSION) != 0) {
        ng_log_error("%s: is a network of version \"%s\"; this program reads version " VERSION
                     "; use one that is as new",
                     path, version ? version : "");
        return NG_ERROR_FORMAT;
    }
    const char *inputs = lf_net_note(net, "inputs");
    if (inputs && strtoul(inputs, NULL, 10) > strtoul(LF_INPUTS_VERSION, NULL, 10)) {
        ng_log_error("%s: was trained with inputs of version \"%s\", newer than this program's "
                     "(" LF_INPUTS_VERSION "); use a newer program",
                     path, inputs);
        return NG_ERROR_FORMAT;
    }
    if (!inputs || strcmp(inputs, LF_INPUTS_VERSION) != 0) {
        ng_log_error("%s: was trained with inputs of version \"%s\", which this program no longer makes (its "
                     "own: " LF_INPUTS_VERSION "); train it anew",
                     path, inputs ? inputs : "");
        return NG_ERROR_FORMAT;
    }
    if (!lf_net_note(net, "program")) {
        ng_log_error("%s: is a network without a program in its metadata", path);
        return NG_ERROR_FORMAT;
    }
    return NG_OK;
}

static ng_result load(struct lf_net *net, const char *path)
{
    NG_TRY(lf_tensors_read(path, &net->file));
    NG_TRY(check_notes(net, path));
    NG_TRY(lf_program_read(net, path, lf_net_note(net, "program")));
    return lf_program_simplify(net);
}

ng_result lf_net_load(const char *path, struct lf_net **out)
{
    struct lf_net *net = calloc(1, sizeof *net);
    if (!net)
        return ng_out_of_memory(path);
    ng_result result = load(net, path);
    if (result != NG_OK)
        lf_net_destroy(&net);
    *out = net;
    return result;
}

void lf_net_destroy(struct lf_net **net)
{
    struct lf_net *n = *net;
    if (!n)
        return;
    for (size_t i = 0; i < n->widened.count; i++)
        free(n->widened.items[i]);
    ng_array_finish(&n->widened);
    ng_array_finish(&n->values);
    ng_array_finish(&n->ops);
    lf_tensors_finish(&n->file);
    free(n);
    *net = NULL;
}

bool lf_net_reads(const struct lf_net *net, enum lf_net_input input)
{
    for (size_t i = 0; i < net->ops.count; i++)
        for (uint32_t k = 0; k < net->ops.items[i].in_count; k++)
            if (net->ops.items[i].in[k] == (uint32_t)input)
                return true;
    for (size_t i = 0; i < NG_COUNT(net->outputs); i++)
        if (net->outputs[i] == (uint32_t)input)
            return true;
    return false;
}

const char *lf_net_note(const struct lf_net *net, const char *key)
{
    return lf_tensors_noted(&net->file, key);
}

uint64_t lf_net_parameters(const struct lf_net *net)
{
    return net->parameters;
}

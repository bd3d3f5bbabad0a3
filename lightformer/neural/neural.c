#include "lightformer/neural/neural.h"

#include "base/file.h"
#include "base/log.h"
#include "lightformer/gather/gather.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct lf_neural {
    struct lf_net *net;
    struct lf_net_executor *executor;
    struct lf_encoder *encoder;
    struct lf_gather *gather;
    struct lf_raycast *raycast;
    struct ng_composer *composer; // null: in none
};

static ng_result create_parts(struct lf_neural *n, const struct lf_neural_params *p)
{
    NG_TRY(lf_net_load(p->weights, &n->net));
    NG_TRY(lf_net_executor_create(
        &(struct lf_net_executor_params){
            .net = n->net, .jobs = p->jobs, .kernel = p->kernel, .compact = true},
        &n->executor));
    NG_TRY(lf_encoder_create(&(struct lf_encoder_params){.net = n->net,
                                                         .executor = n->executor,
                                                         .jobs = p->jobs,
                                                         .method = LF_NEURAL_METHOD,
                                                         .rsm = p->rsm,
                                                         .reflection_rays = p->reflection_rays,
                                                         .memory_limit = p->memory_limit},
                             &n->encoder));
    NG_TRY(lf_raycast_create(
        &(struct lf_raycast_params){.jobs = p->jobs, .method = LF_NEURAL_METHOD, .use = p->gbuffer},
        &n->raycast));
    return lf_gather_create(
        &(struct lf_gather_params){.executor = n->executor, .jobs = p->jobs, .method = LF_NEURAL_METHOD},
        &n->gather);
}

ng_result lf_neural_create(const struct lf_neural_params *params, struct lf_neural **out)
{
    *out = NULL;
    NG_REQUIRE(params->weights, "the neural method needs weights");
    struct lf_neural *n = calloc(1, sizeof *n);
    if (!n)
        return ng_out_of_memory("the neural method");
    ng_result result = create_parts(n, params);
    if (result != NG_OK)
        lf_neural_destroy(&n);
    *out = n;
    return result;
}

void lf_neural_destroy(struct lf_neural **neural)
{
    struct lf_neural *n = *neural;
    *neural = NULL;
    if (!n)
        return;
    lf_neural_leave(n);
    lf_raycast_destroy(&n->raycast);
    lf_gather_destroy(&n->gather);
    lf_encoder_destroy(&n->encoder);
    lf_net_executor_destroy(&n->executor);
    lf_net_destroy(&n->net);
    free(n);
}

ng_result lf_neural_join(struct lf_neural *n, struct ng_composer *composer)
{
    NG_REQUIRE(!n->composer, "the neural method is in a composer already");
    const struct ng_provider gather = lf_gather_provider(n->gather);
    NG_TRY(lf_encoder_join(n->encoder, composer));
    n->composer = composer;
    NG_TRY(lf_raycast_join(n->raycast, composer));
    return ng_composer_register(composer, &gather);
}

void lf_neural_leave(struct lf_neural *n)
{
    if (!n->composer)
        return;
    ng_composer_unregister(n->composer, lf_gather_provider(n->gather).name);
    lf_raycast_leave(n->raycast);
    lf_encoder_leave(n->encoder);
    n->composer = NULL;
}

const struct lf_net *lf_neural_net(const struct lf_neural *n)
{
    return n->net;
}

ng_result lf_neural_clue(const struct lf_neural *n, const char *clue, struct lf_clue *out)
{
    return lf_encoder_clue(n->encoder, clue, out);
}

struct lf_neural_counters lf_neural_counters_of(const struct lf_neural *n)
{
    return (struct lf_neural_counters){.encoder = lf_encoder_counters_of(n->encoder),
                                       .gather = lf_gather_runs(n->gather)};
}

bool lf_neural_find_weights(const char *scene, char *out, size_t size)
{
    const char *extension = ng_path_extension(scene);
    size_t stem = strlen(scene) - strlen(extension);
    if (*extension)
        stem--; // the dot
    int length = snprintf(out, size, "%.*s.weights.safetensors", (int)stem, scene);
    return length > 0 && (size_t)length < size && ng_file_exists(out) && ng_file_is_below(out, scene);
}

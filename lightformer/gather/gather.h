// The gather node: all embeddings of a frame, whatever light they come from, become radiance at the camera
// (paper, section 5).
//
// Consumes lf_encoded_pixels_item and the list of lf_embedding_item (lightformer/encode/encoder.h), publishes
// ng_radiance_item (render/frame.h). The pass "gather" makes planes, which stay where neither clues,
// encodings nor powers changed; "<method>/unshadowed", "<method>/direct" and "<method>/indirect" make images
// of them where a frame asks for these. All run on the host. No light gives black.
#ifndef LF_GATHER_GATHER_H
#define LF_GATHER_GATHER_H

#include "base/extern_c.h"
#include "graph/provider.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct lf_gather;
struct lf_net_executor;

struct lf_gather_params {
    struct lf_net_executor *executor; // needed, borrowed
    struct ng_jobs *jobs;             // borrowed; null: the caller's thread alone
    const char *method;               // needed, borrowed: the name it publishes under
};

NG_NODISCARD ng_result lf_gather_create(const struct lf_gather_params *params, struct lf_gather **out);
void lf_gather_destroy(struct lf_gather **gather);
struct ng_provider lf_gather_provider(struct lf_gather *gather);
uint64_t lf_gather_runs(const struct lf_gather *gather); // how often it has gathered so far

NG_EXTERN_C_END

#endif

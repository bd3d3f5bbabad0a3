// What --clue NAME=FILE.exr of lightformer render asks for: inputs of the network and embeddings as EXR
// files.
#ifndef LIGHTFORMER_RENDER_CLUES_H
#define LIGHTFORMER_RENDER_CLUES_H

#include "options.h"

#include "base/result.h"

struct lf_neural;
struct ng_graph;

// The files of such options; false, reported, if one is not of that form.
bool render_clues_check(const struct cli_texts *clues);
const char *render_clue_file(const char *clue);
// The graph's buffers that hold them: to be read back with the frame. Owned by the caller, one a clue.
struct render_clues {
    char names[CLI_MAX_TEXTS][256];
    const char *resources[CLI_MAX_TEXTS];
};
void render_clues_name(const struct cli_texts *clues, struct render_clues *out);
// After the frame. What fails is logged, and does not keep the others from being written.
NG_NODISCARD ng_result render_clues_write(const struct cli_texts *clues, const struct render_clues *named,
                                          struct ng_graph *graph, const struct lf_neural *neural);

#endif

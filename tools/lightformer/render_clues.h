// What --clue NAME=FILE.exr of lightformer render asks for: inputs of the network and embeddings as EXR
// files.
#ifndef LIGHTFORMER_RENDER_CLUES_H
#define LIGHTFORMER_RENDER_CLUES_H

#include "options.h"

#include "base/result.h"

struct lf_neural;
struct ng_graph;

#define RENDER_MOST_CLUES 64

// The files of such options; false, reported, if one is not of that form or there are too many.
bool render_clues_check(const struct cli_texts *clues);
const char *render_clue_file(const char *clue);
// The graph's buffers that hold them: to be read back with the frame. Owned by the caller, one a clue.
struct render_clues {
    char names[RENDER_MOST_CLUES][256];
    const char *resources[RENDER_MOST_CLUES];
};
void render_clues_name(const struct cli_texts *clues, struct render_clues *out);
// After the frame. What fails is logged, and does not keep the others from being written.
NG_NODISCARD ng_result render_clues_write(const struct cli_texts *clues, const struct render_clues *named,
                                          struct ng_graph *graph, const struct lf_neural *neural);

#endif

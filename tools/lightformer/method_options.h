// What --method and --gbuffer take: the methods of lightformer/methods/methods.h, and "auto".
#ifndef LIGHTFORMER_METHOD_OPTIONS_H
#define LIGHTFORMER_METHOD_OPTIONS_H

#include <stdint.h>

// As in enum lf_raycast_use of lightformer/raycast/raycast.h; null-terminated.
extern const char *const method_gbuffers[];

// All names, then "auto"; null past the end.
const char *method_option(uint32_t index);
// The same without methods that need many frames for a picture: bench has one.
const char *method_bench_option(uint32_t index);
// Which method such a word means: an index into the table.
uint32_t method_choose(const char *option, const char *scene, const char *weights);

#endif

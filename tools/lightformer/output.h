// Pictures on disk: the layers of a renderer's last frame as EXR, or what a display shows as PNG, each with
// what made it in its metadata.
#ifndef LIGHTFORMER_OUTPUT_H
#define LIGHTFORMER_OUTPUT_H

#include "base/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct ng_renderer;

// What a picture follows from: no more and no less than this goes into its metadata.
struct output_origin {
    const char *command; // canonical (options.h)
    uint64_t scene_hash; // of the scene file's bytes
};

// True if the name ends in a format that output_write knows: .exr or .png.
bool output_knows(const char *path);
// The layer that such a file needs besides those asked for: "beauty" or "display".
const char *output_base_layer(const char *path);
// "name.exr" -> "name.0007.exr". False if it does not fit.
bool output_numbered(const char *path, uint32_t frame, char *out, size_t size);

// Writes the last frame. An EXR holds `layers`, of which "beauty" has no prefix; a PNG holds "display". All
// of them must have been asked for in that frame.
NG_NODISCARD ng_result output_write(const char *path, struct ng_renderer *renderer, const char *const *layers,
                                    uint32_t layer_count, const struct output_origin *origin);

#endif

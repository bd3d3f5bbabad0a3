// Pictures on disk: layers as EXR, or what a display shows as PNG, each with what made it in its metadata.
#ifndef LIGHTFORMER_OUTPUT_H
#define LIGHTFORMER_OUTPUT_H

#include "base/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OUTPUT_MAX_LAYERS 24

// A layer, borrowed from whatever made the picture.
struct output_layer {
    const char *name;
    const char *const *channel_names; // within the layer: "R"
    uint32_t channels;
    bool uint;          // uint32_t instead of float
    const void *pixels; // [height][width][channels]
};

struct output_picture {
    uint32_t width, height;
    const struct output_layer *layers; // of an EXR; "beauty" has no prefix
    uint32_t layer_count;
    const uint8_t *display; // of a PNG: RGBA, sRGB-encoded
};

// What a picture follows from: no more and no less than this goes into its metadata.
struct output_origin {
    const char *command; // canonical (options.h)
    uint64_t scene_hash; // of the bytes of the scene's files (asset/gltf.h)
};

// True if the name ends in a format that output_write knows: .exr or .png.
bool output_knows(const char *path);
// The layer that such a file needs besides those asked for: "beauty" or "display".
const char *output_base_layer(const char *path);
// "name.exr" -> "name.0007.exr". False if it does not fit.
bool output_numbered(const char *path, uint32_t frame, char *out, size_t size);

NG_NODISCARD ng_result output_write(const char *path, const struct output_picture *picture,
                                    const struct output_origin *origin);

// The bytes of a PNG, from malloc.
NG_NODISCARD ng_result output_encode_png(const struct output_picture *picture,
                                         const struct output_origin *origin, void **data, size_t *size);

#endif

// OpenEXR pictures with any number of named channels, through OpenEXRCore.
//
// Source: OpenEXR 3.1 technical introduction; channel and layer names follow engine/README.md.
#ifndef NG_ASSET_EXR_H
#define NG_ASSET_EXR_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

enum ng_exr_type { NG_EXR_UINT, NG_EXR_HALF, NG_EXR_FLOAT }; // as the format numbers them

// A string attribute of the header.
struct ng_exr_text {
    const char *name, *value;
};

// A channel to write. In memory a UINT channel is uint32_t, the other two are float.
struct ng_exr_channel {
    const char *name; // "R", "direct.R", "entity.id"; any order, no name twice
    enum ng_exr_type type;
    const void *pixels; // first pixel of row 0, the top
    uint32_t stride;    // 4-byte elements from one pixel to the next; 0: 1 (planar)
};

struct ng_exr_params {
    uint32_t width, height;
    const struct ng_exr_channel *channels;
    uint32_t channel_count;
    const struct ng_exr_text *texts;
    uint32_t text_count;
};

// Scan lines, ZIP compression. Written beside the path and renamed when complete: readers see the old file or
// the new one. The bytes depend on the parameters alone.
NG_NODISCARD ng_result ng_exr_write(const char *path, const struct ng_exr_params *params);
// The file's bytes alone, from malloc. `name` is for messages.
NG_NODISCARD ng_result ng_exr_encode(const char *name, const struct ng_exr_params *params, void **data,
                                     size_t *size);

struct ng_exr_plane {
    char *name;
    enum ng_exr_type type; // in the file
    void *pixels;          // [height][width], uint32_t for NG_EXR_UINT, else float
};

struct ng_exr {
    uint32_t width, height; // of the data window
    uint32_t plane_count, text_count;
    struct ng_exr_plane *planes; // in the file's order: by name
    struct ng_exr_text *texts;   // string attributes
    // What of it is the picture: from the data window's corner, and how large; it may be beyond the data.
    int64_t display_x, display_y, display_width, display_height;
    bool has_chromaticities; // else those of Rec. 709
    float chromaticities[8]; // x and y of red, green, blue and white
};

struct ng_exr_limits {
    uint32_t max_side;   // pixels; 0: 16,384
    uint64_t max_memory; // bytes of decoded pixels; 0: 1 GiB
    const char *limit;   // what messages call it, or null: as in struct ng_image_params
};

// Reads the first part: scan lines or tiles (level 0), unsubsampled channels. Refused with one line: deep
// data, DWAA and DWAB compression (OpenEXRCore 3.1 cannot read them), more than the limits, malformed files.
// The caller owns `*out` and calls ng_exr_finish.
NG_NODISCARD ng_result ng_exr_read(const char *path, const struct ng_exr_limits *limits, struct ng_exr *out);
NG_NODISCARD ng_result ng_exr_decode(const char *name, const void *data, size_t size,
                                     const struct ng_exr_limits *limits, struct ng_exr *out);
void ng_exr_finish(struct ng_exr *exr);

// Borrowed; null if there is none of that name.
const struct ng_exr_plane *ng_exr_plane(const struct ng_exr *exr, const char *name);
const char *ng_exr_text(const struct ng_exr *exr, const char *name);

NG_EXTERN_C_END

#endif

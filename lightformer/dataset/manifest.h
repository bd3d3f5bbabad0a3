// What is in the folder of a data set: manifest.json, with the settings that all shards share and a line for
// each shard. It follows from the shards alone: equal shards, equal manifest.
//
//     {"settings": {"format": "1", "program": "0.1.0", "scene": "chess.glb", "scene_hash": "...", "size":
//     "512", ...},
//      "shards": [{"file": "shard-0000000000-0000000015.safetensors", "first_seed": 0, "samples": 16,
//                  "hash": "..."}, ...]}
#ifndef LF_DATASET_MANIFEST_H
#define LF_DATASET_MANIFEST_H

#include "base/extern_c.h"
#include "lightformer/tensors/tensors.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

#define LF_SETTING_COUNT 12

struct lf_setting {
    char key[32], value[96];
};

// The settings as words, in this order: format, program, scene, scene_hash, size, crop, crops, spp, depth,
// vpls, camera, time.
struct lf_settings {
    struct lf_setting items[LF_SETTING_COUNT];
};

struct lf_shard {
    uint64_t first_seed, hash;
    uint32_t samples;
};

struct lf_manifest {
    struct lf_settings settings;
    NG_ARRAY(struct lf_shard) shards; // by seed, none overlapping
};

// "DIR/shard-FIRST-LAST.safetensors", seeds with ten digits. False if it does not fit.
bool lf_shard_path(const char *directory, const struct lf_shard *shard, char *out, size_t size);
// What follows a shard's name at the beginning of `name` ("" if nothing does), or null: not one of a shard.
const char *lf_shard_of_name(const char *name, struct lf_shard *out);
// The first setting in which two differ, or null.
const struct lf_setting *lf_settings_difference(const struct lf_settings *a, const struct lf_settings *b);

// NG_ERROR_NOT_FOUND, silently, if the folder has none; NG_ERROR_FORMAT, logged, if it is not one.
NG_NODISCARD ng_result lf_manifest_read(const char *directory, struct lf_manifest *out);
NG_NODISCARD ng_result lf_manifest_write(const char *directory, const struct lf_manifest *manifest);
// Enters a shard, in order of seeds, in place of those that it overlaps.
NG_NODISCARD ng_result lf_manifest_put(struct lf_manifest *manifest, const struct lf_shard *shard);
// The line of the shard with these seeds, or null.
const struct lf_shard *lf_manifest_find(const struct lf_manifest *manifest, const struct lf_shard *shard);
void lf_manifest_finish(struct lf_manifest *manifest);

// Reads a shard and checks that it is what the settings and its seeds say. `shard->hash` 0: any hash will do.
// Errors, logged, as lf_tensors_read; NG_ERROR_FORMAT.
NG_NODISCARD ng_result lf_shard_read(const char *directory, const struct lf_settings *settings,
                                     const struct lf_shard *shard, struct lf_tensors *out);
// The same for a file that may well be damaged, told as lf_tensors_try does; NG_ERROR_UNSUPPORTED for a whole
// one of other settings. `path`: of the shard.
NG_NODISCARD ng_result lf_shard_try(const char *path, const struct lf_settings *settings,
                                    const struct lf_shard *shard, struct lf_tensors *out, const char **wrong);

NG_EXTERN_C_END

#endif

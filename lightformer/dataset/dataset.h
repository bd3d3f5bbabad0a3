// Data sets: samples of a scene by seed, in shards (README.md describes folder and tensors).
//
// Shards are aligned: with n samples a shard, each holds the seeds from a multiple of n to the next, as far
// as they were asked for. So machines that make ranges which begin and end at multiples of n make the files
// that one run would have made.
#ifndef LF_DATASET_DATASET_H
#define LF_DATASET_DATASET_H

#include "base/extern_c.h"
#include "lightformer/dataset/sample.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct ng_assets;
struct ng_gpu;
struct ng_world;

#define LF_DATASET_MAX_SIZE 4096 // pixels a side of a frame

struct lf_dataset_params {
    struct ng_world *world; // the scene, with the systems of render/scene_systems.h
    const struct ng_assets *assets;
    struct ng_gpu *gpu;
    struct ng_jobs *jobs;  // null: this thread
    const char *directory; // made if missing; left empty by an error, it goes again
    const char *program;   // version
    const char *scene;     // name of its file
    uint64_t scene_hash;   // of its files' bytes (asset/gltf.h)
    const char *camera;    // name; null: the first
    double time;           // where time does not vary, seconds
    uint64_t seed;         // of the first sample; the last one's is at most 2^32 - 1
    uint32_t count;        // samples
    uint32_t size;         // of the frame, pixels a side
    uint32_t crop;         // pixels a side; 0: whole frames
    uint32_t crops;        // of each frame
    uint32_t spp;          // samples a pixel of the targets
    uint32_t depth; // segments of their paths, the camera's included (Mitsuba's max_depth); 0: no limit
    uint32_t shard; // crops a shard (one sample at least)
    uint32_t vpls;  // direct VPLs of a light; 0: LF_VPL_COUNT
    // The folder of a data set that differs in its inputs alone (an earlier format): its targets are taken,
    // where it has them. Null: all are traced.
    const char *targets;
    // Called after each sample, also for those that were there already; false stops. May be null.
    bool (*progress)(void *user, uint32_t done, uint32_t count);
    void *user;
};

struct lf_dataset_report {
    uint32_t samples, crops; // made, not those that were there
    uint32_t shards;         // of the whole range
    uint32_t kept, redone;   // shards that were there: whole, and damaged
    double seconds;          // of the work
    double spent[LF_STAGES]; // of which
};

// Makes what is missing. Errors, logged: NG_ERROR_FORMAT (values that make no sense; a folder that holds
// another data set; a scene that cannot be sampled), NG_ERROR_MEMORY, NG_ERROR_IO (a full disk: the shards
// written so far are whole, and another run goes on from them).
NG_NODISCARD ng_result lf_dataset_make(const struct lf_dataset_params *params,
                                       struct lf_dataset_report *report);

// Reads every shard that the manifest lists. All damage is logged, with a warning if the folder has shards
// that are not listed; NG_ERROR_FORMAT if there is any, NG_ERROR_NOT_FOUND if there is no data set.
struct lf_dataset_contents {
    uint32_t shards, damaged, unlisted; // the last are in no other number
    uint64_t samples, tensors, bytes;
};
NG_NODISCARD ng_result lf_dataset_check(const char *directory, struct lf_dataset_contents *out);

// A PNG of the first `rows` crops (0: 16) of a data set, all channels side by side, a crop each row.
NG_NODISCARD ng_result lf_dataset_contact_sheet(const char *directory, const char *path, uint32_t rows);

NG_EXTERN_C_END

#endif

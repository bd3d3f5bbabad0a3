// One sample as tensors: the inputs of the network and the targets, for crops of its frame. Inputs are
// computed for the whole frame, as at run time, and then cut.
#ifndef LF_DATASET_SAMPLE_H
#define LF_DATASET_SAMPLE_H

#include "base/extern_c.h"
#include "lightformer/dataset/capture.h"
#include "lightformer/tensors/tensors.h"

NG_EXTERN_C_BEGIN

struct lf_sample;
struct lf_sample_writer; // memory that samples share
struct ng_jobs;

NG_NODISCARD ng_result lf_sample_writer_create(struct lf_sample_writer **out);
void lf_sample_writer_destroy(struct lf_sample_writer **writer);

enum lf_stage { LF_STAGE_VARY, LF_STAGE_CAPTURE, LF_STAGE_ENCODE, LF_STAGE_TRACE, LF_STAGE_WRITE, LF_STAGES };
extern const char *const lf_stage_names[LF_STAGES]; // "vary", ...

struct lf_sample_params {
    uint32_t size;        // of the frame, pixels a side
    uint32_t crop, crops; // of a crop, pixels a side; how many
    uint32_t spp;         // samples a pixel of the targets
    uint32_t vpls;        // direct VPLs of a light; 0: LF_VPL_COUNT
    uint32_t depth;       // as in struct lf_reference_params
    struct ng_jobs *jobs; // borrowed; null: this thread
    // A shard of a data set of these settings, borrowed: targets of the sample that it holds are taken from
    // it instead of traced. May be null.
    const struct lf_tensors *targets;
};

// Bytes that a sample's tensors take at least, with one light: to be asked before anything is made. A double,
// since absurd sizes are what it is asked about.
double lf_sample_least_bytes(const struct lf_sample_params *params);

// Adds the tensors of README.md, named "SEED/...", to `out`. `observation`: its G-buffer is enough; adds the
// time of each stage, seconds, to `spent`. Errors, logged: NG_ERROR_FORMAT (a number that is not finite, with
// tensor, pixel and seed), NG_ERROR_MEMORY.
NG_NODISCARD ng_result lf_sample_write(struct lf_sample_writer *writer, const struct lf_sample *sample,
                                       const struct lf_captured_frame *observation,
                                       const struct lf_sample_params *params, struct lf_tensors *out,
                                       double spent[LF_STAGES]);

NG_EXTERN_C_END

#endif

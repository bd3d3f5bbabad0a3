// A network: a program (README.md) with its weights, and what runs it.
//
//     struct lf_net *net;
//     NG_TRY(lf_net_load("chess.safetensors", &net));
//     NG_TRY(lf_net_executor_create(&(struct lf_net_executor_params){.net = net, .jobs = jobs}, &executor));
//     // once a light that is new or changed:
//     NG_TRY(lf_net_encode_light(executor, encoding, &light_inputs));   // its vpl, texel and light values
//     // where the light, the camera or anything on screen changed:
//     NG_TRY(lf_net_encode_view(executor, encoding, &frame, &view_inputs)); // its pictures
//     // every frame:
//     NG_TRY(lf_net_gather(executor, &frame, encodings, count, &picture));
//
// The network is immutable and may be shared. An executor and its encodings belong to one thread at a time;
// it works on the threads of `jobs`. Memory grows on the first frames of a size and is then reused.
#ifndef LF_NET_NET_H
#define LF_NET_NET_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

NG_EXTERN_C_BEGIN

struct lf_net;
struct lf_net_executor;
struct lf_net_encoding; // what is kept of a light from frame to frame
struct ng_jobs;

enum lf_net_domain {
    LF_DOMAIN_FRAME,
    LF_DOMAIN_LIGHT,
    LF_DOMAIN_VPL,
    LF_DOMAIN_TEXEL,
    LF_DOMAIN_PIXEL,
    LF_DOMAIN_VIEW,
};

enum lf_net_input {
#define LF_INPUT(id, name, domain, channels, when) LF_INPUT_##id,
#include "lightformer/net/inputs.inc"
#undef LF_INPUT
    LF_INPUT_COUNT
};

struct lf_net_input_info {
    const char *name;
    enum lf_net_domain domain;
    uint32_t channels;
    bool gather; // only the gather may read it
};
extern const struct lf_net_input_info lf_net_inputs[LF_INPUT_COUNT];

// Errors, logged: those of ng_file_read; NG_ERROR_FORMAT: not a network, or one that this program cannot run,
// and why.
NG_NODISCARD ng_result lf_net_load(const char *path, struct lf_net **out);
void lf_net_destroy(struct lf_net **net);
// Whether the program reads an input: what it does not read need not be computed.
bool lf_net_reads(const struct lf_net *net, enum lf_net_input input);
// A word of the file's metadata ("family", "preset", "training", ...), or null.
const char *lf_net_note(const struct lf_net *net, const char *key);
uint64_t lf_net_parameters(const struct lf_net *net); // how many numbers were learned

// How numbers are multiplied. The fastest that the CPU has (base/cpu.h) is chosen unless a lower one is asked
// for; the results of the fp32 ones differ by rounding alone.
enum lf_net_kernel {
    LF_KERNEL_AUTO,
    LF_KERNEL_PLAIN,  // fp32, portable C
    LF_KERNEL_AVX2,   // fp32, FMA
    LF_KERNEL_AVX512, // fp32
    LF_KERNEL_BF16,   // AVX-512 bf16 products, fp32 sums
    LF_KERNEL_AMX,    // the same on AMX tiles
};

struct lf_net_executor_params {
    const struct lf_net *net;  // needed, borrowed
    struct ng_jobs *jobs;      // borrowed; null: the calling thread
    enum lf_net_kernel kernel; // NG_ERROR_UNSUPPORTED, logged, where ng_cpu_has() denies it
    // Pictures that last, and those that no neighbourhood is taken of, are kept in 16 bits a number where
    // products are fp32, too: half the memory of a light, for a squared error of about 1e-7 of the result.
    bool compact;
};
NG_NODISCARD ng_result lf_net_executor_create(const struct lf_net_executor_params *params,
                                              struct lf_net_executor **out);
void lf_net_executor_destroy(struct lf_net_executor **executor);
enum lf_net_kernel lf_net_executor_kernel(const struct lf_net_executor *executor);
// Whether the gather reads an input, other than those that only it may read.
bool lf_net_gather_reads(const struct lf_net_executor *executor, enum lf_net_input input);

// Bytes for pictures of a size: the executor's, an encoding's, and the gather's for each light. `light`: what
// an encoding holds of the light itself, whatever the picture.
struct lf_net_bytes {
    uint64_t light, work, encoding, gather;
};
struct lf_net_bytes lf_net_picture_bytes(const struct lf_net_executor *executor, uint32_t width,
                                         uint32_t height);
// Lends memory for pictures, at a multiple of 64 bytes; without, it is the object's own. What was written
// into it stays there as long as it is lent, but `fresh`: as if it were other memory.
void lf_net_executor_lend(struct lf_net_executor *executor, void *work, uint64_t size, bool fresh);
void lf_net_executor_lend_gather(struct lf_net_executor *executor, void *gather, uint64_t size, bool fresh);

const char *lf_net_kernel_name(enum lf_net_kernel kernel); // "avx512"

NG_NODISCARD ng_result lf_net_encoding_create(struct lf_net_executor *executor, struct lf_net_encoding **out);
void lf_net_encoding_destroy(struct lf_net_encoding **encoding);
void lf_net_encoding_lend_light(struct lf_net_encoding *encoding, void *vectors);
// Image `index` of the pictures that an encoding holds, after lf_net_encode_view, as
// [channels][height][width]; a null `out` asks for its size. False: it has fewer.
bool lf_net_encoding_image(const struct lf_net_encoding *encoding, uint32_t index, uint32_t *width,
                           uint32_t *height, uint32_t *channels, float *out);
void lf_net_encoding_lend(struct lf_net_encoding *encoding, void *pictures, uint64_t size, bool fresh);

// Input values by enum lf_net_input; null is all zeros. Rows: [channels][count]. Pictures:
// [channels][height][width]. Only those of the domains that a call names are read.
struct lf_net_values {
    const float *of[LF_INPUT_COUNT];
};

struct lf_net_light_inputs {
    const struct lf_net_values *values; // light, vpl, texel (and frame) inputs
    uint32_t vpl_count, texel_count;
};
NG_NODISCARD ng_result lf_net_encode_light(struct lf_net_executor *executor, struct lf_net_encoding *encoding,
                                           const struct lf_net_light_inputs *inputs);

struct lf_net_picture {
    uint32_t width, height;
    const struct lf_net_values *values; // frame and pixel inputs
};
// `view`: inputs of domain view. lf_net_encode_light comes first.
NG_NODISCARD ng_result lf_net_encode_view(struct lf_net_executor *executor, struct lf_net_encoding *encoding,
                                          const struct lf_net_picture *frame,
                                          const struct lf_net_values *view);

// What the gather reads of a light, beside its encoding.
struct lf_net_gathered {
    const struct lf_net_encoding *encoding;
    const struct lf_net_values *values; // inputs of domain light that only the gather may read; view inputs
                                        // that the gather part of the program reads
};

// Planes of 3 channels, [3][height][width], radiance W/(sr m2); null: not wanted.
struct lf_net_radiance {
    float *unshadowed, *direct, *indirect;
};
// No light gives black.
NG_NODISCARD ng_result lf_net_gather(struct lf_net_executor *executor, const struct lf_net_picture *frame,
                                     const struct lf_net_gathered *lights, uint32_t light_count,
                                     const struct lf_net_radiance *out);

// ---- Where the time goes --------------------------------------------------------------------------------

// Of one kind of operation in one stage, since profiling began; time is that of all threads together.
struct lf_net_figure {
    const char *stage;     // "light", "view", "gather"
    const char *operation; // "linear", "conv", "load", ...
    double ms, gflop;      // gflop: of multiplications and additions; 0 where they are not counted
    uint64_t tiles;        // how often it ran
};
#define LF_NET_MAX_FIGURES 128

// Starts anew, or stops. Reading the clock around every operation of a tile costs some percent.
void lf_net_profile(struct lf_net_executor *executor, bool on);
// Returns how many; those that never ran are left out.
uint32_t lf_net_figures(const struct lf_net_executor *executor, struct lf_net_figure out[LF_NET_MAX_FIGURES]);
// GFLOP/s of a kernel's multiplication in registers, on all threads: the roof of its products. 0 where the
// CPU does not have it.
double lf_net_peak(enum lf_net_kernel kernel, struct ng_jobs *jobs);

// What runs in which order, for people.
void lf_net_print_plan(const struct lf_net_executor *executor, FILE *out);

NG_EXTERN_C_END

#endif

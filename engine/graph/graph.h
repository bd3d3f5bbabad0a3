// The render graph: passes say what they use, the graph does the rest.
//
// Each frame is declared anew: resources, passes, and one word (graph/use.h) for each use of a resource by a
// pass. The declaration is compiled to a plan without a device (graph/plan.h), then run on the GPU and, for
// NG_PASS_CPU, on host threads. In return for the words the graph gives barriers and layouts, load and store
// operations, lifetimes, memory aliasing, culling, copies between GPU and host, submission, debug labels,
// CPU and GPU time of each pass, dumps, and readback of any resource by name.
//
//     ng_frame_begin(gpu, &cmd);                          // gpu/frame.h
//     ng_graph_begin(g);
//     struct ng_graph_ref image = ng_graph_add_image(g, "picture", &(struct ng_graph_image_params){
//         .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = 512, .height = 512});
//     struct ng_pass *pass = ng_graph_add_pass(g, &(struct ng_pass_params){
//         .name = "draw", .kind = NG_PASS_RASTER, .run = draw, .data = self});
//     ng_pass_read(pass, vertices, NG_USE_VERTEX);
//     image = ng_pass_write(pass, image, NG_USE_COLOR);   // later passes use the new version
//     ng_graph_export(g, image);
//     result = ng_graph_execute(g, &cmd);
//     ng_frame_end(gpu, &cmd);
//
// Versions: a resource starts at version 0 and each write makes the next one. ng_pass_write returns it; the
// one given is then stale, and using it again is an error. So the order of passes that share a resource is
// always the order in which the refs were handed on, and it cannot be got wrong silently.
//
// Errors: a mistake in a declaration is logged once, naming pass and resource; from then on the frame is
// broken, calls return harmless values, and ng_graph_compile returns the error. Nothing needs to be checked
// between ng_graph_begin and ng_graph_compile; to declare anything after that is a mistake, too.
//
// Culling: a pass runs if something that leaves the frame needs it: an export, a readback, a write to an
// imported, persistent or history resource (but see NG_PASS_ON_DEMAND), or NG_PASS_SIDE_EFFECT.
//
// Keys: a pass that says what it follows from (ng_pass_params.key, graph/key.h) need not run again where that
// and all that it reads are as they were. The graph hands keys on, from what a pass reads to what it writes,
// and a persistent resource remembers the key of its content. Where that is the key which the frame's passes
// would give it, it is current: they do not run for it, nor does whatever else only they needed. So a
// provider declares all of its passes in every frame, and the graph decides. Details with ng_pass_params.
//
// Threads: a graph belongs to one thread. Memory: names and descriptions are copied into the frame; nothing
// is allocated, neither on the host nor on the device, once the largest frame has been seen.
#ifndef NG_GRAPH_GRAPH_H
#define NG_GRAPH_GRAPH_H

#include "base/arena.h"
#include "base/extern_c.h"
#include "base/result.h"
#include "graph/use.h"

#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_cmd;
struct ng_gpu;
struct ng_gpu_buffer;
struct ng_gpu_image;
struct ng_jobs;
struct ng_graph;
struct ng_pass;
struct ng_pass_context;

struct ng_graph_params {
    struct ng_gpu *gpu;   // borrowed; null: declare, compile and dump only
    struct ng_jobs *jobs; // borrowed; given to passes; null: they run serially
    // For tests and hunting bugs; the pictures must not depend on them:
    bool no_culling;  // run passes that nothing needs
    bool no_aliasing; // give each resource memory of its own
    bool no_unified;  // copy buffers to and from CPU passes as if host memory were slow for the GPU
    bool no_keys;     // run passes whose results are there already
};

NG_NODISCARD ng_result ng_graph_create(const struct ng_graph_params *params, struct ng_graph **out);
// What the graph owns dies when the GPU is done with it.
void ng_graph_destroy(struct ng_graph **graph);
// From the next compilation on, as params.no_keys: for benchmarks.
void ng_graph_ignore_keys(struct ng_graph *g, bool ignore);

// Opens a frame; outside or inside of a frame of gpu/frame.h. Refs and passes of the last one are void from
// here on.
void ng_graph_begin(struct ng_graph *g);
// Memory that lives until the next ng_graph_begin: for what pass callbacks need. Zeroed; null if there is
// none.
void *ng_graph_alloc(struct ng_graph *g, size_t size);

// ---- Resources -----------------------------------------------------------------------------------------

// A version of a resource of this frame. Zero names nothing.
struct ng_graph_ref {
    uint64_t id;
};

// Names are unique within a frame; '/' groups them in dumps: "encode:lamp/rsm/depth".
struct ng_graph_image_params {
    VkFormat format;
    uint32_t width, height;
    uint32_t layers; // 0: 1
    uint32_t mips;   // 0: 1
    bool array;      // seen as an array by shaders even where layers is 1
    bool cube;       // layers is 6 n; seen by shaders as a cube (n = 1, not `array`) or cube array
    bool clear;      // starts as clear_value; otherwise its first content is undefined
    VkClearValue clear_value;
};

struct ng_graph_buffer_params {
    uint64_t size; // bytes
    bool clear;    // starts as clear_word repeated (size a multiple of 4)
    uint32_t clear_word;
    // Room to work in: what a pass leaves there matters to no other. So it needs no pass, and has no part in
    // keys. A persistent one keeps its bytes; `*valid` says whether they are there.
    bool scratch;
};

// Transient: lives from its first to its last use within the frame, in memory shared with others.
struct ng_graph_ref ng_graph_add_image(struct ng_graph *g, const char *name,
                                       const struct ng_graph_image_params *params);
struct ng_graph_ref ng_graph_add_buffer(struct ng_graph *g, const char *name,
                                        const struct ng_graph_buffer_params *params);

// Persistent: owned by the graph under its name, keeps content from frame to frame. A frame may read it
// without declaring a pass that writes it. `*valid` (may be null) is set to whether it has content: false
// when it is new, when its description or its owner (graph/provider.h) is another, or when the last pass that
// should have written it did not run; then a pass must write it, or the clear value is its content. It lives
// as long as every frame declares it: a frame that leaves it out releases it. It takes memory from the first
// frame on in which a pass that runs uses it.
//
// Passes that all have keys make it anew, from its clear value or from nothing, whenever one of them has to
// run. Others find what was there.
struct ng_graph_ref ng_graph_persistent_image(struct ng_graph *g, const char *name,
                                              const struct ng_graph_image_params *params, bool *valid);
struct ng_graph_ref ng_graph_persistent_buffer(struct ng_graph *g, const char *name,
                                               const struct ng_graph_buffer_params *params, bool *valid);

// Token: stands for what a pass makes outside of the graph's memory, a ray scene say. It takes no memory,
// orders passes, and makes them needed as others are. It hands no key on: what a reader follows from there,
// it says in its own key. CPU passes write it by NG_USE_HOST_WRITE and read it by NG_USE_HOST_READ.
struct ng_graph_ref ng_graph_add_token(struct ng_graph *g, const char *name);

// History: what the image or buffer `name` of the same description, declared in this frame by
// ng_graph_add_image or ng_graph_add_buffer (before or after this call), held at the end of the last frame
// that wrote it. Read only. When there is none (first frame, changed description) `*valid` is false and the
// content is the clear value, or zero without one.
struct ng_graph_ref ng_graph_history_image(struct ng_graph *g, const char *name,
                                           const struct ng_graph_image_params *params, bool *valid);
struct ng_graph_ref ng_graph_history_buffer(struct ng_graph *g, const char *name,
                                            const struct ng_graph_buffer_params *params, bool *valid);

// Imported: owned by someone else, used as it is found and left as it is wanted. Borrowed until the frame has
// been executed; gpu/frame.h keeps what is destroyed later alive for the GPU. Everything submitted before the
// frame is visible to it.
struct ng_graph_import {
    enum ng_use initial; // last use before the frame, hence its layout; NONE: no content worth keeping
    enum ng_use final;   // use after the frame; NONE: left as the last pass had it
};
struct ng_graph_ref ng_graph_import_image(struct ng_graph *g, const char *name, struct ng_gpu_image *image,
                                          const struct ng_graph_import *import);
// CPU passes may use it if it is mapped.
struct ng_graph_ref ng_graph_import_buffer(struct ng_graph *g, const char *name, struct ng_gpu_buffer *buffer,
                                           const struct ng_graph_import *import);

// Keeps this version: what it needs is not culled, its memory is not shared after its last use. For resources
// whose result is fetched by other means than the sinks above.
void ng_graph_export(struct ng_graph *g, struct ng_graph_ref ref);

// ---- Passes --------------------------------------------------------------------------------------------

// Records commands, or for CPU passes does the work. A failure is the callback's to log; the frame goes on
// with the next pass, ng_graph_execute returns the first failure, and persistent resources the pass writes
// count as not valid. A pass with a key that reads what a failed pass should have written fails, too, without
// being run.
typedef ng_result (*ng_pass_fn)(const struct ng_pass_context *ctx);

enum {
    NG_PASS_SIDE_EFFECT = 1, // runs even if nothing needs what it writes
    // Writing persistent resources is no reason to run: only if this frame reads what the pass writes. What a
    // culled pass would have written is not valid in the next frame, unless it has a key: then the content
    // that is there is still that of its own key.
    NG_PASS_ON_DEMAND = 2,
};

struct ng_pass_params {
    const char *name; // unique within a frame; '/' groups
    enum ng_pass_kind kind;
    ng_pass_fn run;
    const void *data; // for the callback
    size_t data_size; // not 0: data is copied into the frame, so that it may be a local variable
    uint32_t flags;
    uint32_t width, height; // raster without attachments: render area
    // Not 0: what the pass writes is a function of what this stands for and of what it reads, bit for bit.
    // `run` and the descriptions of what it writes count, too.
    uint64_t key;
};

// Never null. Runs after passes declared before it, unless ng_pass_after says otherwise.
struct ng_pass *ng_graph_add_pass(struct ng_graph *g, const struct ng_pass_params *params);
void ng_pass_read(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use);
// The same where only a part of that content matters, or none: `key` stands for it, instead of the content's
// own.
void ng_pass_read_as(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use, uint64_t key);
// Returns the version written. Content outside of what the pass writes is kept, except by NG_USE_HOST_WRITE.
struct ng_graph_ref ng_pass_write(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use);

// Part of an image; counts of 0 mean "all from the base on" when sampled or stored, and for attachments one
// mip and all layers from the base on.
struct ng_graph_part {
    uint32_t mip, mip_count, layer, layer_count;
};
void ng_pass_read_part(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use,
                       const struct ng_graph_part *part);
struct ng_graph_ref ng_pass_write_part(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use,
                                       const struct ng_graph_part *part);
// Orders this pass after the pass of that name, which may be declared later, for reasons that no resource
// shows.
void ng_pass_after(struct ng_pass *pass, const char *name);

// What a pass callback works with. The getters answer for refs that this pass declared (for writes either the
// ref given or the ref returned); asking for others is an error that is logged and gives null.
struct ng_pass_context {
    struct ng_cmd *cmd;     // gpu/command.h; null in CPU passes
    uint32_t width, height; // raster: render area; viewport and scissor are set to it
    struct ng_jobs *jobs;
    struct ng_gpu *gpu;
    void *data;             // ng_pass_params
    uint64_t frame;         // frames executed before this one
    struct ng_graph *graph; // for the getters below; do not declare in a callback
    uint32_t step;          // for the getters
};

// Borrowed for the call; bind as they are. Parts and layouts are for descriptors: ng_pass_view gives the
// first part that the pass declared of the image, in the image's own type (2D, array, cube; as attachment or
// storage image: 2D or array); ng_pass_view_part any declared part.
struct ng_gpu_image *ng_pass_image(const struct ng_pass_context *ctx, struct ng_graph_ref ref);
VkImageView ng_pass_view(const struct ng_pass_context *ctx, struct ng_graph_ref ref);
VkImageView ng_pass_view_part(const struct ng_pass_context *ctx, struct ng_graph_ref ref,
                              const struct ng_graph_part *part);
VkImageLayout ng_pass_layout(const struct ng_pass_context *ctx, struct ng_graph_ref ref);
struct ng_gpu_buffer *ng_pass_buffer(const struct ng_pass_context *ctx, struct ng_graph_ref ref);

// A resource in host memory. Images: all layers of mip 0, rows tightly packed, row 0 on top.
struct ng_graph_memory {
    void *data; // null: none
    uint64_t size;
    VkFormat format; // UNDEFINED for buffers
    uint32_t width, height, layers;
    uint64_t row_bytes, layer_bytes;
};
// Whether the frame has been given up (ng_graph_abandon_when): a CPU pass that takes long asks now and then,
// and returns NG_ABANDONED.
bool ng_pass_is_abandoned(const struct ng_pass_context *ctx);

// CPU passes only.
struct ng_graph_memory ng_pass_memory(const struct ng_pass_context *ctx, struct ng_graph_ref ref);

// ---- Frame ---------------------------------------------------------------------------------------------

struct ng_plan;

// Compiles the declaration; the plan (graph/plan.h) lives until the next ng_graph_begin. Needs no device.
NG_NODISCARD ng_result ng_graph_compile(struct ng_graph *g);
// Null unless compiled without error.
const struct ng_plan *ng_graph_plan(const struct ng_graph *g);
// The first mistake of this frame's declaration, or "".
const char *ng_graph_error(const struct ng_graph *g);

// Compiles if that is still to do, records into the frame's commands, and runs CPU passes. `*cmd` comes from
// ng_frame_begin; it is submitted and replaced by a fresh one where a CPU pass waits for the GPU, and remains
// the caller's to end. Nothing is recorded if the declaration is broken, so that the last good picture can be
// shown.
NG_NODISCARD ng_result ng_graph_execute(struct ng_graph *g, struct ng_cmd **cmd);

// Lets the frame be given up while it runs, since nobody wants it any more. `abandon` is asked before each
// pass, on the thread of ng_graph_execute. Once it says true the passes that are left do not run; what they
// should have written counts as not made, as after a failure, so the next frame makes it; and
// ng_graph_execute returns NG_ABANDONED. Call it between ng_graph_begin, which forgets it, and
// ng_graph_execute.
void ng_graph_abandon_when(struct ng_graph *g, bool (*abandon)(void *user), void *user);

// Asks for the content that the resource `name` of this frame has at the end; it may be declared later. Call
// it between ng_graph_begin and ng_graph_compile. It is an export. Images: mip 0. A name that the frame does
// not have is found by ng_graph_readback_get.
void ng_graph_readback(struct ng_graph *g, const char *name);
// After ng_frame_end: waits for the last frame executed and returns what ng_graph_readback asked for, valid
// until the next ng_graph_begin. NG_ERROR_NOT_FOUND, logged, if that frame had no such resource or was not
// asked.
NG_NODISCARD ng_result ng_graph_readback_get(struct ng_graph *g, const char *name,
                                             struct ng_graph_memory *out);

// ---- Figures -------------------------------------------------------------------------------------------

struct ng_pass_stats {
    const char *name;
    double cpu_ms; // last run: recording, or for CPU passes the work
    double gpu_ms; // last run whose result has arrived, a few frames late; 0 for CPU passes
    uint64_t runs;
    uint64_t skipped; // declared, but culled, or what it would write was current
};
// One entry per name that ever ran or was culled (of its first 63 characters), in order of first appearance;
// borrowed until the next call.
const struct ng_pass_stats *ng_graph_stats(struct ng_graph *g, size_t *count);

struct ng_graph_counters {
    uint64_t frames;
    uint64_t objects_created;  // images, buffers and memory ranges made so far: constant in the steady state
    uint64_t transient_bytes;  // memory held for transient resources
    uint64_t persistent_bytes; // and for persistent ones and histories, without the driver's padding
};
struct ng_graph_counters ng_graph_counters(const struct ng_graph *g);

enum ng_dump { NG_DUMP_TEXT, NG_DUMP_DOT, NG_DUMP_JSON };
// The compiled plan as text; null if there is none or no memory. From malloc, owned by the caller.
char *ng_graph_dump(const struct ng_graph *g, enum ng_dump format);

NG_EXTERN_C_END

#endif

// What the files of this folder share: the declaration as it is recorded, and the stages of compilation.
#ifndef NG_GRAPH_GRAPH_INTERNAL_H
#define NG_GRAPH_GRAPH_INTERNAL_H

#include "base/arena.h"
#include "base/array.h"
#include "gpu/frame.h"
#include "graph/graph.h"
#include "graph/plan.h"

// ---- Declaration (declare.c) ---------------------------------------------------------------------------

struct decl_resource {
    const char *name;
    enum ng_resource_kind kind;
    bool is_image;
    bool has_content; // before the frame
    struct ng_graph_image_params image;
    struct ng_graph_buffer_params buffer;
    enum ng_use final;
    VkImageLayout initial_layout;
    union {
        struct ng_gpu_image *image;
        struct ng_gpu_buffer *buffer;
    } imported;
    bool readback; // its final content is to be in host memory
    // Kept from earlier frames:
    uint64_t kept_key; // of the content; 0: unknown
    uint64_t owner;    // persistent: as struct ng_graph has it
    bool gpu_knows;    // a GPU pass may have used it
    bool in_host_memory;
};

static inline bool decl_is_scratch(const struct decl_resource *r)
{
    return !r->is_image && r->buffer.scratch;
}

// What has no content that a key could stand for.
static inline bool decl_is_keyless(const struct decl_resource *r)
{
    return r->kind == NG_RESOURCE_TOKEN || decl_is_scratch(r);
}

struct decl_use {
    uint32_t resource, version; // the version given; a write makes version + 1
    enum ng_use use;
    bool write;
    bool known;    // the ref was of this frame
    bool replaced; // read as `key`
    uint64_t key;  // instead of the version's
    struct ng_graph_part part;
};

struct ng_pass {
    struct ng_graph *graph;
    const char *name;
    enum ng_pass_kind kind;
    ng_pass_fn run;
    void *data;
    uint32_t flags, width, height;
    uint64_t key;
    NG_ARRAY(struct decl_use) uses;
    NG_ARRAY(const char *) after;
};

// ---- Objects (objects.c) -------------------------------------------------------------------------------

// What outlives frames under a name: one object, or with history two that take turns.
struct kept {
    char *name;
    uint64_t hash; // of the name
    bool is_image, history;
    uint64_t owner; // persistent: whose content it is
    struct ng_graph_image_params image;
    struct ng_graph_buffer_params buffer;
    bool valid;      // object[newest] has content
    uint64_t key;    // of that; 0: unknown
    bool gpu_knows;  // a GPU pass has used it
    bool host;       // a buffer in host memory
    uint32_t newest; // persistent: always 0
    struct ng_gpu_image *images[2];
    struct ng_gpu_buffer *buffers[2];
    VkImageLayout layouts[2];
    bool declared; // in this frame
    bool swap;     // at the end of this frame: what it wrote is the newest
};

// What a plan's resource is made of on the device.
struct physical {
    struct ng_gpu_image *image;
    struct ng_gpu_buffer *buffer;
    uint32_t turn; // kept: which of the two objects
};

struct cached_object {
    uint64_t key;
    size_t block; // of ng_graph.blocks
    struct physical object;
    uint64_t last_frame;
};

// Memory of a plan's block: grown when a plan needs more, kept while the graph lives.
struct memory_block {
    bool host, cpu, images;
    uint32_t slot; // host memory that the GPU reads: which frame in flight it belongs to
    uint32_t memory_types;
    uint64_t alignment;
    struct ng_gpu_memory memory;
};

struct pass_stat {
    struct ng_pass_stats stats;
    char *name;
    uint64_t hash;
};

struct ng_graph {
    struct ng_graph_params params;
    bool unified; // buffers in host memory are as good as any for the GPU
    struct ng_arena arena;
    uint32_t serial; // of the frame, in refs
    uint64_t owner;  // of what is declared now: a provider's registration; 0: none's
    bool broken, compiled;
    char error[256], logged[256];

    NG_ARRAY(struct decl_resource) resources;
    NG_ARRAY(struct ng_pass *) passes; // a pool: those from pass_count on wait for later frames
    uint32_t pass_count;
    struct ng_pass lost_pass; // what a caller gets when there is no memory for a pass
    NG_ARRAY(struct ng_graph_ref) exports;
    NG_ARRAY(const char *) readbacks; // asked for before this frame is compiled
    struct ng_plan plan;              // its arrays are the following
    NG_ARRAY(struct ng_plan_resource) plan_resources;
    NG_ARRAY(struct ng_plan_step) plan_steps;
    NG_ARRAY(struct ng_plan_use) plan_uses;
    NG_ARRAY(struct ng_plan_barrier) plan_barriers;
    NG_ARRAY(struct ng_plan_block) plan_blocks;

    NG_ARRAY(struct kept) kept;
    NG_ARRAY(uint32_t) kept_slots; // hash table: index + 1 into kept, 0 empty
    NG_ARRAY(struct cached_object) cache;
    NG_ARRAY(struct memory_block) blocks;
    struct physical *physical; // by plan resource; in the arena, as are:
    uint64_t *final_keys;      // by resource: its key once the frame has run; 0: unknown
    bool *current;             // by resource: as struct compile has it
    uint64_t executed;         // frames
    uint64_t objects_created;
    uint64_t slot_serials[NG_GPU_FRAMES]; // after which the host memory of a slot is free again; 0: it is
    uint64_t last_serial;                 // of the device, after which the last executed frame is done
    bool has_run;                         // this frame was executed
    bool (*abandon)(void *user);          // whether to give this frame up; null: never
    void *abandon_user;
    bool abandoned; // it was
    NG_ARRAY(struct pass_stat) stats;
    NG_ARRAY(uint32_t) stat_slots;
    NG_ARRAY(struct ng_pass_stats) stats_view;
};

#define REF_RESOURCE(ref) ((uint32_t)((ref).id & 0xffffu) - 1u)
#define REF_VERSION(ref)  ((uint32_t)((ref).id >> 16) & 0xffffu)
#define REF_SERIAL(ref)   ((uint32_t)((ref).id >> 32))
#define MAX_RESOURCES     0xffffu
#define MAX_VERSION       0xffffu

// True if the ref names a resource of this frame.
bool graph_knows(const struct ng_graph *g, struct ng_graph_ref ref);
// Marks the frame as broken. The first message of a frame is kept, and logged unless the last broken frame
// said the same: a mistake that is made each frame is told once.
ng_result graph_fail(struct ng_graph *g, const char *fmt, ...) NG_PRINTF(2, 3);
ng_result graph_no_memory(struct ng_graph *g);

// ---- Compilation ---------------------------------------------------------------------------------------

// What the stages hand on. Arrays are in the frame's arena.
struct compile {
    struct ng_graph *g;
    uint32_t *first_version; // by resource: where its versions begin in `writer`
    uint32_t *writer;        // by version: the pass that makes it, or NONE
    uint32_t *order;         // passes as they run; all of them
    uint32_t order_count;
    bool *live;                      // by pass: not culled
    uint64_t *keys;                  // by version; 0: unknown
    bool *renewed;                   // by resource: persistent, and made from nothing by whoever writes it
    bool *current;                   // by resource: its content is what its passes would make
    uint64_t *stages, *write_access; // by plan resource: everything that touches it (sync.c)
};

// validate.c: finds every mistake that can be seen in order of declaration; makes first_version and writer.
ng_result graph_validate(struct compile *c);
// order.c: passes in an order that respects what they need; which of them something needs.
ng_result graph_order(struct compile *c);
// keys.c: what versions are made from; which persistent resources hold that already.
ng_result graph_find_keys(struct compile *c);
// order.c
ng_result graph_cull(struct compile *c);
// expand.c: steps and their uses: passes that run, clears, copies between GPU and host.
ng_result graph_expand(struct compile *c);
// alias.c: memory for transient resources.
ng_result graph_place(struct compile *c);
// sync.c: barriers, batches, waits.
ng_result graph_synchronise(struct compile *c);

static inline uint64_t graph_align(uint64_t x, uint64_t alignment)
{
    return (x + alignment - 1) / alignment * alignment;
}

// The bytes of an image's linear copy: all layers of mip 0. 0: the format cannot be copied, or overflow.
uint64_t graph_linear_size(const struct ng_graph_image_params *image);

// ---- Execution -----------------------------------------------------------------------------------------

// What passes did to a declared resource.
struct written {
    bool written, failed;
};

// objects.c
struct kept *graph_kept_find(struct ng_graph *g, const char *name);
// Whether what is kept answers to this description.
bool graph_kept_fits(const struct kept *kept, const struct decl_resource *r);
uint64_t graph_kept_bytes(const struct kept *kept);
bool graph_same_params(const struct decl_resource *a, const struct decl_resource *b);
// The size, alignment and memory types of a transient resource; without a device a plausible guess.
ng_result graph_measure(struct ng_graph *g, struct ng_plan_resource *r);
// Objects for all resources of the plan, from the cache where possible.
ng_result graph_realise(struct ng_graph *g);
// After the frame: layouts and validity of what is kept; releases what was not declared.
void graph_retire(struct ng_graph *g, struct written *written);
void graph_release_objects(struct ng_graph *g);

// stats.c
// Null when out of memory: the pass is then not counted.
struct ng_pass_stats *graph_stat(struct ng_graph *g, const char *name);
void graph_read_timers(struct ng_graph *g);
void graph_count_skipped(struct ng_graph *g);

#endif

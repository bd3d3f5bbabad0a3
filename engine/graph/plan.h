// A compiled frame: what runs in which order, with which barriers, in which memory. Plain data, made by
// ng_graph_compile as a pure function of the declaration, read by the executor, dumps and tests.
//
// Steps run in order. GPU steps are recorded into batches (one submission each); a CPU step runs on the host
// while its frame is recorded: after waiting for batch `wait_batch`, if it has one, and before any later
// batch is submitted. The barriers of a step come before it, at the end of the batch that is then open.
// Before the first batch, one full memory barrier orders the frame after everything submitted earlier; so at
// step 0 nothing is pending except that host reads and writes of lasting buffers need a wait.
#ifndef NG_GRAPH_PLAN_H
#define NG_GRAPH_PLAN_H

#include "graph/graph.h"

#define NG_PLAN_NONE UINT32_MAX

enum ng_resource_kind {
    NG_RESOURCE_TRANSIENT,
    NG_RESOURCE_PERSISTENT,
    NG_RESOURCE_CURRENT, // this frame's version of something with history
    NG_RESOURCE_HISTORY, // the last frame's
    NG_RESOURCE_IMPORTED,
    NG_RESOURCE_TOKEN,
    NG_RESOURCE_STAGING, // made by the graph: a linear copy of another resource in host memory
};

struct ng_plan_resource {
    const char *name;
    enum ng_resource_kind kind;
    bool is_image;
    struct ng_graph_image_params image;   // counts are at least 1
    struct ng_graph_buffer_params buffer; // size: for staging, of the copy
    bool host;                            // in host-visible memory
    bool cpu;                             // used by CPU passes and readers of the frame alone
    VkImageUsageFlags image_usage;
    VkBufferUsageFlags buffer_usage;
    VkImageLayout initial_layout, final_layout;
    bool written;                   // by a step
    uint32_t staging;               // its copy in host memory; for a copy, what it is a copy of; or NONE
    uint32_t first_step, last_step; // NONE: unused
    // Transient and staging only:
    uint32_t block; // of memory; NONE: unused, or not placed by the plan
    uint64_t offset, size;
    uint64_t alignment;
    uint32_t memory_types;
};

// Memory shared by transient resources.
struct ng_plan_block {
    bool host, cpu;
    bool images; // images and buffers are kept apart (bufferImageGranularity)
    uint32_t memory_types;
    uint64_t size, alignment;
};

enum ng_load { NG_LOAD_KEEP, NG_LOAD_CLEAR, NG_LOAD_UNDEFINED };

struct ng_plan_use {
    uint32_t resource; // what is touched: for CPU passes the staging copy, if there is one
    uint32_t declared; // the resource that the pass named
    uint32_t version;  // read, or written
    enum ng_use use;
    bool write;
    struct ng_graph_part part; // counts are at least 1; zero for buffers
    enum ng_load load;         // attachments
    bool store;                // attachments: needed later
};

struct ng_plan_barrier {
    uint32_t resource;
    VkPipelineStageFlags2 src_stages, dst_stages;
    VkAccessFlags2 src_access, dst_access;
    VkImageLayout old_layout, new_layout; // equal: no transition
    bool alias; // also orders against earlier resources in the same memory: the access masks are theirs too
};

enum ng_step_kind {
    NG_STEP_PASS,
    NG_STEP_CLEAR,    // uses[0]... are the parts to clear
    NG_STEP_DOWNLOAD, // uses[0] to its staging copy, uses[1]
    NG_STEP_UPLOAD,   // uses[0], a staging copy, to uses[1]
    NG_STEP_FINAL,    // barriers only: final uses of imports and readbacks
};

struct ng_plan_step {
    enum ng_step_kind kind;
    enum ng_pass_kind pass_kind;
    const char *name;
    uint32_t pass; // index of the declaration, or NONE
    uint32_t first_use, use_count;
    uint32_t first_barrier, barrier_count;
    uint32_t batch;
    uint32_t wait_batch; // CPU steps; NONE: nothing to wait for
};

struct ng_plan_pass {
    const char *name;
    enum ng_pass_kind kind;
    uint32_t step; // NONE: culled, or
    bool current;  // what it would write is there already
};

struct ng_plan {
    uint32_t resource_count, pass_count, step_count, use_count, barrier_count, block_count, batch_count;
    struct ng_plan_resource *resources; // declared ones in order of declaration, then staging copies
    struct ng_plan_pass *passes;        // in order of declaration
    struct ng_plan_step *steps;
    struct ng_plan_use *uses;
    struct ng_plan_barrier *barriers;
    struct ng_plan_block *blocks;
    uint64_t transient_bytes; // of all transient resources, were each given memory of its own
};

#endif

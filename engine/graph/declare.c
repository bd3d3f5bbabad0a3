// Recording: what the frame says is written down as it is said and judged later, all in one place
// (validate.c). The only thing computed here is the next version of a ref.
#include "graph/graph_internal.h"

#include "base/log.h"
#include "gpu/buffer.h"
#include "gpu/device.h"
#include "gpu/image.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

ng_result ng_graph_create(const struct ng_graph_params *params, struct ng_graph **out)
{
    NG_REQUIRE(out, "ng_graph_create: out is null");
    *out = NULL;
    struct ng_graph *g = calloc(1, sizeof *g);
    if (!g)
        return ng_out_of_memory("a render graph");
    if (params)
        g->params = *params;
    if (g->params.gpu) {
        VkPhysicalDeviceType type = g->params.gpu->properties.deviceType;
        g->unified = type == VK_PHYSICAL_DEVICE_TYPE_CPU || type == VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU;
    } else {
        g->unified = true;
    }
    g->unified = g->unified && !g->params.no_unified;
    ng_graph_begin(g);
    *out = g;
    return NG_OK;
}

void ng_graph_destroy(struct ng_graph **graph)
{
    if (!graph || !*graph)
        return;
    struct ng_graph *g = *graph;
    graph_release_objects(g);
    for (size_t i = 0; i < g->passes.count; i++) {
        ng_array_finish(&g->passes.items[i]->uses);
        ng_array_finish(&g->passes.items[i]->after);
        free(g->passes.items[i]);
    }
    ng_array_finish(&g->passes);
    for (size_t i = 0; i < g->stats.count; i++)
        free(g->stats.items[i].name);
    ng_array_finish(&g->stats);
    ng_array_finish(&g->stat_slots);
    ng_array_finish(&g->stats_view);
    ng_array_finish(&g->resources);
    ng_array_finish(&g->exports);
    ng_array_finish(&g->readbacks);
    ng_array_finish(&g->plan_resources);
    ng_array_finish(&g->plan_steps);
    ng_array_finish(&g->plan_uses);
    ng_array_finish(&g->plan_barriers);
    ng_array_finish(&g->plan_blocks);
    ng_arena_finish(&g->arena);
    free(g);
    *graph = NULL;
}

void ng_graph_ignore_keys(struct ng_graph *g, bool ignore)
{
    g->params.no_keys = ignore;
}

void ng_graph_begin(struct ng_graph *g)
{
    ng_arena_reset(&g->arena);
    g->serial++;
    g->resources.count = 0;
    g->exports.count = 0;
    g->readbacks.count = 0;
    g->pass_count = 0;
    g->broken = g->compiled = g->has_run = g->abandoned = false;
    g->abandon = NULL;
    g->error[0] = 0;
    g->plan = (struct ng_plan){0};
    g->lost_pass = (struct ng_pass){.graph = g};
    for (size_t i = 0; i < g->kept.count; i++)
        g->kept.items[i].declared = false;
}

void *ng_graph_alloc(struct ng_graph *g, size_t size)
{
    return ng_arena_alloc(&g->arena, size);
}

const char *ng_graph_error(const struct ng_graph *g)
{
    return g->error;
}

ng_result graph_fail(struct ng_graph *g, const char *fmt, ...)
{
    if (g->broken)
        return NG_ERROR_USAGE;
    g->broken = true;
    va_list args;
    va_start(args, fmt);
    vsnprintf(g->error, sizeof g->error, fmt, args);
    va_end(args);
    if (strcmp(g->error, g->logged) != 0)
        ng_log_error("graph: %s", g->error);
    memcpy(g->logged, g->error, sizeof g->logged);
    return NG_ERROR_USAGE;
}

ng_result graph_no_memory(struct ng_graph *g)
{
    graph_fail(g, "out of memory for the frame's declaration");
    return NG_ERROR_MEMORY;
}

// What comes after the frame was compiled would be lost without a word.
static bool is_open(struct ng_graph *g, const char *what, const char *name)
{
    if (g->compiled)
        (void)graph_fail(g, "%s '%s' is declared after the frame was compiled", what, name ? name : "");
    return !g->compiled;
}

bool graph_knows(const struct ng_graph *g, struct ng_graph_ref ref)
{
    return REF_SERIAL(ref) == g->serial && REF_RESOURCE(ref) < g->resources.count;
}

// ---- Resources -----------------------------------------------------------------------------------------

static struct ng_graph_ref make_ref(const struct ng_graph *g, uint32_t resource, uint32_t version)
{
    return (struct ng_graph_ref){(uint64_t)g->serial << 32 | (uint64_t)version << 16 | (resource + 1)};
}

static struct ng_graph_ref add(struct ng_graph *g, const char *name, const struct decl_resource *params)
{
    struct decl_resource r = *params;
    r.name = ng_arena_string(&g->arena, name ? name : "");
    if (!is_open(g, "resource", name))
        return (struct ng_graph_ref){0};
    if (g->resources.count == MAX_RESOURCES) {
        graph_fail(g, "resource '%s' is one too many: a frame has at most %u", r.name, MAX_RESOURCES);
        return (struct ng_graph_ref){0};
    }
    if (!r.name || !ng_array_push(&g->resources, r)) {
        graph_no_memory(g);
        return (struct ng_graph_ref){0};
    }
    return make_ref(g, (uint32_t)g->resources.count - 1, 0);
}

static struct ng_graph_image_params image_defaults(const struct ng_graph_image_params *params)
{
    struct ng_graph_image_params image = params ? *params : (struct ng_graph_image_params){0};
    image.layers = image.layers ? image.layers : 1;
    image.mips = image.mips ? image.mips : 1;
    return image;
}

static struct ng_graph_buffer_params buffer_defaults(const struct ng_graph_buffer_params *params)
{
    return params ? *params : (struct ng_graph_buffer_params){0};
}

struct ng_graph_ref ng_graph_add_image(struct ng_graph *g, const char *name,
                                       const struct ng_graph_image_params *params)
{
    return add(g, name, &(struct decl_resource){.is_image = true, .image = image_defaults(params)});
}

struct ng_graph_ref ng_graph_add_buffer(struct ng_graph *g, const char *name,
                                        const struct ng_graph_buffer_params *params)
{
    return add(g, name, &(struct decl_resource){.buffer = buffer_defaults(params)});
}

struct ng_graph_ref ng_graph_add_token(struct ng_graph *g, const char *name)
{
    return add(g, name, &(struct decl_resource){.kind = NG_RESOURCE_TOKEN});
}

// Adds something kept from frame to frame, and looks up what is left of it.
static struct ng_graph_ref add_kept(struct ng_graph *g, const char *name, struct decl_resource r, bool *valid)
{
    const struct kept *kept = graph_kept_find(g, name);
    r.owner = g->owner;
    if (kept && graph_kept_fits(kept, &r)) {
        r.has_content = kept->valid;
        r.initial_layout = kept->layouts[kept->newest];
        r.kept_key = kept->key;
        r.gpu_knows = kept->gpu_knows;
        r.in_host_memory = kept->host;
    }
    if (valid)
        *valid = r.has_content;
    return add(g, name, &r);
}

struct ng_graph_ref ng_graph_persistent_image(struct ng_graph *g, const char *name,
                                              const struct ng_graph_image_params *params, bool *valid)
{
    struct decl_resource r = {
        .kind = NG_RESOURCE_PERSISTENT, .is_image = true, .image = image_defaults(params)};
    return add_kept(g, name, r, valid);
}

struct ng_graph_ref ng_graph_persistent_buffer(struct ng_graph *g, const char *name,
                                               const struct ng_graph_buffer_params *params, bool *valid)
{
    struct decl_resource r = {.kind = NG_RESOURCE_PERSISTENT, .buffer = buffer_defaults(params)};
    return add_kept(g, name, r, valid);
}

// Without content a history reads as cleared, so that the first frame is not a special case for shaders.
struct ng_graph_ref ng_graph_history_image(struct ng_graph *g, const char *name,
                                           const struct ng_graph_image_params *params, bool *valid)
{
    struct decl_resource r = {.kind = NG_RESOURCE_HISTORY, .is_image = true, .image = image_defaults(params)};
    if (!r.image.clear)
        r.image.clear_value = (VkClearValue){0};
    r.image.clear = true;
    return add_kept(g, name, r, valid);
}

struct ng_graph_ref ng_graph_history_buffer(struct ng_graph *g, const char *name,
                                            const struct ng_graph_buffer_params *params, bool *valid)
{
    struct decl_resource r = {.kind = NG_RESOURCE_HISTORY, .buffer = buffer_defaults(params)};
    if (!r.buffer.clear)
        r.buffer.clear_word = 0;
    r.buffer.clear = true;
    return add_kept(g, name, r, valid);
}

// A word that tells in which state an import is: of images one with a layout.
static bool is_state(enum ng_use use, bool is_image)
{
    if (use == NG_USE_NONE)
        return true;
    if ((unsigned)use >= NG_USE_COUNT)
        return false;
    return is_image ? ng_use_info(use)->layout != VK_IMAGE_LAYOUT_UNDEFINED : ng_use_of_buffers(use);
}

static struct decl_resource imported(struct ng_graph *g, const char *name, bool is_image,
                                     const struct ng_graph_import *import)
{
    struct ng_graph_import i = import ? *import : (struct ng_graph_import){0};
    if (!is_state(i.initial, is_image) || !is_state(i.final, is_image)) {
        (void)graph_fail(g, "%s '%s' is imported from word %d to word %d, which do not say its state",
                         is_image ? "image" : "buffer", name ? name : "", (int)i.initial, (int)i.final);
        i = (struct ng_graph_import){0};
    }
    return (struct decl_resource){.kind = NG_RESOURCE_IMPORTED,
                                  .is_image = is_image,
                                  .has_content = i.initial != NG_USE_NONE,
                                  .initial_layout = ng_use_info(i.initial)->layout,
                                  .final = i.final};
}

struct ng_graph_ref ng_graph_import_image(struct ng_graph *g, const char *name, struct ng_gpu_image *image,
                                          const struct ng_graph_import *import)
{
    struct decl_resource r = imported(g, name, true, import);
    if (image) {
        r.image = (struct ng_graph_image_params){.format = image->format,
                                                 .width = image->width,
                                                 .height = image->height,
                                                 .layers = image->layers,
                                                 .mips = image->mips,
                                                 .cube = image->cube};
        r.imported.image = image;
    }
    return add(g, name, &r);
}

struct ng_graph_ref ng_graph_import_buffer(struct ng_graph *g, const char *name, struct ng_gpu_buffer *buffer,
                                           const struct ng_graph_import *import)
{
    struct decl_resource r = imported(g, name, false, import);
    if (buffer) {
        r.buffer.size = buffer->size;
        r.imported.buffer = buffer;
    }
    return add(g, name, &r);
}

void ng_graph_export(struct ng_graph *g, struct ng_graph_ref ref)
{
    if (is_open(g, "an export", NULL) && !ng_array_push(&g->exports, ref))
        graph_no_memory(g);
}

void ng_graph_readback(struct ng_graph *g, const char *name)
{
    const char *copy = ng_arena_string(&g->arena, name);
    if (is_open(g, "a readback of", name) && (!copy || !ng_array_push(&g->readbacks, copy)))
        graph_no_memory(g);
}

// ---- Passes --------------------------------------------------------------------------------------------

// Passes are recycled from frame to frame, so that their arrays grow once.
static struct ng_pass *next_pass(struct ng_graph *g)
{
    if (g->pass_count == g->passes.count) {
        struct ng_pass *fresh = calloc(1, sizeof *fresh);
        if (!fresh || !ng_array_push(&g->passes, fresh)) {
            free(fresh);
            return NULL;
        }
    }
    return g->passes.items[g->pass_count++];
}

struct ng_pass *ng_graph_add_pass(struct ng_graph *g, const struct ng_pass_params *params)
{
    if (!is_open(g, "pass", params->name))
        return &g->lost_pass;
    const char *name = ng_arena_string(&g->arena, params->name ? params->name : "");
    void *data = (void *)(uintptr_t)params->data;
    if (params->data_size) {
        data = ng_arena_alloc(&g->arena, params->data_size);
        if (data)
            memcpy(data, params->data, params->data_size);
    }
    struct ng_pass *pass = name && (data || !params->data_size) ? next_pass(g) : NULL;
    if (!pass) {
        graph_no_memory(g);
        return &g->lost_pass;
    }
    pass->graph = g;
    pass->name = name;
    pass->kind = params->kind;
    pass->run = params->run;
    pass->data = data;
    pass->flags = params->flags;
    pass->width = params->width;
    pass->height = params->height;
    pass->key = params->key;
    pass->uses.count = 0;
    pass->after.count = 0;
    return pass;
}

static struct ng_graph_ref record(struct ng_pass *pass, struct ng_graph_ref ref, struct decl_use u)
{
    struct ng_graph *g = pass->graph;
    u.resource = REF_RESOURCE(ref);
    u.version = REF_VERSION(ref);
    u.known = graph_knows(g, ref);
    if (pass == &g->lost_pass || !is_open(g, "a use by pass", pass->name))
        return (struct ng_graph_ref){0};
    if (!ng_array_push(&pass->uses, u)) {
        graph_no_memory(g);
        return (struct ng_graph_ref){0};
    }
    return u.known && u.version < MAX_VERSION ? make_ref(g, u.resource, u.version + u.write)
                                              : (struct ng_graph_ref){0};
}

static struct ng_graph_part part_of(const struct ng_graph_part *part)
{
    return part ? *part : (struct ng_graph_part){0}; // all of it
}

void ng_pass_read(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use)
{
    record(pass, ref, (struct decl_use){.use = use});
}

void ng_pass_read_as(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use, uint64_t key)
{
    record(pass, ref, (struct decl_use){.use = use, .replaced = true, .key = key});
}

void ng_pass_read_part(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use,
                       const struct ng_graph_part *part)
{
    record(pass, ref, (struct decl_use){.use = use, .part = part_of(part)});
}

struct ng_graph_ref ng_pass_write(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use)
{
    return record(pass, ref, (struct decl_use){.use = use, .write = true});
}

struct ng_graph_ref ng_pass_write_part(struct ng_pass *pass, struct ng_graph_ref ref, enum ng_use use,
                                       const struct ng_graph_part *part)
{
    return record(pass, ref, (struct decl_use){.use = use, .write = true, .part = part_of(part)});
}

void ng_pass_after(struct ng_pass *pass, const char *name)
{
    struct ng_graph *g = pass->graph;
    const char *copy = ng_arena_string(&g->arena, name);
    if (pass != &g->lost_pass && is_open(g, "the order of pass", pass->name) &&
        (!copy || !ng_array_push(&pass->after, copy)))
        graph_no_memory(g);
}

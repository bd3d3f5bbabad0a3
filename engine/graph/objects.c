// Vulkan objects behind the resources of a plan.
//
// Transient resources are placed into memory blocks that only grow. An object is found again by what it is
// (name, description, usage) and where it lies (block, offset), so a frame that plans as the last one did
// creates nothing; what has not been asked for in a while is destroyed. Host memory exists once for each
// frame in flight, since the CPU may write this frame's while the GPU reads the last one's. What is kept by
// name has memory of its own and every usage its format supports, so that later frames may use it in new
// ways.
#include "graph/graph_internal.h"

#include "base/hash.h"
#include "base/log.h"
#include "gpu/buffer.h"
#include "gpu/frame.h"
#include "gpu/image.h"

#include <stdlib.h>
#include <string.h>

#define UNUSED_FRAMES 32 // after which a cached object is destroyed

// ---- Sizes ---------------------------------------------------------------------------------------------

static struct ng_gpu_image_params image_params(const struct ng_plan_resource *r)
{
    return (struct ng_gpu_image_params){.name = r->name,
                                        .width = r->image.width,
                                        .height = r->image.height,
                                        .layers = r->image.layers,
                                        .mips = r->image.mips,
                                        .format = r->image.format,
                                        .usage = r->image_usage,
                                        .cube = r->image.cube};
}

static struct ng_gpu_buffer_params buffer_params(const struct ng_plan_resource *r)
{
    return (struct ng_gpu_buffer_params){.name = r->name,
                                         .size = r->buffer.size,
                                         .usage = r->buffer_usage,
                                         .memory = r->host ? NG_GPU_MEMORY_READBACK : NG_GPU_MEMORY_DEVICE};
}

// What a plan without a device is measured by: packed mips on pages of 64 KiB, as on most GPUs.
static void guess(struct ng_plan_resource *r)
{
    uint64_t size = r->buffer.size;
    if (r->is_image) {
        uint64_t texel = ng_gpu_format_size(r->image.format);
        size = 0;
        for (uint32_t m = 0; m < r->image.mips; m++)
            size += (texel ? texel : 8) * r->image.layers * ng_gpu_mip_extent(r->image.width, m) *
                    ng_gpu_mip_extent(r->image.height, m);
    }
    r->alignment = r->is_image ? 65536 : 256;
    r->size = (size + r->alignment - 1) / r->alignment * r->alignment;
    r->memory_types = 1;
}

ng_result graph_measure(struct ng_graph *g, struct ng_plan_resource *r)
{
    struct ng_gpu *gpu = g->params.gpu;
    VkMemoryRequirements m;
    if (!gpu) {
        guess(r);
        return NG_OK;
    }
    if (r->is_image) {
        struct ng_gpu_image_params p = image_params(r);
        NG_TRY(ng_gpu_image_requirements(gpu, &p, &m));
    } else {
        struct ng_gpu_buffer_params p = buffer_params(r);
        NG_TRY(ng_gpu_buffer_requirements(gpu, &p, &m));
    }
    r->size = m.size;
    r->alignment = m.alignment;
    r->memory_types = m.memoryTypeBits;
    return NG_OK;
}

// ---- Transient resources -------------------------------------------------------------------------------

static void destroy_object(struct physical *p)
{
    ng_gpu_image_destroy(&p->image);
    ng_gpu_buffer_destroy(&p->buffer);
}

static void drop_cached(struct ng_graph *g, size_t index)
{
    destroy_object(&g->cache.items[index].object);
    ng_array_swap_remove(&g->cache, index);
}

// The memory for a block of the plan in this frame, grown if need be; null on failure.
static struct memory_block *block_memory(struct ng_graph *g, const struct ng_plan_block *want)
{
    uint32_t slot = want->host && !want->cpu ? (uint32_t)(g->executed % NG_GPU_FRAMES) : 0;
    size_t i = 0;
    for (; i < g->blocks.count; i++) {
        const struct memory_block *b = &g->blocks.items[i];
        if (b->host == want->host && b->cpu == want->cpu && b->images == want->images &&
            b->memory_types == want->memory_types && b->slot == slot)
            break;
    }
    if (i == g->blocks.count) {
        struct memory_block fresh = {.host = want->host,
                                     .cpu = want->cpu,
                                     .images = want->images,
                                     .slot = slot,
                                     .memory_types = want->memory_types};
        if (!ng_array_push(&g->blocks, fresh)) {
            ng_out_of_memory("the render graph's memory blocks");
            return NULL;
        }
    }
    struct memory_block *b = &g->blocks.items[i];
    if (b->memory.size >= want->size && b->alignment >= want->alignment)
        return b;
    for (size_t k = g->cache.count; k-- > 0;)
        if (g->cache.items[k].block == i)
            drop_cached(g, k);
    ng_gpu_memory_free(g->params.gpu, &b->memory);
    VkMemoryRequirements m = {
        .size = want->size, .alignment = want->alignment, .memoryTypeBits = want->memory_types};
    enum ng_gpu_memory_kind kind = want->host ? NG_GPU_MEMORY_READBACK : NG_GPU_MEMORY_DEVICE;
    const char *name = want->host ? "what is read of a frame" : "a frame of this size";
    if (ng_gpu_memory_allocate(g->params.gpu, &m, kind, name, &b->memory) != NG_OK)
        return NULL;
    b->alignment = want->alignment;
    g->objects_created++;
    return b;
}

static ng_result create_placed(struct ng_graph *g, const struct ng_plan_resource *r,
                               const struct memory_block *b, struct physical *out)
{
    g->objects_created++;
    if (r->is_image) {
        struct ng_gpu_image_params p = image_params(r);
        p.place = &b->memory;
        p.place_offset = r->offset;
        return ng_gpu_image_create(g->params.gpu, &p, &out->image);
    }
    struct ng_gpu_buffer_params p = buffer_params(r);
    p.place = &b->memory;
    p.place_offset = r->offset;
    return ng_gpu_buffer_create(g->params.gpu, &p, &out->buffer);
}

static uint64_t object_key(const struct ng_plan_resource *r, size_t block)
{
    const uint64_t facts[] = {ng_hash_string(r->name),
                              block,
                              r->offset,
                              r->is_image ? (uint64_t)r->image.format : UINT64_MAX,
                              (uint64_t)r->image.width << 32 | r->image.height,
                              (uint64_t)r->image.layers << 32 | r->image.mips,
                              r->image.cube,
                              r->buffer.size,
                              (uint64_t)r->image_usage << 32 | r->buffer_usage};
    return ng_hash_bytes(0, facts, sizeof facts);
}

// `hint`: where the search starts; plans ask in the same order each frame, so it is nearly always right.
static ng_result realise_transient(struct ng_graph *g, const struct ng_plan_resource *r, size_t *hint,
                                   struct physical *out)
{
    struct memory_block *b = block_memory(g, &g->plan.blocks[r->block]);
    if (!b)
        return g->params.gpu->lost ? NG_ERROR_DEVICE : NG_ERROR_MEMORY;
    size_t block = (size_t)(b - g->blocks.items), count = g->cache.count;
    uint64_t key = object_key(r, block);
    for (size_t k = 0; k < count; k++) {
        struct cached_object *o = &g->cache.items[(*hint + k) % count];
        if (o->key != key)
            continue;
        *hint = *hint + k + 1;
        o->last_frame = g->executed;
        *out = o->object;
        return NG_OK;
    }
    struct cached_object fresh = {.key = key, .block = block, .last_frame = g->executed};
    NG_TRY(create_placed(g, r, b, &fresh.object));
    if (!ng_array_push(&g->cache, fresh)) {
        destroy_object(&fresh.object);
        return ng_out_of_memory(r->name);
    }
    *out = fresh.object;
    return NG_OK;
}

// ---- What is kept by name ------------------------------------------------------------------------------

// Slots of the table: index + 1 into kept, 0 empty; a power of two, at most half full.
static bool index_kept(struct ng_graph *g)
{
    size_t size = 64;
    while (size < g->kept.count * 4)
        size *= 2;
    g->kept_slots.count = 0;
    if (!ng_array_resize(&g->kept_slots, size))
        return false;
    for (size_t i = 0; i < g->kept.count; i++) {
        size_t k = g->kept.items[i].hash & (size - 1);
        while (g->kept_slots.items[k])
            k = (k + 1) & (size - 1);
        g->kept_slots.items[k] = (uint32_t)i + 1;
    }
    return true;
}

struct kept *graph_kept_find(struct ng_graph *g, const char *name)
{
    if (!name || !g->kept_slots.count)
        return NULL;
    size_t mask = g->kept_slots.count - 1, k = ng_hash_string(name) & mask;
    for (; g->kept_slots.items[k]; k = (k + 1) & mask)
        if (!strcmp(g->kept.items[g->kept_slots.items[k] - 1].name, name))
            return &g->kept.items[g->kept_slots.items[k] - 1];
    return NULL;
}

static struct kept *add_kept(struct ng_graph *g, const char *name)
{
    size_t size = strlen(name) + 1;
    char *copy = malloc(size);
    if (!copy || !ng_array_push(&g->kept, (struct kept){.name = copy, .hash = ng_hash_string(name)})) {
        free(copy);
        return NULL;
    }
    memcpy(copy, name, size);
    if (g->kept.count * 2 > g->kept_slots.count && !index_kept(g)) {
        free(copy);
        g->kept.count--;
        return NULL;
    }
    size_t index = g->kept.count - 1, mask = g->kept_slots.count - 1, k = g->kept.items[index].hash & mask;
    while (g->kept_slots.items[k] && g->kept_slots.items[k] != index + 1)
        k = (k + 1) & mask;
    g->kept_slots.items[k] = (uint32_t)index + 1;
    return &g->kept.items[index];
}

static bool same_image(const struct ng_graph_image_params *a, const struct ng_graph_image_params *b)
{
    return a->format == b->format && a->width == b->width && a->height == b->height &&
           a->layers == b->layers && a->mips == b->mips && a->array == b->array && a->cube == b->cube;
}

bool graph_same_params(const struct decl_resource *a, const struct decl_resource *b)
{
    return a->is_image == b->is_image &&
           (a->is_image ? same_image(&a->image, &b->image) : a->buffer.size == b->buffer.size);
}

static bool has_history(enum ng_resource_kind kind)
{
    return kind == NG_RESOURCE_CURRENT || kind == NG_RESOURCE_HISTORY;
}

bool graph_kept_fits(const struct kept *kept, const struct decl_resource *r)
{
    bool same_owner = kept->history || kept->owner == r->owner;
    return same_owner && kept->is_image == r->is_image && kept->history == has_history(r->kind) &&
           (r->is_image ? same_image(&kept->image, &r->image) : kept->buffer.size == r->buffer.size);
}

static uint64_t packed_bytes(const struct ng_graph_image_params *image)
{
    uint64_t texels = 0;
    for (uint32_t m = 0; m < image->mips; m++)
        texels += (uint64_t)ng_gpu_mip_extent(image->width, m) * ng_gpu_mip_extent(image->height, m);
    return texels * image->layers * ng_gpu_format_size(image->format);
}

uint64_t graph_kept_bytes(const struct kept *k)
{
    uint64_t bytes = 0;
    for (int i = 0; i < 2; i++) {
        bytes += k->images[i] ? packed_bytes(&k->image) : 0;
        bytes += k->buffers[i] ? k->buffer.size : 0;
    }
    return bytes;
}

static void empty_kept(struct kept *k)
{
    for (int i = 0; i < 2; i++) {
        ng_gpu_image_destroy(&k->images[i]);
        ng_gpu_buffer_destroy(&k->buffers[i]);
        k->layouts[i] = VK_IMAGE_LAYOUT_UNDEFINED;
    }
    k->valid = k->gpu_knows = k->host = false;
    k->key = 0;
    k->newest = 0;
}

// Every usage that the format supports.
static VkImageUsageFlags all_usages(const struct ng_gpu *gpu, VkFormat format)
{
    static const struct {
        VkFormatFeatureFlags feature;
        VkImageUsageFlags usage;
    } pairs[] = {
        {VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, VK_IMAGE_USAGE_SAMPLED_BIT},
        {VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
        {VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT},
        {VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT},
        {VK_FORMAT_FEATURE_TRANSFER_SRC_BIT, VK_IMAGE_USAGE_TRANSFER_SRC_BIT},
        {VK_FORMAT_FEATURE_TRANSFER_DST_BIT, VK_IMAGE_USAGE_TRANSFER_DST_BIT},
    };
    VkFormatProperties properties;
    vkGetPhysicalDeviceFormatProperties(gpu->physical, format, &properties);
    VkImageUsageFlags usage = 0;
    for (size_t i = 0; i < NG_COUNT(pairs); i++)
        if (properties.optimalTilingFeatures & pairs[i].feature)
            usage |= pairs[i].usage;
    return usage;
}

static ng_result create_kept(struct ng_graph *g, const struct ng_plan_resource *r, struct kept *k, uint32_t i)
{
    g->objects_created++;
    if (r->is_image) {
        struct ng_gpu_image_params p = image_params(r);
        p.usage = all_usages(g->params.gpu, r->image.format);
        return ng_gpu_image_create(g->params.gpu, &p, &k->images[i]);
    }
    struct ng_gpu_buffer_params p = buffer_params(r);
    p.usage = 0; // all
    p.memory = g->unified || r->host ? NG_GPU_MEMORY_READBACK : NG_GPU_MEMORY_DEVICE;
    k->host = p.memory == NG_GPU_MEMORY_READBACK;
    return ng_gpu_buffer_create(g->params.gpu, &p, &k->buffers[i]);
}

static struct kept *find_or_add_kept(struct ng_graph *g, const struct decl_resource *d)
{
    struct kept *k = graph_kept_find(g, d->name);
    if (k && graph_kept_fits(k, d))
        return k;
    k = k ? k : add_kept(g, d->name);
    if (!k)
        return NULL;
    empty_kept(k);
    k->is_image = d->is_image;
    k->history = has_history(d->kind);
    k->owner = d->owner;
    k->image = d->image;
    k->buffer = d->buffer;
    return k;
}

static ng_result realise_kept(struct ng_graph *g, uint32_t index, struct physical *out)
{
    const struct ng_plan_resource *r = &g->plan.resources[index];
    struct kept *k = find_or_add_kept(g, &g->resources.items[index]);
    if (!k)
        return ng_out_of_memory(r->name);
    k->declared = true;
    uint32_t i = r->kind == NG_RESOURCE_CURRENT ? k->newest ^ 1u : k->newest;
    bool used = r->first_step != NG_PLAN_NONE;
    if (used && !k->images[i] && !k->buffers[i])
        NG_TRY(create_kept(g, r, k, i));
    k->gpu_knows |= used && !r->cpu;
    *out = (struct physical){.image = k->images[i], .buffer = k->buffers[i], .turn = i};
    return NG_OK;
}

// ---- All of a plan -------------------------------------------------------------------------------------

static ng_result realise(struct ng_graph *g, uint32_t index, size_t *hint, struct physical *out)
{
    const struct ng_plan_resource *r = &g->plan.resources[index];
    switch (r->kind) {
    case NG_RESOURCE_IMPORTED:
        *out = r->is_image ? (struct physical){.image = g->resources.items[index].imported.image}
                           : (struct physical){.buffer = g->resources.items[index].imported.buffer};
        return NG_OK;
    case NG_RESOURCE_PERSISTENT:
    case NG_RESOURCE_CURRENT:
    case NG_RESOURCE_HISTORY:
        return realise_kept(g, index, out);
    case NG_RESOURCE_TOKEN:
        return NG_OK;
    case NG_RESOURCE_TRANSIENT:
    case NG_RESOURCE_STAGING:
        return r->block == NG_PLAN_NONE ? NG_OK : realise_transient(g, r, hint, out);
    }
    return NG_OK;
}

ng_result graph_realise(struct ng_graph *g)
{
    g->physical = ng_arena_array(&g->arena, g->plan.resource_count, sizeof *g->physical);
    if (!g->physical)
        return graph_no_memory(g);
    size_t hint = 0;
    for (uint32_t i = 0; i < g->plan.resource_count; i++)
        NG_TRY(realise(g, i, &hint, &g->physical[i]));
    return NG_OK;
}

// What passes that were culled would have written is out of date; unless it has a key, whose content it still
// is, if they all were.
static void invalidate_culled(const struct ng_graph *g, struct written *written)
{
    for (uint32_t p = 0; p < g->pass_count; p++)
        for (size_t i = 0; g->plan.passes[p].step == NG_PLAN_NONE && i < g->passes.items[p]->uses.count;
             i++) {
            const struct decl_use *u = &g->passes.items[p]->uses.items[i];
            const struct decl_resource *r = &g->resources.items[u->resource];
            bool still =
                g->current[u->resource] || (g->final_keys[u->resource] && !written[u->resource].written);
            if (u->write && r->kind == NG_RESOURCE_PERSISTENT && !still && !decl_is_scratch(r))
                written[u->resource].failed = true;
        }
}

static void retire_resource(struct ng_graph *g, uint32_t index, bool written, bool failed)
{
    const struct ng_plan_resource *r = &g->plan.resources[index];
    struct kept *k = graph_kept_find(g, r->name);
    k->layouts[g->physical[index].turn] = r->final_layout;
    if (r->kind == NG_RESOURCE_PERSISTENT) {
        k->valid = (k->valid || written) && !failed;
        k->key = failed ? 0 : written ? g->final_keys[index] : k->key;
        if (r->first_step == NG_PLAN_NONE && g->final_keys[index] && g->final_keys[index] != k->key)
            empty_kept(k); // of another key, and nobody asks
    }
    // A history whose frame failed stays at the last good one.
    if (r->kind == NG_RESOURCE_CURRENT && written && !failed) {
        k->swap = true;
        k->valid = true;
    }
}

void graph_retire(struct ng_graph *g, struct written *written)
{
    invalidate_culled(g, written);
    for (uint32_t i = 0; i < g->resources.count; i++) {
        enum ng_resource_kind kind = g->plan.resources[i].kind;
        if (kind == NG_RESOURCE_PERSISTENT || has_history(kind))
            retire_resource(g, i, written[i].written, written[i].failed);
    }
    size_t before = g->kept.count;
    for (size_t i = before; i-- > 0;) {
        struct kept *k = &g->kept.items[i];
        if (k->swap)
            k->newest ^= 1u;
        k->swap = false;
        if (!k->declared) {
            empty_kept(k);
            free(k->name);
            ng_array_swap_remove(&g->kept, i);
        }
    }
    if (g->kept.count < before)
        (void)index_kept(g); // no larger than it was, so there is memory
    for (size_t i = g->cache.count; i-- > 0;)
        if (g->executed - g->cache.items[i].last_frame > UNUSED_FRAMES)
            drop_cached(g, i);
}

void graph_release_objects(struct ng_graph *g)
{
    for (size_t i = g->cache.count; i-- > 0;)
        drop_cached(g, i);
    for (size_t i = 0; i < g->kept.count; i++) {
        empty_kept(&g->kept.items[i]);
        free(g->kept.items[i].name);
    }
    for (size_t i = 0; i < g->blocks.count; i++)
        ng_gpu_memory_free(g->params.gpu, &g->blocks.items[i].memory);
    ng_array_finish(&g->cache);
    ng_array_finish(&g->kept);
    ng_array_finish(&g->kept_slots);
    ng_array_finish(&g->blocks);
}

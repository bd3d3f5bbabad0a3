// Running a plan: for each step its barriers, then what it is. The only state is the batch that is being
// recorded and the serials under which earlier ones were submitted.
#include "graph/graph_internal.h"

#include "base/log.h"
#include "base/system.h"
#include "gpu/buffer.h"
#include "gpu/frame.h"
#include "gpu/image.h"
#include "gpu/timer.h"

#include <stdio.h>
#include <string.h>

struct run {
    struct ng_graph *g;
    struct ng_cmd **cmd;
    uint64_t *serials; // by batch submitted
    uint32_t batch;
    struct written *written; // by declared resource
    VkImageMemoryBarrier2 *image_barriers;
    VkBufferMemoryBarrier2 *buffer_barriers;
    VkMemoryBarrier2 *memory_barriers;
    uint64_t pass_start; // when the pass at work began, ng_clock_ns
    ng_result result;    // the first failure of a pass
};

// ---- Barriers ------------------------------------------------------------------------------------------

// Orders the frame after everything submitted before, whoever did it. Finer barriers between frames would
// have to know all owners of imported objects; the price is that two frames do not overlap on the GPU.
static void open_frame(VkCommandBuffer cmd)
{
    vkCmdPipelineBarrier2(cmd, &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                                   .memoryBarrierCount = 1,
                                                   .pMemoryBarriers = &(VkMemoryBarrier2){
                                                       .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                                       .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                                       .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                                       .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                                       .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT |
                                                                        VK_ACCESS_2_MEMORY_WRITE_BIT}});
}

static VkImageMemoryBarrier2 image_barrier(const struct ng_plan_barrier *b, const struct ng_gpu_image *image)
{
    return (VkImageMemoryBarrier2){
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = b->src_stages,
        .srcAccessMask = b->src_access,
        .dstStageMask = b->dst_stages,
        .dstAccessMask = b->dst_access,
        .oldLayout = b->old_layout,
        .newLayout = b->new_layout,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image->handle,
        .subresourceRange = {image->aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
}

static VkBufferMemoryBarrier2 buffer_barrier(const struct ng_plan_barrier *b,
                                             const struct ng_gpu_buffer *buffer)
{
    return (VkBufferMemoryBarrier2){.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2,
                                    .srcStageMask = b->src_stages,
                                    .srcAccessMask = b->src_access,
                                    .dstStageMask = b->dst_stages,
                                    .dstAccessMask = b->dst_access,
                                    .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                    .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                    .buffer = buffer->handle,
                                    .size = VK_WHOLE_SIZE};
}

// An object's barrier does not cover memory seen through another object, so taking memory over needs a global
// one.
static VkMemoryBarrier2 alias_barrier(const struct ng_plan_barrier *b)
{
    return (VkMemoryBarrier2){.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                              .srcStageMask = b->src_stages,
                              .srcAccessMask = b->src_access,
                              .dstStageMask = b->dst_stages,
                              .dstAccessMask = b->dst_access};
}

static void record_barriers(struct run *run, const struct ng_plan_step *step)
{
    uint32_t images = 0, buffers = 0, memory = 0;
    for (uint32_t i = 0; i < step->barrier_count; i++) {
        const struct ng_plan_barrier *b = &run->g->plan.barriers[step->first_barrier + i];
        const struct physical *p = &run->g->physical[b->resource];
        if (b->alias)
            run->memory_barriers[memory++] = alias_barrier(b);
        if (p->image)
            run->image_barriers[images++] = image_barrier(b, p->image);
        else
            run->buffer_barriers[buffers++] = buffer_barrier(b, p->buffer);
    }
    if (images + buffers + memory)
        vkCmdPipelineBarrier2((*run->cmd)->handle,
                              &(VkDependencyInfo){.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                                  .memoryBarrierCount = memory,
                                                  .pMemoryBarriers = run->memory_barriers,
                                                  .bufferMemoryBarrierCount = buffers,
                                                  .pBufferMemoryBarriers = run->buffer_barriers,
                                                  .imageMemoryBarrierCount = images,
                                                  .pImageMemoryBarriers = run->image_barriers});
}

// ---- What the graph does itself ------------------------------------------------------------------------

static void record_clear(struct run *run, const struct ng_plan_step *step)
{
    VkCommandBuffer cmd = (*run->cmd)->handle;
    for (uint32_t i = 0; i < step->use_count; i++) {
        const struct ng_plan_use *u = &run->g->plan.uses[step->first_use + i];
        const struct ng_plan_resource *r = &run->g->plan.resources[u->resource];
        const struct physical *p = &run->g->physical[u->resource];
        if (!r->is_image) {
            vkCmdFillBuffer(cmd, p->buffer->handle, 0, r->buffer.size, r->buffer.clear_word);
            continue;
        }
        VkImageSubresourceRange range = {p->image->aspect, u->part.mip, u->part.mip_count, u->part.layer,
                                         u->part.layer_count};
        const VkImageLayout layout = ng_use_info(u->use)->layout;
        if (ng_gpu_format_is_depth(r->image.format))
            vkCmdClearDepthStencilImage(cmd, p->image->handle, layout, &r->image.clear_value.depthStencil, 1,
                                        &range);
        else
            vkCmdClearColorImage(cmd, p->image->handle, layout, &r->image.clear_value.color, 1, &range);
    }
}

static void record_copy(struct run *run, const struct ng_plan_step *step)
{
    VkCommandBuffer cmd = (*run->cmd)->handle;
    const struct ng_plan_use *from = &run->g->plan.uses[step->first_use], *to = from + 1;
    const struct physical *src = &run->g->physical[from->resource], *dst = &run->g->physical[to->resource];
    const struct ng_plan_resource *r = &run->g->plan.resources[from->declared];
    VkImageAspectFlags aspect =
        ng_gpu_format_is_depth(r->image.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    VkBufferImageCopy region = {.imageSubresource = {aspect, 0, 0, r->image.layers},
                                .imageExtent = {r->image.width, r->image.height, 1}};
    if (!r->is_image)
        vkCmdCopyBuffer(cmd, src->buffer->handle, dst->buffer->handle, 1,
                        &(VkBufferCopy){.size = r->buffer.size});
    else if (src->image)
        vkCmdCopyImageToBuffer(cmd, src->image->handle, ng_use_info(from->use)->layout, dst->buffer->handle,
                               1, &region);
    else
        vkCmdCopyBufferToImage(cmd, src->buffer->handle, dst->image->handle, ng_use_info(to->use)->layout, 1,
                               &region);
}

// ---- Passes --------------------------------------------------------------------------------------------

static struct ng_pass_context make_context(struct run *run, uint32_t step, const struct ng_pass *p)
{
    struct ng_graph *g = run->g;
    return (struct ng_pass_context){.cmd = p->kind == NG_PASS_CPU ? NULL : *run->cmd,
                                    .width = p->width,
                                    .height = p->height,
                                    .jobs = g->params.jobs,
                                    .gpu = g->params.gpu,
                                    .data = p->data,
                                    .frame = g->executed,
                                    .graph = g,
                                    .step = step};
}

// Views of attachments and storage images see layers one by one; sampled ones see cubes as cubes.
static VkImageView view_of(const struct ng_graph *g, const struct ng_plan_use *u,
                           const struct ng_graph_part *part)
{
    const struct ng_graph_image_params *i = &g->plan.resources[u->resource].image;
    bool faces = i->cube && u->use == NG_USE_SAMPLED && part->layer_count % 6 == 0;
    bool arrayed = i->array || (u->use == NG_USE_SAMPLED ? i->layers > 1 : part->layer_count > 1);
    VkImageViewType type = arrayed ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    if (faces)
        type = part->layer_count > 6 || i->array ? VK_IMAGE_VIEW_TYPE_CUBE_ARRAY : VK_IMAGE_VIEW_TYPE_CUBE;
    return ng_gpu_image_view(g->physical[u->resource].image,
                             &(struct ng_gpu_view_params){.type = type,
                                                          .mip = part->mip,
                                                          .mips = part->mip_count,
                                                          .layer = part->layer,
                                                          .layers = part->layer_count});
}

static struct ng_gpu_attachment attachment(const struct ng_graph *g, const struct ng_plan_use *u)
{
    const struct ng_plan_resource *r = &g->plan.resources[u->resource];
    return (struct ng_gpu_attachment){.view = view_of(g, u, &u->part),
                                      .load = u->load == NG_LOAD_KEEP,
                                      .discard = !u->store,
                                      .clear = r->image.clear_value};
}

// Null views (the driver refused, which was logged) fail the pass.
static bool begin_rendering(struct run *run, const struct ng_plan_step *step, const struct ng_pass *p)
{
    struct ng_gpu_rendering_params r = {.width = p->width, .height = p->height, .layers = 1};
    bool good = true;
    for (uint32_t i = 0; i < step->use_count; i++) {
        const struct ng_plan_use *u = &run->g->plan.uses[step->first_use + i];
        bool depth = u->use == NG_USE_DEPTH || u->use == NG_USE_DEPTH_READ;
        if (u->use != NG_USE_COLOR && !depth)
            continue;
        struct ng_gpu_attachment a = attachment(run->g, u);
        good = good && a.view;
        r.layers = u->part.layer_count;
        if (depth) {
            r.depth = a;
            r.depth_layout = ng_use_info(u->use)->layout;
        } else {
            r.color[r.color_count++] = a;
        }
    }
    if (good)
        ng_cmd_rendering_begin(*run->cmd, &r);
    return good;
}

static ng_result run_gpu_pass(struct run *run, uint32_t step, const struct ng_pass *p)
{
    struct ng_cmd *cmd = *run->cmd;
    struct ng_pass_context ctx = make_context(run, step, p);
    uint32_t timer = ng_timer_begin(cmd, p->name);
    bool raster = p->kind == NG_PASS_RASTER;
    ng_result result = NG_ERROR_DEVICE;
    if (!raster || begin_rendering(run, &run->g->plan.steps[step], p)) {
        result = p->run(&ctx);
        if (raster)
            ng_cmd_rendering_end(cmd);
    }
    ng_timer_end(cmd, timer);
    return result;
}

// Waits for what the pass needs of the GPU; submits first if that is still being recorded.
static ng_result run_cpu_pass(struct run *run, uint32_t step, const struct ng_pass *p, ng_result *result)
{
    uint32_t wait = run->g->plan.steps[step].wait_batch;
    struct ng_gpu *gpu = run->g->params.gpu;
    if (wait != NG_PLAN_NONE && wait == run->batch)
        NG_TRY(ng_frame_submit(gpu, run->cmd, &run->serials[run->batch++]));
    if (wait != NG_PLAN_NONE)
        NG_TRY(ng_gpu_wait(gpu, run->serials[wait]));
    struct ng_pass_context ctx = make_context(run, step, p);
    run->pass_start = ng_clock_ns(); // waiting is not the pass's work
    *result = p->run(&ctx);
    return NG_OK;
}

// What the pass wrote counts only if it, and all others that wrote it, succeeded.
static void note_writes(struct run *run, const struct ng_pass *p, bool failed)
{
    for (size_t i = 0; i < p->uses.count; i++) {
        const struct decl_use *u = &p->uses.items[i];
        if (!u->write)
            continue;
        bool before = run->written[u->resource].failed && u->use != NG_USE_HOST_WRITE;
        run->written[u->resource].written = true;
        run->written[u->resource].failed = failed || before;
    }
}

// What its key promises cannot be made from what is not there.
static bool lacks_input(const struct run *run, const struct ng_pass *p)
{
    bool lacks = false;
    for (size_t i = 0; p->key && i < p->uses.count; i++) {
        const struct decl_use *u = &p->uses.items[i];
        const struct decl_resource *r = &run->g->resources.items[u->resource];
        lacks |= u->use != NG_USE_HOST_WRITE && !decl_is_scratch(r) && run->written[u->resource].failed;
    }
    return lacks;
}

static bool is_abandoned(struct ng_graph *g)
{
    g->abandoned = g->abandoned || (g->abandon && g->abandon(g->abandon_user));
    return g->abandoned;
}

static ng_result run_pass(struct run *run, uint32_t index)
{
    const struct ng_plan_step *step = &run->g->plan.steps[index];
    const struct ng_pass *p = run->g->passes.items[step->pass];
    ng_result result = NG_OK;
    if (is_abandoned(run->g) || lacks_input(run, p)) {
        note_writes(run, p, true);
        return NG_OK;
    }
    run->pass_start = ng_clock_ns();
    if (p->kind == NG_PASS_CPU)
        NG_TRY(run_cpu_pass(run, index, p, &result));
    else
        result = run_gpu_pass(run, index, p);
    if (result != NG_OK && run->result == NG_OK)
        run->result = result;
    note_writes(run, p, result != NG_OK);
    struct ng_pass_stats *stat = graph_stat(run->g, p->name);
    if (stat) {
        stat->cpu_ms = (double)(ng_clock_ns() - run->pass_start) * 1e-6;
        stat->runs++;
    }
    return run->g->params.gpu->lost ? NG_ERROR_DEVICE : NG_OK;
}

static const char *step_label(const struct ng_plan_step *step, char *buffer, size_t size)
{
    static const char *const verbs[] = {
        [NG_STEP_CLEAR] = "clear ", [NG_STEP_DOWNLOAD] = "download ", [NG_STEP_UPLOAD] = "upload "};
    snprintf(buffer, size, "%s%s", step->kind < NG_COUNT(verbs) && verbs[step->kind] ? verbs[step->kind] : "",
             step->name);
    return buffer;
}

static ng_result run_step(struct run *run, uint32_t index)
{
    const struct ng_plan_step *step = &run->g->plan.steps[index];
    char label[96];
    if (step->pass_kind == NG_PASS_CPU) {
        record_barriers(run, step);
        return run_pass(run, index);
    }
    ng_cmd_label_begin(*run->cmd, step_label(step, label, sizeof label));
    record_barriers(run, step);
    ng_result result = NG_OK;
    switch (step->kind) {
    case NG_STEP_PASS:
        result = run_pass(run, index);
        break;
    case NG_STEP_CLEAR:
        record_clear(run, step);
        break;
    case NG_STEP_DOWNLOAD:
    case NG_STEP_UPLOAD:
        record_copy(run, step);
        break;
    case NG_STEP_FINAL:
        break;
    }
    ng_cmd_label_end(*run->cmd);
    return result;
}

// ---- The frame -----------------------------------------------------------------------------------------

// Host memory of this slot may still be read by the frame that had it before. Usually ng_frame_begin has
// waited for that; not if a graph is executed several times within one frame of the device.
static ng_result wait_for_slot(struct run *run)
{
    struct ng_gpu *gpu = run->g->params.gpu;
    uint64_t serial = run->g->slot_serials[run->g->executed % NG_GPU_FRAMES];
    if (serial >= ng_gpu_serial(gpu))
        NG_TRY(ng_frame_submit(gpu, run->cmd, NULL));
    return serial ? ng_gpu_wait(gpu, serial) : NG_OK;
}

static ng_result prepare(struct run *run)
{
    struct ng_graph *g = run->g;
    NG_TRY(wait_for_slot(run));
    uint32_t barriers = 0;
    for (uint32_t i = 0; i < g->plan.step_count; i++)
        if (g->plan.steps[i].barrier_count > barriers)
            barriers = g->plan.steps[i].barrier_count;
    run->serials = ng_arena_array(&g->arena, g->plan.batch_count, sizeof *run->serials);
    run->written = ng_arena_array(&g->arena, g->resources.count, sizeof *run->written);
    run->image_barriers = ng_arena_array(&g->arena, barriers, sizeof *run->image_barriers);
    run->buffer_barriers = ng_arena_array(&g->arena, barriers, sizeof *run->buffer_barriers);
    run->memory_barriers = ng_arena_array(&g->arena, barriers, sizeof *run->memory_barriers);
    if (!run->serials || !run->written || !run->image_barriers || !run->buffer_barriers ||
        !run->memory_barriers)
        return graph_no_memory(g);
    return graph_realise(g);
}

ng_result ng_graph_execute(struct ng_graph *g, struct ng_cmd **cmd)
{
    NG_REQUIRE(g && g->params.gpu, "ng_graph_execute: the graph has no device");
    NG_REQUIRE(cmd && *cmd, "ng_graph_execute: no commands; call it between ng_frame_begin and ng_frame_end");
    NG_REQUIRE(!g->has_run, "ng_graph_execute: the frame has been executed; declare another");
    NG_TRY(ng_graph_compile(g));
    struct run run = {.g = g, .cmd = cmd};
    NG_TRY(prepare(&run));
    g->has_run = true;
    graph_read_timers(g);
    graph_count_skipped(g);
    open_frame((*cmd)->handle);
    ng_result result = NG_OK;
    for (uint32_t i = 0; i < g->plan.step_count && result == NG_OK; i++)
        result = run_step(&run, i);
    graph_retire(g, run.written);
    g->last_serial = ng_gpu_serial(g->params.gpu);
    g->slot_serials[g->executed % NG_GPU_FRAMES] = g->last_serial;
    g->executed++;
    if (result == NG_OK && g->abandoned)
        return NG_ABANDONED;
    return result != NG_OK ? result : run.result;
}

void ng_graph_abandon_when(struct ng_graph *g, bool (*abandon)(void *user), void *user)
{
    g->abandon = abandon;
    g->abandon_user = user;
}

bool ng_pass_is_abandoned(const struct ng_pass_context *ctx)
{
    return is_abandoned(ctx->graph);
}

static struct ng_graph_memory describe(const struct ng_plan_resource *r, void *data)
{
    if (!r->is_image)
        return (struct ng_graph_memory){.data = data, .size = r->buffer.size};
    uint64_t row = (uint64_t)ng_gpu_format_size(r->image.format) * r->image.width;
    return (struct ng_graph_memory){.data = data,
                                    .size = graph_linear_size(&r->image),
                                    .format = r->image.format,
                                    .width = r->image.width,
                                    .height = r->image.height,
                                    .layers = r->image.layers,
                                    .row_bytes = row,
                                    .layer_bytes = row * r->image.height};
}

ng_result ng_graph_readback_get(struct ng_graph *g, const char *name, struct ng_graph_memory *out)
{
    NG_REQUIRE(g->has_run, "ng_graph_readback_get('%s'): no frame has been executed since ng_graph_begin",
               name);
    const struct ng_plan_use *found = NULL;
    const struct ng_plan_step *final = &g->plan.steps[g->plan.step_count - 1];
    for (uint32_t i = 0; i < final->use_count && !found; i++) {
        const struct ng_plan_use *u = &g->plan.uses[final->first_use + i];
        if (u->use == NG_USE_HOST_READ && !strcmp(g->plan.resources[u->declared].name, name))
            found = u;
    }
    if (!found) {
        ng_log_error(
            "graph: nothing to read back as '%s': the frame wrote no such resource, or was not asked for it",
            name);
        return NG_ERROR_NOT_FOUND;
    }
    NG_TRY(ng_gpu_wait(g->params.gpu, g->last_serial));
    *out = describe(&g->plan.resources[found->declared], g->physical[found->resource].buffer->mapped);
    return NG_OK;
}

// ---- What callbacks ask --------------------------------------------------------------------------------

static bool same_part(const struct ng_graph_part *a, const struct ng_graph_part *b)
{
    return a->mip == b->mip && a->layer == b->layer && (!b->mip_count || a->mip_count == b->mip_count) &&
           (!b->layer_count || a->layer_count == b->layer_count);
}

// The use that this pass declared of the resource, and of that part of it if one is given.
static const struct ng_plan_use *find_use(const struct ng_pass_context *ctx, struct ng_graph_ref ref,
                                          const struct ng_graph_part *part)
{
    const struct ng_graph *g = ctx->graph;
    const struct ng_plan_step *step = &g->plan.steps[ctx->step];
    for (uint32_t i = 0; i < step->use_count && graph_knows(g, ref); i++) {
        const struct ng_plan_use *u = &g->plan.uses[step->first_use + i];
        if (u->declared == REF_RESOURCE(ref) && (!part || same_part(&u->part, part)))
            return u;
    }
    ng_log_error("graph: pass '%s' asks for '%s'%s, which it did not declare", step->name,
                 graph_knows(g, ref) ? g->resources.items[REF_RESOURCE(ref)].name : "(an unknown resource)",
                 part ? " (a part of it)" : "");
    return NULL;
}

struct ng_gpu_image *ng_pass_image(const struct ng_pass_context *ctx, struct ng_graph_ref ref)
{
    const struct ng_plan_use *u = find_use(ctx, ref, NULL);
    return u ? ctx->graph->physical[u->resource].image : NULL;
}

VkImageView ng_pass_view_part(const struct ng_pass_context *ctx, struct ng_graph_ref ref,
                              const struct ng_graph_part *part)
{
    const struct ng_plan_use *u = find_use(ctx, ref, part);
    return u && ctx->graph->physical[u->resource].image ? view_of(ctx->graph, u, &u->part) : VK_NULL_HANDLE;
}

VkImageView ng_pass_view(const struct ng_pass_context *ctx, struct ng_graph_ref ref)
{
    return ng_pass_view_part(ctx, ref, NULL);
}

VkImageLayout ng_pass_layout(const struct ng_pass_context *ctx, struct ng_graph_ref ref)
{
    const struct ng_plan_use *u = find_use(ctx, ref, NULL);
    return u ? ng_use_info(u->use)->layout : VK_IMAGE_LAYOUT_UNDEFINED;
}

struct ng_gpu_buffer *ng_pass_buffer(const struct ng_pass_context *ctx, struct ng_graph_ref ref)
{
    const struct ng_plan_use *u = find_use(ctx, ref, NULL);
    return u ? ctx->graph->physical[u->resource].buffer : NULL;
}

struct ng_graph_memory ng_pass_memory(const struct ng_pass_context *ctx, struct ng_graph_ref ref)
{
    const struct ng_plan_use *u = find_use(ctx, ref, NULL);
    if (!u || !ng_use_info(u->use)->host)
        return (struct ng_graph_memory){0};
    return describe(&ctx->graph->plan.resources[u->declared],
                    ctx->graph->physical[u->resource].buffer->mapped);
}

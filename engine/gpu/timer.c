// Two timestamps a scope, in a query pool of each frame slot. Queries are reset by the host when the slot
// comes round, at which time its last frame is known to be done.
#include "gpu/timer.h"

#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <stdlib.h>

ng_result ng_gpu_timers_init(struct ng_gpu *gpu, struct ng_gpu_recorder *r)
{
    struct ng_gpu_internal *in = gpu->internal;
    if (!in->timings)
        in->timings = ng_gpu_host_alloc(gpu, NG_GPU_MAX_SCOPES * sizeof *in->timings, "timings");
    r->scopes = ng_gpu_host_alloc(gpu, NG_GPU_MAX_SCOPES * sizeof *r->scopes, "timer scopes");
    if (!in->timings || !r->scopes)
        return NG_ERROR_MEMORY;
    if (!in->timestamp_bits)
        return NG_OK;
    VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                  .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                  .queryCount = 2 * NG_GPU_MAX_SCOPES};
    NG_TRY(ng_gpu_check(gpu, vkCreateQueryPool(gpu->device, &info, NULL, &r->queries), "create",
                        "timer queries"));
    ng_gpu_set_name(gpu, VK_OBJECT_TYPE_QUERY_POOL, (uint64_t)r->queries, "timer queries");
    vkResetQueryPool(gpu->device, r->queries, 0, 2 * NG_GPU_MAX_SCOPES);
    return NG_OK;
}

uint32_t ng_timer_begin(struct ng_cmd *cmd, const char *name)
{
    struct ng_gpu_recorder *r = cmd->recorder;
    if (!r->queries || r->scope_count == NG_GPU_MAX_SCOPES)
        return UINT32_MAX;
    uint32_t token = r->scope_count++;
    r->scopes[token].ended = false;
    snprintf(r->scopes[token].name, sizeof r->scopes[token].name, "%s", name);
    // Bottom of the pipe both times: from the end of what came before to the end of what is in the scope.
    vkCmdWriteTimestamp2(cmd->handle, VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, r->queries, 2 * token);
    return token;
}

void ng_timer_end(struct ng_cmd *cmd, uint32_t token)
{
    struct ng_gpu_recorder *r = cmd->recorder;
    if (token >= r->scope_count)
        return;
    r->scopes[token].ended = true;
    vkCmdWriteTimestamp2(cmd->handle, VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT, r->queries, 2 * token + 1);
}

// Milliseconds between two timestamps, which count modulo 2^bits.
static double milliseconds(const struct ng_gpu *gpu, uint64_t from, uint64_t to)
{
    uint32_t bits = gpu->internal->timestamp_bits;
    uint64_t mask = bits >= 64 ? UINT64_MAX : ((uint64_t)1 << bits) - 1;
    return (double)((to - from) & mask) * (double)gpu->properties.limits.timestampPeriod * 1e-6;
}

static void publish(struct ng_gpu *gpu, const struct ng_gpu_recorder *r, const uint64_t *ticks)
{
    struct ng_gpu_internal *in = gpu->internal;
    in->timings_frame = r->frame;
    in->timing_count = 0;
    for (uint32_t i = 0; i < r->scope_count; i++) {
        if (!r->scopes[i].ended)
            continue;
        struct ng_gpu_timing *t = &in->timings[in->timing_count++];
        snprintf(t->name, sizeof t->name, "%s", r->scopes[i].name);
        t->begin_ms = milliseconds(gpu, ticks[0], ticks[2 * i]);
        t->gpu_ms = milliseconds(gpu, ticks[2 * i], ticks[2 * i + 1]);
    }
}

void ng_gpu_timers_collect(struct ng_gpu *gpu, struct ng_gpu_recorder *r)
{
    uint64_t ticks[2 * NG_GPU_MAX_SCOPES] = {0};
    if (!r->scope_count)
        return;
    // VK_NOT_READY where a scope was never ended: the others are valid.
    VkResult result =
        NG_GPU_CALL(gpu, vkGetQueryPoolResults(gpu->device, r->queries, 0, 2 * r->scope_count, sizeof ticks,
                                               ticks, sizeof *ticks, VK_QUERY_RESULT_64_BIT));
    if (ng_gpu_check(gpu, result, "read", "timer queries") == NG_OK)
        publish(gpu, r, ticks);
    if (!gpu->lost)
        vkResetQueryPool(gpu->device, r->queries, 0, 2 * r->scope_count);
    r->scope_count = 0;
}

const struct ng_gpu_timing *ng_gpu_timings(const struct ng_gpu *gpu, uint32_t *count)
{
    *count = gpu->internal->timing_count;
    return *count ? gpu->internal->timings : NULL;
}

uint64_t ng_gpu_timings_frame(const struct ng_gpu *gpu)
{
    return gpu->internal->timings_frame;
}

// Geometry on the GPU: one buffer a mesh, with the streams one after the other. Dynamic meshes take turns
// between buffers that are mapped; static ones have one, into which points that were edited are staged.
#include "render/scene_gpu_internal.h"

#include "base/log.h"
#include "gpu/transfer.h"

#include <string.h>

#define STAGED                                                                                               \
    ((uint64_t)4 << 20) // bytes of an upload at most: such ones fit into the ring of staging buffers

// ---- Vertex input ----------------------------------------------------------------------------------------

#define MAX_STREAMS 7
#define FLOAT2(n)                                                                                            \
    {                                                                                                        \
        .location = (n), .binding = (n), .format = VK_FORMAT_R32G32_SFLOAT                                   \
    }
#define FLOAT3(n)                                                                                            \
    {                                                                                                        \
        .location = (n), .binding = (n), .format = VK_FORMAT_R32G32B32_SFLOAT                                \
    }
#define FLOAT4(n)                                                                                            \
    {                                                                                                        \
        .location = (n), .binding = (n), .format = VK_FORMAT_R32G32B32A32_SFLOAT                             \
    }
#define UNORM4(n)                                                                                            \
    {                                                                                                        \
        .location = (n), .binding = (n), .format = VK_FORMAT_R16G16B16A16_UNORM                              \
    }

// Each stream is a buffer binding of its own, with the number of its location.
static const struct streams {
    uint32_t count;
    enum ng_mesh_stream streams[MAX_STREAMS];
    struct ng_gpu_vertex_binding bindings[MAX_STREAMS];
    struct ng_gpu_vertex_attribute attributes[MAX_STREAMS];
} streams_of[] = {
    [NG_STREAMS_POSITION] = {1, {NG_STREAM_POSITION}, {{12, false}}, {FLOAT3(0)}},
    [NG_STREAMS_POSITION_UV] = {2,
                                {NG_STREAM_POSITION, NG_STREAM_UV},
                                {{12, false}, {8, false}},
                                {FLOAT3(0), FLOAT2(1)}},
    [NG_STREAMS_SURFACE] = {2,
                            {NG_STREAM_POSITION, NG_STREAM_NORMAL},
                            {{12, false}, {12, false}},
                            {FLOAT3(0), FLOAT3(1)}},
    [NG_STREAMS_SURFACE_MOVING] = {3,
                                   {NG_STREAM_POSITION, NG_STREAM_NORMAL, NG_STREAM_PREVIOUS},
                                   {{12, false}, {12, false}, {12, false}},
                                   {FLOAT3(0), FLOAT3(1), FLOAT3(2)}},
    [NG_STREAMS_SURFACE_TEXTURED] = {4,
                                     {NG_STREAM_POSITION, NG_STREAM_NORMAL, NG_STREAM_TANGENT, NG_STREAM_UV},
                                     {{12, false}, {12, false}, {16, false}, {8, false}},
                                     {FLOAT3(0), FLOAT3(1), FLOAT4(2), FLOAT2(3)}},
    [NG_STREAMS_SURFACE_TEXTURED_MOVING] = {5,
                                            {NG_STREAM_POSITION, NG_STREAM_NORMAL, NG_STREAM_TANGENT,
                                             NG_STREAM_UV, NG_STREAM_PREVIOUS},
                                            {{12, false}, {12, false}, {16, false}, {8, false}, {12, false}},
                                            {FLOAT3(0), FLOAT3(1), FLOAT4(2), FLOAT2(3), FLOAT3(4)}},
    [NG_STREAMS_POSITION_FULL] = {4,
                                  {NG_STREAM_POSITION, NG_STREAM_UV, NG_STREAM_UV1, NG_STREAM_COLOR},
                                  {{12, false}, {8, false}, {8, false}, {8, false}},
                                  {FLOAT3(0), FLOAT2(1), FLOAT2(2), UNORM4(3)}},
    [NG_STREAMS_SURFACE_FULL] = {6,
                                 {NG_STREAM_POSITION, NG_STREAM_NORMAL, NG_STREAM_TANGENT, NG_STREAM_UV,
                                  NG_STREAM_UV1, NG_STREAM_COLOR},
                                 {{12, false}, {12, false}, {16, false}, {8, false}, {8, false}, {8, false}},
                                 {FLOAT3(0), FLOAT3(1), FLOAT4(2), FLOAT2(3), FLOAT2(4), UNORM4(5)}},
    [NG_STREAMS_SURFACE_FULL_MOVING] =
        {7,
         {NG_STREAM_POSITION, NG_STREAM_NORMAL, NG_STREAM_TANGENT, NG_STREAM_UV, NG_STREAM_UV1,
          NG_STREAM_COLOR, NG_STREAM_PREVIOUS},
         {{12, false}, {12, false}, {16, false}, {8, false}, {8, false}, {8, false}, {12, false}},
         {FLOAT3(0), FLOAT3(1), FLOAT4(2), FLOAT2(3), FLOAT2(4), UNORM4(5), FLOAT3(6)}},
};

// Of these a stream may be that of one vertex for all.
static bool is_full(enum ng_vertex_streams streams)
{
    return streams >= NG_STREAMS_POSITION_FULL;
}

void ng_scene_gpu_vertex_input(enum ng_vertex_streams streams, struct ng_gpu_graphics_params *params)
{
    const struct streams *s = &streams_of[streams];
    params->vertex_bindings = s->bindings;
    params->vertex_attributes = s->attributes;
    params->vertex_binding_count = params->vertex_attribute_count = s->count;
    params->dynamic_strides = is_full(streams);
}

// ---- Meshes ----------------------------------------------------------------------------------------------

static uint64_t stream_bytes(const struct ng_snapshot_mesh *m, enum ng_mesh_stream stream)
{
    static const uint64_t per_vertex[NG_STREAM_COUNT] = {12, 12, 16, 8, 8, 8, 0, 12};
    if ((stream == NG_STREAM_PREVIOUS && !m->dynamic) || (stream == NG_STREAM_UV1 && !m->uvs1))
        return 0;
    if (stream == NG_STREAM_COLOR && !m->colors)
        return per_vertex[stream]; // white
    return stream == NG_STREAM_INDEX ? 4ull * m->index_count : per_vertex[stream] * m->vertex_count;
}

static const void *stream_data(const struct ng_snapshot_mesh *m, enum ng_mesh_stream stream)
{
    static const uint16_t white[4] = {UINT16_MAX, UINT16_MAX, UINT16_MAX, UINT16_MAX};
    const void *colors = m->colors ? m->colors : white;
    const void *data[NG_STREAM_COUNT] = {m->positions, m->normals, m->tangents, m->uvs,
                                         m->uvs1,      colors,     m->indices,  m->previous_positions};
    return data[stream];
}

// Copies a dynamic mesh into the buffer whose turn it is: the other may still be read by the last frame.
static void write_dynamic(struct ng_mesh_entry *e, const struct ng_snapshot_mesh *m)
{
    e->current = (e->current + 1) % NG_GPU_FRAMES;
    unsigned char *to = e->buffers[e->current]->mapped;
    for (enum ng_mesh_stream i = 0; i < NG_STREAM_COUNT; i++)
        if (stream_data(m, i))
            memcpy(to + e->offsets[i], stream_data(m, i), stream_bytes(m, i));
    e->moved = m->previous_positions != NULL;
    e->revision = m->revision;
}

// Writes a stream of a static mesh.
static ng_result upload(struct ng_mesh_entry *e, const struct ng_snapshot_mesh *m, enum ng_mesh_stream stream)
{
    const unsigned char *data = stream_data(m, stream);
    for (uint64_t at = 0, size = stream_bytes(m, stream); at < size; at += STAGED) {
        uint64_t rest = size - at;
        NG_TRY(ng_upload_buffer(e->buffers[0], e->offsets[stream] + at, data + at,
                                rest < STAGED ? rest : STAGED));
    }
    return NG_OK;
}

static void finish_mesh(struct ng_mesh_entry *m)
{
    for (uint32_t i = 0; i < NG_GPU_FRAMES; i++)
        ng_gpu_buffer_destroy(&m->buffers[i]);
}

static ng_result make_buffers(struct ng_gpu *gpu, struct ng_mesh_entry *e, const struct ng_snapshot_mesh *m)
{
    uint64_t size = 0;
    for (enum ng_mesh_stream i = 0; i < NG_STREAM_COUNT; i++) {
        e->offsets[i] = size;
        size += (stream_bytes(m, i) + 15) & ~15ull;
    }
    e->vertex_count = m->vertex_count;
    e->index_count = m->index_count;
    e->has_uvs1 = m->uvs1;
    e->has_colors = m->colors;
    for (uint32_t i = 0; i < (m->dynamic ? NG_GPU_FRAMES : 1); i++)
        NG_TRY(ng_gpu_buffer_create(gpu,
                                    &(struct ng_gpu_buffer_params){
                                        .name = "mesh",
                                        .size = size ? size : 1,
                                        .memory = m->dynamic ? NG_GPU_MEMORY_UPLOAD : NG_GPU_MEMORY_DEVICE},
                                    &e->buffers[i]));
    return NG_OK;
}

static ng_result make_mesh(struct ng_gpu *gpu, struct ng_mesh_entry *e, const struct ng_snapshot_mesh *m)
{
    NG_TRY(make_buffers(gpu, e, m));
    for (enum ng_mesh_stream i = 0; i < NG_STREAM_COUNT && !m->dynamic; i++)
        NG_TRY(upload(e, m, i));
    if (m->dynamic)
        write_dynamic(e, m);
    e->revision = m->revision;
    return NG_OK;
}

// Brings a mesh up to date that has its buffers.
static ng_result follow_mesh(struct ng_mesh_entry *e, const struct ng_snapshot_mesh *m)
{
    if (e->revision == m->revision) {
        e->moved = false;
        return NG_OK;
    }
    if (m->dynamic) {
        write_dynamic(e, m);
        return NG_OK;
    }
    NG_TRY(upload(e, m, NG_STREAM_POSITION));
    NG_TRY(upload(e, m, NG_STREAM_NORMAL));
    NG_TRY(upload(e, m, NG_STREAM_TANGENT));
    e->revision = m->revision;
    return NG_OK;
}

// ---- The cache -------------------------------------------------------------------------------------------

static ng_result find_entry(struct ng_mesh_cache *c, uint32_t index, uint64_t key)
{
    uint32_t at = c->of.items[index];
    if (at < c->entries.count && c->entries.items[at].key == key)
        return NG_OK;
    at = ng_index_map_get(&c->at, key);
    if (at == UINT32_MAX) {
        at = (uint32_t)c->entries.count;
        if (!ng_array_push(&c->entries, (struct ng_mesh_entry){.key = key}) ||
            !ng_index_map_set(&c->at, key, at))
            return ng_out_of_memory("the scene on the GPU");
    }
    c->of.items[index] = at;
    return NG_OK;
}

static ng_result update_mesh(struct ng_mesh_cache *c, uint32_t index, const struct ng_snapshot_mesh *m,
                             uint64_t frame)
{
    NG_TRY(find_entry(c, index, m->key));
    struct ng_mesh_entry *e = &c->entries.items[c->of.items[index]];
    e->last_used = frame;
    if (e->buffers[0] && e->vertex_count == m->vertex_count && e->index_count == m->index_count)
        return follow_mesh(e, m);
    finish_mesh(e);
    ng_result r = make_mesh(c->gpu, e, m);
    if (r != NG_OK)
        finish_mesh(e);
    return r;
}

ng_result ng_mesh_cache_update(struct ng_mesh_cache *c, const struct ng_snapshot *snapshot, uint64_t frame)
{
    if (!ng_array_resize(&c->of, snapshot->mesh_count))
        return ng_out_of_memory("the scene on the GPU");
    for (uint32_t i = 0; i < snapshot->mesh_count; i++)
        NG_TRY(update_mesh(c, i, &snapshot->meshes[i], frame));
    return NG_OK;
}

void ng_mesh_cache_drop(struct ng_mesh_cache *c, uint64_t oldest)
{
    size_t before = c->entries.count;
    for (size_t i = before; i-- > 0;)
        if (c->entries.items[i].last_used < oldest) {
            finish_mesh(&c->entries.items[i]);
            ng_array_swap_remove(&c->entries, i);
        }
    if (c->entries.count == before)
        return;
    ng_index_map_clear(&c->at);
    for (uint32_t i = 0; i < c->entries.count; i++)
        (void)ng_index_map_set(&c->at, c->entries.items[i].key, i); // does not grow: it held as many
}

void ng_mesh_cache_finish(struct ng_mesh_cache *c)
{
    for (size_t i = 0; i < c->entries.count; i++)
        finish_mesh(&c->entries.items[i]);
    ng_array_finish(&c->entries);
    ng_index_map_finish(&c->at);
    ng_array_finish(&c->of);
}

void ng_mesh_cache_bind(const struct ng_mesh_cache *c, struct ng_cmd *cmd, uint32_t mesh,
                        enum ng_vertex_streams streams)
{
    const struct ng_mesh_entry *e = &c->entries.items[c->of.items[mesh]];
    const struct streams *wanted = &streams_of[streams];
    VkBuffer b = e->buffers[e->current]->handle, buffers[MAX_STREAMS];
    VkDeviceSize offsets[MAX_STREAMS], strides[MAX_STREAMS];
    for (uint32_t i = 0; i < wanted->count; i++) {
        // Vertices that have not moved against their object are where they were.
        enum ng_mesh_stream stream = wanted->streams[i];
        if (stream == NG_STREAM_PREVIOUS && !e->moved)
            stream = NG_STREAM_POSITION;
        if (stream == NG_STREAM_UV1 && !e->has_uvs1)
            stream = NG_STREAM_UV;
        buffers[i] = b;
        offsets[i] = e->offsets[stream];
        strides[i] = stream == NG_STREAM_COLOR && !e->has_colors ? 0 : wanted->bindings[i].stride;
    }
    if (is_full(streams))
        vkCmdBindVertexBuffers2(cmd->handle, 0, wanted->count, buffers, offsets, NULL, strides);
    else
        vkCmdBindVertexBuffers(cmd->handle, 0, wanted->count, buffers, offsets);
    vkCmdBindIndexBuffer(cmd->handle, b, e->offsets[NG_STREAM_INDEX], VK_INDEX_TYPE_UINT32);
}

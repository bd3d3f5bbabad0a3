// Geometry and textures live in caches keyed by the snapshot's keys. Instances are written in the order in
// which they are best drawn (by pipeline, textures, facing, mesh), so that neighbours that are visible merge
// into one draw.
#include "render/scene_gpu.h"

#include "asset/assets.h"
#include "base/array.h"
#include "base/hash.h"
#include "base/log.h"
#include "gpu/transfer.h"
#include "render/index_map.h"
#include "render/passes.h"

#include <cglm/cglm.h>
#include <stdlib.h>
#include <string.h>

#define UNUSED_FRAMES 120 // frames after which what nobody asks for is dropped
#define TEXTURES      4   // of a material

// The parts of a mesh's buffer; the last is there for meshes that deform only.
enum stream {
    STREAM_POSITION,
    STREAM_NORMAL,
    STREAM_TANGENT,
    STREAM_UV,
    STREAM_INDEX,
    STREAM_PREVIOUS,
    STREAM_COUNT
};

struct mesh_entry {
    uint64_t key, revision, last_used;
    struct ng_gpu_buffer *buffers[NG_GPU_FRAMES]; // dynamic meshes take turns
    uint32_t current;
    uint64_t offsets[STREAM_COUNT];
    bool moved; // dynamic: the previous positions are those of another revision
};

struct image_entry {
    uint64_t key, last_used;
    struct ng_gpu_image *image;
    VkSampler sampler;
};

struct group_entry {
    uint64_t key, last_used; // hash of the image keys
    struct ng_gpu_bind_group *group;
};

struct draw_key {
    uint64_t sort;     // textured or not, facing and mesh
    uint64_t group;    // textures
    uint32_t kind;     // enum kind
    uint32_t instance; // of the snapshot
};

struct ng_scene_gpu {
    struct ng_gpu *gpu;
    uint64_t frame;
    const struct ng_snapshot *snapshot;
    struct ng_view_data view;
    NG_ARRAY(struct mesh_entry) meshes;
    NG_ARRAY(struct image_entry) images;
    NG_ARRAY(struct group_entry) groups;
    struct ng_index_map mesh_at, image_at, group_at; // entries by key
    NG_ARRAY(uint32_t) mesh_of, image_of;            // cache entries of the snapshot's meshes and images
    NG_ARRAY(struct draw_key) order;
    struct ng_gpu_image *white, *black; // one texel each
    struct ng_frame_range view_range, instance_range, material_range;
};

// ---- Vertex input ----------------------------------------------------------------------------------------

#define MAX_STREAMS 5
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

// Each stream is a buffer binding of its own, with the number of its location.
static const struct streams {
    uint32_t count;
    enum stream streams[MAX_STREAMS];
    struct ng_gpu_vertex_binding bindings[MAX_STREAMS];
    struct ng_gpu_vertex_attribute attributes[MAX_STREAMS];
} streams_of[] = {
    [NG_STREAMS_POSITION] = {1, {STREAM_POSITION}, {{12, false}}, {FLOAT3(0)}},
    [NG_STREAMS_POSITION_UV] = {2,
                                {STREAM_POSITION, STREAM_UV},
                                {{12, false}, {8, false}},
                                {FLOAT3(0), FLOAT2(1)}},
    [NG_STREAMS_SURFACE] = {2,
                            {STREAM_POSITION, STREAM_NORMAL},
                            {{12, false}, {12, false}},
                            {FLOAT3(0), FLOAT3(1)}},
    [NG_STREAMS_SURFACE_MOVING] = {3,
                                   {STREAM_POSITION, STREAM_NORMAL, STREAM_PREVIOUS},
                                   {{12, false}, {12, false}, {12, false}},
                                   {FLOAT3(0), FLOAT3(1), FLOAT3(2)}},
    [NG_STREAMS_SURFACE_TEXTURED] = {4,
                                     {STREAM_POSITION, STREAM_NORMAL, STREAM_TANGENT, STREAM_UV},
                                     {{12, false}, {12, false}, {16, false}, {8, false}},
                                     {FLOAT3(0), FLOAT3(1), FLOAT4(2), FLOAT2(3)}},
    [NG_STREAMS_SURFACE_TEXTURED_MOVING] = {5,
                                            {STREAM_POSITION, STREAM_NORMAL, STREAM_TANGENT, STREAM_UV,
                                             STREAM_PREVIOUS},
                                            {{12, false}, {12, false}, {16, false}, {8, false}, {12, false}},
                                            {FLOAT3(0), FLOAT3(1), FLOAT4(2), FLOAT2(3), FLOAT3(4)}},
};

void ng_scene_gpu_vertex_input(enum ng_vertex_streams streams, struct ng_gpu_graphics_params *params)
{
    const struct streams *s = &streams_of[streams];
    params->vertex_bindings = s->bindings;
    params->vertex_attributes = s->attributes;
    params->vertex_binding_count = params->vertex_attribute_count = s->count;
}

// ---- Life ------------------------------------------------------------------------------------------------

static ng_result make_texel(struct ng_scene_gpu *s, const char *name, uint32_t rgba,
                            struct ng_gpu_image **out)
{
    NG_TRY(ng_gpu_image_create(s->gpu,
                               &(struct ng_gpu_image_params){
                                   .name = name, .width = 1, .height = 1, .format = VK_FORMAT_R8G8B8A8_UNORM},
                               out));
    return ng_upload_image(*out, &(struct ng_upload_image_params){.data = &rgba, .size = sizeof rgba});
}

ng_result ng_scene_gpu_create(struct ng_gpu *gpu, struct ng_scene_gpu **out)
{
    *out = NULL;
    struct ng_scene_gpu *s = calloc(1, sizeof *s);
    if (!s)
        return ng_out_of_memory("the scene on the GPU");
    s->gpu = gpu;
    ng_result r = make_texel(s, "white", 0xffffffffu, &s->white);
    if (r == NG_OK)
        r = make_texel(s, "black", 0, &s->black);
    if (r != NG_OK)
        ng_scene_gpu_destroy(&s);
    *out = s;
    return r;
}

static void finish_mesh(struct mesh_entry *m)
{
    for (uint32_t i = 0; i < NG_GPU_FRAMES; i++)
        ng_gpu_buffer_destroy(&m->buffers[i]);
}

void ng_scene_gpu_destroy(struct ng_scene_gpu **scene)
{
    struct ng_scene_gpu *s = *scene;
    if (!s)
        return;
    for (size_t i = 0; i < s->meshes.count; i++)
        finish_mesh(&s->meshes.items[i]);
    for (size_t i = 0; i < s->groups.count; i++)
        ng_gpu_bind_group_destroy(&s->groups.items[i].group);
    for (size_t i = 0; i < s->images.count; i++)
        ng_gpu_image_destroy(&s->images.items[i].image);
    ng_gpu_image_destroy(&s->white);
    ng_gpu_image_destroy(&s->black);
    ng_array_finish(&s->meshes);
    ng_array_finish(&s->images);
    ng_array_finish(&s->groups);
    ng_index_map_finish(&s->mesh_at);
    ng_index_map_finish(&s->image_at);
    ng_index_map_finish(&s->group_at);
    ng_array_finish(&s->mesh_of);
    ng_array_finish(&s->image_of);
    ng_array_finish(&s->order);
    free(s);
    *scene = NULL;
}

// ---- Meshes ----------------------------------------------------------------------------------------------

static uint64_t stream_bytes(const struct ng_snapshot_mesh *m, enum stream stream)
{
    static const uint64_t per_vertex[STREAM_COUNT] = {12, 12, 16, 8, 0, 12};
    if (stream == STREAM_PREVIOUS && !m->dynamic)
        return 0;
    return stream == STREAM_INDEX ? 4ull * m->index_count : per_vertex[stream] * m->vertex_count;
}

static const void *stream_data(const struct ng_snapshot_mesh *m, enum stream stream)
{
    const void *data[STREAM_COUNT] = {m->positions, m->normals, m->tangents,
                                      m->uvs,       m->indices, m->previous_positions};
    return data[stream];
}

// Copies a dynamic mesh into the buffer whose turn it is: the other may still be read by the last frame.
static void write_dynamic(struct mesh_entry *e, const struct ng_snapshot_mesh *m)
{
    e->current = (e->current + 1) % NG_GPU_FRAMES;
    unsigned char *to = e->buffers[e->current]->mapped;
    for (enum stream i = 0; i < STREAM_COUNT; i++)
        if (stream_data(m, i))
            memcpy(to + e->offsets[i], stream_data(m, i), stream_bytes(m, i));
    e->moved = m->previous_positions != NULL;
    e->revision = m->revision;
}

static ng_result upload_mesh(struct ng_scene_gpu *s, struct mesh_entry *e, const struct ng_snapshot_mesh *m)
{
    uint64_t size = 0;
    for (enum stream i = 0; i < STREAM_COUNT; i++) {
        e->offsets[i] = size;
        size += (stream_bytes(m, i) + 15) & ~15ull;
    }
    for (uint32_t i = 0; i < (m->dynamic ? NG_GPU_FRAMES : 1); i++)
        NG_TRY(ng_gpu_buffer_create(s->gpu,
                                    &(struct ng_gpu_buffer_params){
                                        .name = "mesh",
                                        .size = size ? size : 1,
                                        .memory = m->dynamic ? NG_GPU_MEMORY_UPLOAD : NG_GPU_MEMORY_DEVICE},
                                    &e->buffers[i]));
    e->revision = m->revision;
    if (m->dynamic)
        return NG_OK; // written by write_frame
    for (enum stream i = 0; i < STREAM_COUNT; i++)
        if (stream_bytes(m, i))
            NG_TRY(ng_upload_buffer(e->buffers[0], e->offsets[i], stream_data(m, i), stream_bytes(m, i)));
    return NG_OK;
}

static ng_result update_mesh(struct ng_scene_gpu *s, uint32_t index)
{
    const struct ng_snapshot_mesh *m = &s->snapshot->meshes[index];
    uint32_t at = s->mesh_of.items[index];
    if (at >= s->meshes.count || s->meshes.items[at].key != m->key) {
        at = ng_index_map_get(&s->mesh_at, m->key);
        if (at == UINT32_MAX) {
            at = (uint32_t)s->meshes.count;
            if (!ng_array_push(&s->meshes, (struct mesh_entry){.key = m->key}) ||
                !ng_index_map_set(&s->mesh_at, m->key, at))
                return ng_out_of_memory("the scene on the GPU");
        }
        s->mesh_of.items[index] = at;
    }
    struct mesh_entry *e = &s->meshes.items[at];
    e->last_used = s->frame;
    if (e->buffers[0] && (m->dynamic || e->revision == m->revision))
        return NG_OK;
    finish_mesh(e);
    ng_result r = upload_mesh(s, e, m);
    if (m->dynamic)
        e->revision = ~m->revision; // not written yet
    if (r != NG_OK)
        finish_mesh(e);
    return r;
}

// ---- Textures --------------------------------------------------------------------------------------------

static ng_result upload_image(struct ng_scene_gpu *s, struct image_entry *e, const struct ng_image *image)
{
    static const VkFormat formats[] = {[NG_PIXEL_RGBA8] = VK_FORMAT_R8G8B8A8_UNORM,
                                       [NG_PIXEL_RGBA8_SRGB] = VK_FORMAT_R8G8B8A8_SRGB,
                                       [NG_PIXEL_RGBA32F] = VK_FORMAT_R32G32B32A32_SFLOAT};
    NG_TRY(ng_gpu_image_create(s->gpu,
                               &(struct ng_gpu_image_params){.name = "texture",
                                                             .width = image->width,
                                                             .height = image->height,
                                                             .mips = image->levels,
                                                             .format = formats[image->format]},
                               &e->image));
    NG_TRY(ng_upload_image(e->image,
                           &(struct ng_upload_image_params){.data = image->pixels, .size = image->size}));
    e->sampler = ng_gpu_sampler(
        s->gpu,
        &(struct ng_gpu_sampler_params){.filter = VK_FILTER_LINEAR,
                                        .mip_filter = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                        .address_u = image->repeat_u ? VK_SAMPLER_ADDRESS_MODE_REPEAT
                                                                     : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .address_v = image->repeat_v ? VK_SAMPLER_ADDRESS_MODE_REPEAT
                                                                     : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                        .anisotropy = 8});
    return e->sampler ? NG_OK : NG_ERROR_DEVICE;
}

static ng_result update_image(struct ng_scene_gpu *s, uint32_t index)
{
    const struct ng_snapshot_image *image = &s->snapshot->images[index];
    uint32_t at = s->image_of.items[index];
    if (at >= s->images.count || s->images.items[at].key != image->key) {
        at = ng_index_map_get(&s->image_at, image->key);
        if (at == UINT32_MAX) {
            at = (uint32_t)s->images.count;
            if (!ng_array_push(&s->images, (struct image_entry){.key = image->key}) ||
                !ng_index_map_set(&s->image_at, image->key, at))
                return ng_out_of_memory("the scene on the GPU");
        }
        s->image_of.items[index] = at;
    }
    struct image_entry *e = &s->images.items[at];
    e->last_used = s->frame;
    if (e->image)
        return NG_OK;
    ng_result r = upload_image(s, e, image->image);
    if (r != NG_OK)
        ng_gpu_image_destroy(&e->image);
    return r;
}

struct ng_gpu_binding ng_scene_gpu_image(const struct ng_scene_gpu *s, uint32_t image, uint32_t binding)
{
    const struct image_entry *e = image == NG_NONE ? NULL : &s->images.items[s->image_of.items[image]];
    return (struct ng_gpu_binding){.binding = binding,
                                   .view = e ? e->image->view : s->white->view,
                                   .sampler = e ? e->sampler
                                                : ng_gpu_sampler(s->gpu, &(struct ng_gpu_sampler_params){0})};
}

struct ng_gpu_binding ng_scene_gpu_black(const struct ng_scene_gpu *s, uint32_t binding)
{
    return (struct ng_gpu_binding){.binding = binding,
                                   .view = s->black->view,
                                   .sampler = ng_gpu_sampler(s->gpu, &(struct ng_gpu_sampler_params){0})};
}

static void material_images(const struct ng_snapshot_material *m, uint32_t out[TEXTURES])
{
    const uint32_t images[TEXTURES] = {m->base_color_image, m->metallic_roughness_image, m->normal_image,
                                       m->emissive_image};
    memcpy(out, images, sizeof images);
}

static bool is_textured(const struct ng_snapshot_material *m)
{
    uint32_t images[TEXTURES];
    material_images(m, images);
    for (int i = 0; i < TEXTURES; i++)
        if (images[i] != NG_NONE)
            return true;
    return m->alpha_mask;
}

static uint64_t group_key(const struct ng_scene_gpu *s, const struct ng_snapshot_material *m)
{
    uint32_t images[TEXTURES];
    uint64_t key = 1;
    material_images(m, images);
    for (int i = 0; i < TEXTURES; i++)
        key = ng_hash_combine(key, images[i] == NG_NONE ? 0 : s->snapshot->images[images[i]].key + 1);
    return key | 1; // never 0
}

// The bind group of a material's textures, made when a draw first needs it.
static ng_result group_of(struct ng_scene_gpu *s, const struct ng_snapshot_material *m,
                          const struct ng_gpu_pipeline *pipeline, const struct ng_gpu_bind_group **out)
{
    uint64_t key = group_key(s, m);
    uint32_t known = ng_index_map_get(&s->group_at, key);
    if (known != UINT32_MAX) {
        s->groups.items[known].last_used = s->frame;
        *out = s->groups.items[known].group;
        return NG_OK;
    }
    struct ng_gpu_binding bindings[TEXTURES];
    uint32_t images[TEXTURES];
    material_images(m, images);
    for (uint32_t i = 0; i < TEXTURES; i++)
        bindings[i] = ng_scene_gpu_image(s, images[i], i);
    if (!ng_array_reserve(&s->groups, s->groups.count + 1))
        return ng_out_of_memory("the scene on the GPU");
    struct group_entry e = {.key = key, .last_used = s->frame};
    NG_TRY(ng_gpu_bind_group_create(s->gpu, "material", pipeline, 1, bindings, TEXTURES, &e.group));
    if (!ng_index_map_set(&s->group_at, key, (uint32_t)s->groups.count)) {
        ng_gpu_bind_group_destroy(&e.group);
        return ng_out_of_memory("the scene on the GPU");
    }
    s->groups.items[s->groups.count++] = e;
    *out = e.group;
    return NG_OK;
}

// ---- A frame's data --------------------------------------------------------------------------------------

// Removing moves entries. The maps held as many, so setting does not fail.
static void index_entries(struct ng_scene_gpu *s)
{
    ng_index_map_clear(&s->mesh_at);
    ng_index_map_clear(&s->image_at);
    ng_index_map_clear(&s->group_at);
    for (uint32_t i = 0; i < s->meshes.count; i++)
        (void)ng_index_map_set(&s->mesh_at, s->meshes.items[i].key, i);
    for (uint32_t i = 0; i < s->images.count; i++)
        (void)ng_index_map_set(&s->image_at, s->images.items[i].key, i);
    for (uint32_t i = 0; i < s->groups.count; i++)
        (void)ng_index_map_set(&s->group_at, s->groups.items[i].key, i);
}

static void drop_unused(struct ng_scene_gpu *s)
{
    size_t before = s->groups.count + s->meshes.count + s->images.count;
    if (s->frame < UNUSED_FRAMES)
        return;
    uint64_t oldest = s->frame - UNUSED_FRAMES;
    for (size_t i = s->groups.count; i-- > 0;)
        if (s->groups.items[i].last_used < oldest) {
            ng_gpu_bind_group_destroy(&s->groups.items[i].group);
            ng_array_swap_remove(&s->groups, i);
        }
    for (size_t i = s->meshes.count; i-- > 0;)
        if (s->meshes.items[i].last_used < oldest) {
            finish_mesh(&s->meshes.items[i]);
            ng_array_swap_remove(&s->meshes, i);
        }
    // Groups hold views of images, so images wait as long again.
    for (size_t i = s->images.count; i-- > 0;)
        if (s->images.items[i].last_used + UNUSED_FRAMES < oldest) {
            ng_gpu_image_destroy(&s->images.items[i].image);
            ng_array_swap_remove(&s->images, i);
        }
    if (s->groups.count + s->meshes.count + s->images.count != before)
        index_entries(s);
}

enum kind { KIND_PLAIN, KIND_MOVING, KIND_TEXTURED };

static bool has_moved(const struct ng_snapshot_instance *i)
{
    for (int k = 0; k < 12; k++)
        if (!(i->matrix[k] >= i->previous_matrix[k] && i->matrix[k] <= i->previous_matrix[k]))
            return true;
    return false;
}

static enum kind kind_of(const struct ng_scene_gpu *s, const struct ng_snapshot_instance *i)
{
    if (is_textured(&s->snapshot->materials[i->material]))
        return KIND_TEXTURED;
    return s->snapshot->meshes[i->mesh].dynamic || has_moved(i) ? KIND_MOVING : KIND_PLAIN;
}

static struct draw_key draw_key(const struct ng_scene_gpu *s, uint32_t index)
{
    const struct ng_snapshot_instance *instance = &s->snapshot->instances[index];
    const struct ng_snapshot_material *m = &s->snapshot->materials[instance->material];
    enum kind kind = kind_of(s, instance);
    uint64_t textured = kind == KIND_TEXTURED, masked = m->alpha_mask;
    uint64_t facing = instance->flags & (NG_INSTANCE_DOUBLE_SIDED | NG_INSTANCE_MIRRORED);
    return (struct draw_key){.sort = textured << 62 | masked << 61 | facing << 32 | instance->mesh,
                             .group = kind == KIND_TEXTURED ? group_key(s, m) : 0,
                             .kind = kind,
                             .instance = index};
}

// Motion has no part in it: of surfaces in one place the first is seen, whether it has just come or not.
static bool draws_before(const struct draw_key *a, const struct draw_key *b)
{
    if (a->sort != b->sort)
        return a->sort < b->sort;
    return a->group != b->group ? a->group < b->group : a->instance < b->instance;
}

// Shell sort: in place, and quick on the nearly sorted order of the frame before. Knuth's gaps of 1, 4, 13
// and so on take count^1.5 steps at most; halves of the count would take count^2 where two meshes alternate.
static void sort_draws(struct draw_key *keys, size_t count)
{
    size_t gap = 1;
    while (gap < count / 3)
        gap = gap * 3 + 1;
    for (; gap; gap /= 3)
        for (size_t i = gap; i < count; i++) {
            struct draw_key k = keys[i];
            size_t at = i;
            for (; at >= gap && draws_before(&k, &keys[at - gap]); at -= gap)
                keys[at] = keys[at - gap];
            keys[at] = k;
        }
}

static void fill_view(struct ng_scene_gpu *s, uint32_t width, uint32_t height)
{
    const struct ng_snapshot_camera *c = &s->snapshot->camera;
    float aspect = (float)width / (float)height, tangent = tanf(c->fov_y * 0.5f);
    // Reverse-Z with an infinite far plane: depth = near / distance. Vulkan's clip space has y down.
    mat4 projection = {{1.0f / (tangent * aspect), 0, 0, 0},
                       {0, -1.0f / tangent, 0, 0},
                       {0, 0, 0, -1},
                       {0, 0, c->near_plane, 0}};
    mat4 view, m;
    memcpy(view, c->view, sizeof view);
    glm_mat4_mul(projection, view, m);
    memcpy(s->view.view_projection, m, sizeof m);
    memcpy(view, c->previous_view, sizeof view);
    glm_mat4_mul(projection, view, m);
    memcpy(s->view.previous_view_projection, m, sizeof m);
    for (int i = 0; i < 3; i++) {
        s->view.right[i] = c->view[i * 4] * tangent * aspect;
        s->view.down[i] = -c->view[i * 4 + 1] * tangent;
        s->view.forward[i] = -c->view[i * 4 + 2];
        s->view.position[i] = c->position[i];
    }
    s->view.exposure = c->exposure;
    s->view.near_plane = c->near_plane;
    s->view.size[0] = (float)width;
    s->view.size[1] = (float)height;
}

static struct ng_instance_data instance_data(const struct ng_snapshot_instance *i)
{
    struct ng_instance_data d = {
        .material = i->material, .entity = ng_entity_index(i->entity), .flags = i->flags};
    memcpy(d.matrix, i->matrix, sizeof d.matrix);
    memcpy(d.previous_matrix, i->previous_matrix, sizeof d.previous_matrix);
    return d;
}

static struct ng_material_data material_data(const struct ng_snapshot_material *m)
{
    struct ng_material_data d = {.metallic = m->metallic,
                                 .roughness = m->roughness,
                                 .normal_scale = m->normal_scale,
                                 .alpha = m->alpha,
                                 .alpha_cutoff = m->alpha_mask ? m->alpha_cutoff : 0,
                                 .flags = (m->double_sided ? NG_MATERIAL_DOUBLE_SIDED : 0u) |
                                          (m->normal_image != NG_NONE ? NG_MATERIAL_NORMAL_MAP : 0u)};
    memcpy(d.base_color, m->base_color, sizeof d.base_color);
    memcpy(d.emission, m->emission, sizeof d.emission);
    return d;
}

// Writes what the frame's draws read.
static ng_result write_frame(struct ng_scene_gpu *s)
{
    const struct ng_snapshot *n = s->snapshot;
    NG_TRY(ng_frame_put(s->gpu, &s->view, sizeof s->view, &s->view_range));

    size_t instances = s->order.count ? s->order.count : 1,
           materials = n->material_count ? n->material_count : 1;
    NG_TRY(ng_frame_alloc(s->gpu, instances * sizeof(struct ng_instance_data), &s->instance_range));
    struct ng_instance_data *instance = s->instance_range.mapped;
    for (size_t i = 0; i < s->order.count; i++)
        instance[i] = instance_data(&n->instances[s->order.items[i].instance]);

    NG_TRY(ng_frame_alloc(s->gpu, materials * sizeof(struct ng_material_data), &s->material_range));
    struct ng_material_data *material = s->material_range.mapped;
    for (uint32_t i = 0; i < n->material_count; i++)
        material[i] = material_data(&n->materials[i]);

    for (uint32_t i = 0; i < n->mesh_count; i++) {
        struct mesh_entry *e = &s->meshes.items[s->mesh_of.items[i]];
        if (!n->meshes[i].dynamic)
            continue;
        if (e->revision != n->meshes[i].revision)
            write_dynamic(e, &n->meshes[i]);
        else
            e->moved = false;
    }
    return NG_OK;
}

ng_result ng_scene_gpu_update(struct ng_scene_gpu *s, const struct ng_snapshot *snapshot, uint32_t width,
                              uint32_t height)
{
    s->snapshot = snapshot;
    s->frame++;
    drop_unused(s);
    if (!ng_array_resize(&s->mesh_of, snapshot->mesh_count) ||
        !ng_array_resize(&s->image_of, snapshot->image_count) ||
        !ng_array_resize(&s->order, snapshot->instance_count))
        return ng_out_of_memory("the scene on the GPU");
    for (uint32_t i = 0; i < snapshot->image_count; i++)
        NG_TRY(update_image(s, i));
    for (uint32_t i = 0; i < snapshot->mesh_count; i++)
        NG_TRY(update_mesh(s, i));
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        s->order.items[i] = draw_key(s, i);
    sort_draws(s->order.items, s->order.count);
    fill_view(s, width, height);
    return write_frame(s);
}

const float *ng_scene_gpu_camera(const struct ng_scene_gpu *s)
{
    return s->view.view_projection;
}

bool ng_scene_gpu_camera_mirrors(const struct ng_scene_gpu *s)
{
    mat4 view;
    memcpy(view, s->snapshot->camera.view, sizeof view);
    vec3 normal;
    glm_vec3_cross(view[0], view[1], normal);
    return glm_vec3_dot(normal, view[2]) < 0;
}

struct ng_gpu_binding ng_scene_gpu_view(const struct ng_scene_gpu *s, uint32_t binding)
{
    return ng_pass_range(&s->view_range, binding);
}

struct ng_gpu_binding ng_scene_gpu_instances(const struct ng_scene_gpu *s, uint32_t binding)
{
    return ng_pass_range(&s->instance_range, binding);
}

struct ng_gpu_binding ng_scene_gpu_materials(const struct ng_scene_gpu *s, uint32_t binding)
{
    return ng_pass_range(&s->material_range, binding);
}

// ---- Drawing ---------------------------------------------------------------------------------------------

// Planes of a clip volume, pointing inwards (Gribb and Hartmann 2001), for 0 <= z <= w.
static void frustum_planes(const float *m, float planes[6][4])
{
    for (int c = 0; c < 4; c++) {
        const float *col = m + c * 4;
        planes[0][c] = col[3] + col[0];
        planes[1][c] = col[3] - col[0];
        planes[2][c] = col[3] + col[1];
        planes[3][c] = col[3] - col[1];
        planes[4][c] = col[2];
        planes[5][c] = col[3] - col[2];
    }
}

static bool inside(float planes[6][4], const struct ng_snapshot_instance *i)
{
    for (int p = 0; p < 6; p++) {
        const float *n = planes[p];
        float far = n[3];
        for (int a = 0; a < 3; a++)
            far += n[a] * (n[a] > 0 ? i->bounds_max[a] : i->bounds_min[a]);
        if (far < 0)
            return false;
    }
    return true;
}

// A draw that grows while its neighbours can join it.
struct run {
    uint32_t first, count;
    const struct ng_snapshot_instance *instance;
    const struct draw_key *key;
};

static bool joins(const struct draw_key *a, const struct draw_key *b)
{
    return a->sort == b->sort && a->group == b->group && a->kind == b->kind;
}

struct draw_state {
    struct ng_scene_gpu *scene;
    struct ng_cmd *cmd;
    const struct ng_draw_params *params;
    const struct ng_gpu_pipeline *pipeline;
    const struct ng_gpu_bind_group *group;
    VkCullModeFlags cull;
};

static ng_result set_pipeline(struct draw_state *d, const struct ng_gpu_pipeline *pipeline)
{
    if (d->pipeline == pipeline)
        return NG_OK;
    NG_TRY(ng_cmd_bind(d->cmd, pipeline, d->params->bindings, d->params->binding_count));
    vkCmdSetFrontFace(d->cmd->handle,
                      d->params->mirrors ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
    if (d->params->push_size)
        ng_cmd_push(d->cmd, pipeline, d->params->push, d->params->push_size);
    d->pipeline = pipeline;
    d->group = NULL;
    d->cull = VK_CULL_MODE_FLAG_BITS_MAX_ENUM;
    return NG_OK;
}

static void set_streams(struct draw_state *d, const struct mesh_entry *e, enum ng_vertex_streams streams)
{
    const struct streams *wanted = &streams_of[streams];
    VkBuffer b = e->buffers[e->current]->handle, buffers[MAX_STREAMS];
    VkDeviceSize offsets[MAX_STREAMS];
    for (uint32_t i = 0; i < wanted->count; i++) {
        // Vertices that have not moved against their object are where they were.
        enum stream stream = wanted->streams[i];
        if (stream == STREAM_PREVIOUS && !e->moved)
            stream = STREAM_POSITION;
        buffers[i] = b;
        offsets[i] = e->offsets[stream];
    }
    vkCmdBindVertexBuffers(d->cmd->handle, 0, wanted->count, buffers, offsets);
    vkCmdBindIndexBuffer(d->cmd->handle, b, e->offsets[STREAM_INDEX], VK_INDEX_TYPE_UINT32);
}

static ng_result draw_run(struct draw_state *d, const struct run *r)
{
    if (!r->count)
        return NG_OK;
    struct ng_scene_gpu *s = d->scene;
    const struct ng_draw_params *p = d->params;
    const struct ng_snapshot_mesh *mesh = &s->snapshot->meshes[r->instance->mesh];
    const struct ng_snapshot_material *material = &s->snapshot->materials[r->instance->material];
    bool textured = p->depth_only ? material->alpha_mask : r->key->kind == KIND_TEXTURED;
    bool moving = r->key->kind == KIND_MOVING && p->moving.pipeline;
    const struct ng_draw_pipeline *use = textured ? &p->textured : moving ? &p->moving : &p->plain;
    NG_TRY(set_pipeline(d, use->pipeline));
    if (textured) {
        const struct ng_gpu_bind_group *group = NULL;
        NG_TRY(group_of(s, material, d->pipeline, &group));
        if (group != d->group)
            ng_cmd_bind_group(d->cmd, d->pipeline, group);
        d->group = group;
    }
    VkCullModeFlags cull = VK_CULL_MODE_NONE;
    if (p->cull_back && !(r->instance->flags & NG_INSTANCE_DOUBLE_SIDED))
        cull = r->instance->flags & NG_INSTANCE_MIRRORED ? VK_CULL_MODE_FRONT_BIT : VK_CULL_MODE_BACK_BIT;
    if (cull != d->cull)
        vkCmdSetCullMode(d->cmd->handle, cull);
    d->cull = cull;
    set_streams(d, &s->meshes.items[s->mesh_of.items[r->instance->mesh]], use->streams);
    vkCmdDrawIndexed(d->cmd->handle, mesh->index_count, r->count, 0, 0, r->first);
    return NG_OK;
}

static bool is_skipped(const struct ng_snapshot *s, const struct ng_snapshot_instance *i, uint32_t light)
{
    return light != NG_NONE && i->light != NG_NONE && s->lights[i->light].place == s->lights[light].place;
}

ng_result ng_scene_gpu_draw(struct ng_scene_gpu *s, struct ng_cmd *cmd, const struct ng_draw_params *params)
{
    struct draw_state d = {.scene = s, .cmd = cmd, .params = params};
    float planes[6][4];
    frustum_planes(params->view_projection, planes);
    struct run run = {0};
    for (uint32_t i = 0; i < s->order.count; i++) {
        const struct draw_key *key = &s->order.items[i];
        const struct ng_snapshot_instance *instance = &s->snapshot->instances[key->instance];
        if (is_skipped(s->snapshot, instance, params->skip_light) || !inside(planes, instance))
            continue;
        if (run.count && run.first + run.count == i && joins(run.key, key)) {
            run.count++;
            continue;
        }
        NG_TRY(draw_run(&d, &run));
        run = (struct run){i, 1, instance, key};
    }
    return draw_run(&d, &run);
}

uint64_t ng_scene_gpu_seen(const struct ng_scene_gpu *s, const float *view_projection, uint32_t skip_light)
{
    float planes[6][4];
    frustum_planes(view_projection, planes);
    uint64_t hash = 0;
    for (uint32_t i = 0; i < s->snapshot->instance_count; i++) {
        const struct ng_snapshot_instance *instance = &s->snapshot->instances[i];
        if (!is_skipped(s->snapshot, instance, skip_light) && inside(planes, instance))
            hash = ng_hash_combine(ng_hash_combine(hash, instance->entity.id), instance->version);
    }
    return hash;
}

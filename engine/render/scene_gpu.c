// Instances are written in the order in which they are best drawn (by pipeline, textures, facing, mesh, and
// copies of a mesh from front to back), so that neighbours that are visible merge into one draw.
#include "render/scene_gpu_internal.h"

#include "base/hash.h"
#include "base/log.h"
#include "graph/key.h"
#include "render/camera.h"
#include "render/copies.h"
#include "render/passes.h"
#include "render/subpixel.h"

#include <cglm/cglm.h>
#include <stdlib.h>
#include <string.h>

struct draw_key {
    uint64_t sort;     // textured or not, facing and mesh
    uint64_t group;    // textures
    uint32_t kind;     // enum kind
    uint32_t instance; // of the snapshot
    float ahead;       // of the camera, where the instance begins, metres
};

struct ng_scene_gpu {
    struct ng_gpu *gpu;
    uint64_t frame;
    const struct ng_snapshot *snapshot;
    struct ng_view_data view;
    struct ng_mesh_cache meshes;
    struct ng_texture_cache textures;
    NG_ARRAY(struct draw_key) order;
    struct ng_copies copies;
    struct ng_frame_range view_ranges[2], instance_range, material_range;
};

// ---- Life ------------------------------------------------------------------------------------------------

ng_result ng_scene_gpu_create(struct ng_gpu *gpu, struct ng_scene_gpu **out)
{
    struct ng_scene_gpu *s = calloc(1, sizeof *s);
    *out = s;
    if (!s)
        return ng_out_of_memory("the scene on the GPU");
    s->gpu = s->meshes.gpu = gpu;
    ng_result r = ng_texture_cache_init(&s->textures, gpu);
    if (r != NG_OK)
        ng_scene_gpu_destroy(out);
    return r;
}

void ng_scene_gpu_destroy(struct ng_scene_gpu **scene)
{
    struct ng_scene_gpu *s = *scene;
    if (!s)
        return;
    ng_mesh_cache_finish(&s->meshes);
    ng_texture_cache_finish(&s->textures);
    ng_array_finish(&s->order);
    ng_copies_finish(&s->copies);
    free(s);
    *scene = NULL;
}

struct ng_gpu_binding ng_scene_gpu_image(const struct ng_scene_gpu *s, uint32_t image, uint32_t binding)
{
    struct ng_gpu_binding b = ng_texture_cache_image(&s->textures, image, binding);
    if (image != NG_NONE)
        b.sampler = ng_texture_cache_sampler(s->gpu, s->snapshot->images[image].image, 0);
    return b;
}

struct ng_gpu_binding ng_scene_gpu_black(const struct ng_scene_gpu *s, uint32_t binding)
{
    return (struct ng_gpu_binding){.binding = binding,
                                   .view = s->textures.black->view,
                                   .sampler = ng_gpu_sampler(s->gpu, &(struct ng_gpu_sampler_params){0})};
}

// ---- A frame's data --------------------------------------------------------------------------------------

enum kind { KIND_PLAIN, KIND_MOVING, KIND_TEXTURED, KIND_FULL };

static bool has_moved(const struct ng_snapshot_instance *i)
{
    for (int k = 0; k < 12; k++)
        if (!(i->matrix[k] >= i->previous_matrix[k] && i->matrix[k] <= i->previous_matrix[k]))
            return true;
    return false;
}

static enum kind kind_of(const struct ng_scene_gpu *s, const struct ng_snapshot_instance *i)
{
    const struct ng_snapshot_mesh *mesh = &s->snapshot->meshes[i->mesh];
    const struct ng_snapshot_material *material = &s->snapshot->materials[i->material];
    if (mesh->colors || ng_material_chooses_uvs(material, mesh->uvs1))
        return KIND_FULL;
    if (ng_material_is_textured(material))
        return KIND_TEXTURED;
    return mesh->dynamic || has_moved(i) ? KIND_MOVING : KIND_PLAIN;
}

// How far ahead of the camera the nearest corner of the instance's box is.
static float ahead_of(const struct ng_snapshot_camera *c, const struct ng_snapshot_instance *i)
{
    float z = -c->view[14];
    for (int k = 0; k < 3; k++) {
        float axis = -c->view[k * 4 + 2];
        z += axis * (axis > 0 ? i->bounds_min[k] : i->bounds_max[k]);
    }
    return z > c->near_plane ? z : c->near_plane;
}

static struct draw_key draw_key(const struct ng_scene_gpu *s, uint32_t index)
{
    const struct ng_snapshot_instance *instance = &s->snapshot->instances[index];
    const struct ng_snapshot_material *m = &s->snapshot->materials[instance->material];
    enum kind kind = kind_of(s, instance);
    uint64_t full = kind == KIND_FULL, textured = full || kind == KIND_TEXTURED;
    uint64_t masked = m->alpha_mode != NG_ALPHA_OPAQUE;
    uint64_t facing = instance->flags & (NG_INSTANCE_DOUBLE_SIDED | NG_INSTANCE_MIRRORED);
    return (struct draw_key){.sort =
                                 full << 63 | textured << 62 | masked << 61 | facing << 32 | instance->mesh,
                             .group = textured ? ng_texture_cache_group_key(&s->textures, m) : 0,
                             .kind = kind,
                             .instance = index,
                             .ahead = ahead_of(&s->snapshot->camera, instance)};
}

// Of a mesh's copies the nearest comes first, so that what it hides is not shaded: crowds of them cover a
// pixel thousands of times. Motion has no part in it: of surfaces in one place the first is seen, whether it
// has just come or not.
static bool draws_before(const struct draw_key *a, const struct draw_key *b)
{
    if (a->sort != b->sort)
        return a->sort < b->sort;
    if (a->group != b->group)
        return a->group < b->group;
    return a->ahead < b->ahead || (a->ahead <= b->ahead && a->instance < b->instance);
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

// How far ahead of the camera anything is, at most, rounded so that it seldom changes.
static float depth_of_scene(const struct ng_snapshot *s)
{
    const struct ng_snapshot_camera *c = &s->camera;
    float far = c->near_plane;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        float z = -c->view[14];
        for (int k = 0; k < 3; k++) {
            float axis = -c->view[k * 4 + 2];
            z += axis * (axis > 0 ? s->instances[i].bounds_max[k] : s->instances[i].bounds_min[k]);
        }
        far = z > far ? z : far;
    }
    return exp2f(ceilf(log2f((far - c->near_plane) * 1.01f + 1e-3f)));
}

static void project(const struct ng_snapshot *s, float aspect, float range, mat4 out)
{
    const struct ng_snapshot_camera *c = &s->camera;
    if (c->orthographic) { // Reverse-Z: 1 at the near plane, 0 a range behind it.
        float half = 0.5f * c->height;
        mat4 parallel = {{1.0f / (half * aspect), 0, 0, 0},
                         {0, -1.0f / half, 0, 0},
                         {0, 0, 1.0f / range, 0},
                         {0, 0, 1.0f + c->near_plane / range, 1}};
        glm_mat4_copy(parallel, out);
        return;
    }
    float tangent = tanf(c->fov_y * 0.5f);
    // Reverse-Z with an infinite far plane: depth = near / distance. Vulkan's clip space has y down.
    mat4 projection = {{1.0f / (tangent * aspect), 0, 0, 0},
                       {0, -1.0f / tangent, 0, 0},
                       {0, 0, 0, -1},
                       {0, 0, c->near_plane, 0}};
    glm_mat4_copy(projection, out);
}

// So that a pixel's middle shows what is `shift` beside it, of halves of the picture.
static void move_picture(const float shift[2], mat4 projection)
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 2; row++)
            projection[column][row] -= shift[row] * projection[column][3];
}

static void fill_view(const struct ng_scene_gpu *s, uint32_t width, uint32_t height, struct ng_view_data *out)
{
    const struct ng_snapshot_camera *c = &s->snapshot->camera;
    float aspect = (float)width / (float)height;
    const struct ng_camera_rays rays = ng_camera_rays_of(c, aspect);
    mat4 projection, view, m;
    out->range = c->orthographic ? depth_of_scene(s->snapshot) : 0;
    float shift[2];
    ng_subpixel_shift(c->subpixel, shift);
    out->shift[0] = 2 * shift[0] / (float)width;
    out->shift[1] = 2 * shift[1] / (float)height;
    project(s->snapshot, aspect, out->range, projection);
    move_picture(out->shift, projection);
    memcpy(view, c->view, sizeof view);
    glm_mat4_mul(projection, view, m);
    memcpy(out->view_projection, m, sizeof m);
    memcpy(view, c->previous_view, sizeof view);
    glm_mat4_mul(projection, view, m);
    memcpy(out->previous_view_projection, m, sizeof m);
    memcpy(out->right, rays.right, sizeof rays.right);
    memcpy(out->down, rays.down, sizeof rays.down);
    memcpy(out->forward, rays.forward, sizeof rays.forward);
    memcpy(out->position, c->position, sizeof c->position);
    out->near_plane = c->near_plane;
    out->size[0] = (float)width;
    out->size[1] = (float)height;
}

static struct ng_instance_data instance_data(const struct ng_snapshot *s, uint32_t index)
{
    const struct ng_snapshot_instance *i = &s->instances[index];
    struct ng_instance_data d = {.material = i->material,
                                 .entity = ng_entity_index(i->entity),
                                 .flags = i->flags,
                                 .subpixel = s->camera.subpixel};
    memcpy(d.matrix, i->matrix, sizeof d.matrix);
    memcpy(d.previous_matrix, i->previous_matrix, sizeof d.previous_matrix);
    return d;
}

static struct ng_material_data material_data(const struct ng_snapshot_material *m)
{
    const struct ng_snapshot_texture *textures = m->textures;
    bool specular_maps = textures[NG_TEXTURE_SPECULAR].image != NG_NONE ||
                         textures[NG_TEXTURE_SPECULAR_COLOR].image != NG_NONE;
    struct ng_material_data d = {.metallic = m->metallic,
                                 .roughness = m->roughness,
                                 .normal_scale = m->normal_scale,
                                 .alpha = m->alpha,
                                 .alpha_cutoff = m->alpha_cutoff,
                                 .specular = m->specular};
    d.flags = (m->double_sided ? NG_MATERIAL_DOUBLE_SIDED : 0u) |
              (textures[NG_TEXTURE_NORMAL].image != NG_NONE ? NG_MATERIAL_NORMAL_MAP : 0u) |
              (specular_maps ? NG_MATERIAL_SPECULAR_MAPS : 0u) | (m->unlit ? NG_MATERIAL_UNLIT : 0u) |
              (m->alpha_mode == NG_ALPHA_MASK ? NG_MATERIAL_MASK : 0u) |
              (m->alpha_mode == NG_ALPHA_BLEND ? NG_MATERIAL_BLEND : 0u);
    for (int i = 0; i < NG_TEXTURE_COUNT; i++) {
        d.flags |= textures[i].transformed ? NG_MATERIAL_MOVES_UV : 0u;
        d.flags |= (textures[i].uv_set ? 1u : 0u) * NG_MATERIAL_SECOND_UVS << i;
        memcpy(d.uv_rows[2 * i], textures[i].coordinates, sizeof textures[i].coordinates);
    }
    memcpy(d.specular_color, m->specular_color, sizeof d.specular_color);
    memcpy(d.base_color, m->base_color, sizeof d.base_color);
    memcpy(d.emission, m->emission, sizeof d.emission);
    return d;
}

// Writes what the frame's draws read.
static ng_result write_frame(struct ng_scene_gpu *s)
{
    const struct ng_snapshot *n = s->snapshot;
    NG_TRY(ng_frame_put(s->gpu, &s->view, sizeof s->view, &s->view_ranges[0]));

    size_t instances = s->order.count ? s->order.count : 1,
           materials = n->material_count ? n->material_count : 1;
    NG_TRY(ng_frame_alloc(s->gpu, instances * sizeof(struct ng_instance_data), &s->instance_range));
    struct ng_instance_data *instance = s->instance_range.mapped;
    for (size_t i = 0; i < s->order.count; i++)
        instance[i] = instance_data(n, s->order.items[i].instance);

    NG_TRY(ng_frame_alloc(s->gpu, materials * sizeof(struct ng_material_data), &s->material_range));
    struct ng_material_data *material = s->material_range.mapped;
    for (uint32_t i = 0; i < n->material_count; i++)
        material[i] = material_data(&n->materials[i]);
    return NG_OK;
}

ng_result ng_scene_gpu_update(struct ng_scene_gpu *s, const struct ng_snapshot *snapshot, uint32_t width,
                              uint32_t height)
{
    s->snapshot = snapshot;
    s->frame++;
    uint64_t oldest = s->frame < NG_SCENE_UNUSED_FRAMES ? 0 : s->frame - NG_SCENE_UNUSED_FRAMES;
    ng_mesh_cache_drop(&s->meshes, oldest);
    ng_texture_cache_drop(&s->textures, oldest);
    if (!ng_array_resize(&s->order, snapshot->instance_count))
        return ng_out_of_memory("the scene on the GPU");
    NG_TRY(ng_texture_cache_update(&s->textures, snapshot, s->frame));
    NG_TRY(ng_mesh_cache_update(&s->meshes, snapshot, s->frame));
    for (uint32_t i = 0; i < snapshot->instance_count; i++)
        s->order.items[i] = draw_key(s, i);
    sort_draws(s->order.items, s->order.count);
    NG_TRY(ng_copies_find(&s->copies, snapshot));
    fill_view(s, width, height, &s->view);
    return write_frame(s);
}

ng_result ng_scene_gpu_add_picture(struct ng_scene_gpu *s, uint32_t width, uint32_t height)
{
    struct ng_view_data view = {.near_plane = 0};
    fill_view(s, width, height, &view);
    return ng_frame_put(s->gpu, &view, sizeof view, &s->view_ranges[1]);
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
    return ng_pass_range(&s->view_ranges[0], binding);
}

struct ng_gpu_binding ng_scene_gpu_picture_view(const struct ng_scene_gpu *s, uint32_t binding)
{
    return ng_pass_range(&s->view_ranges[1], binding);
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

static ng_result draw_run(struct draw_state *d, const struct run *r)
{
    if (!r->count)
        return NG_OK;
    struct ng_scene_gpu *s = d->scene;
    const struct ng_draw_params *p = d->params;
    const struct ng_snapshot_mesh *mesh = &s->snapshot->meshes[r->instance->mesh];
    const struct ng_snapshot_material *material = &s->snapshot->materials[r->instance->material];
    bool full = r->key->kind == KIND_FULL && p->full.pipeline;
    bool textured = p->depth_only ? material->alpha_mode != NG_ALPHA_OPAQUE : r->key->kind >= KIND_TEXTURED;
    bool moving = r->key->kind == KIND_MOVING && p->moving.pipeline;
    const struct ng_draw_pipeline *use = !textured ? (moving ? &p->moving : &p->plain)
                                         : full    ? &p->full
                                                   : &p->textured;
    NG_TRY(set_pipeline(d, use->pipeline));
    if (textured) {
        const struct ng_gpu_bind_group *group = NULL;
        NG_TRY(ng_texture_cache_group(&s->textures, material, d->pipeline, &group));
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
    ng_mesh_cache_bind(&s->meshes, d->cmd, r->instance->mesh, use->streams);
    vkCmdDrawIndexed(d->cmd->handle, mesh->index_count, r->count, 0, 0, r->first);
    return NG_OK;
}

static bool is_skipped(const struct ng_snapshot *s, const struct ng_snapshot_instance *i, uint32_t light)
{
    return light != NG_NONE && i->light != NG_NONE && s->lights[i->light].place == s->lights[light].place;
}

static bool is_drawn(const struct ng_scene_gpu *s, uint32_t instance, const struct ng_draw_params *p)
{
    const struct ng_snapshot_instance *i = &s->snapshot->instances[instance];
    bool lamp = i->flags & NG_INSTANCE_LAMP;
    return (lamp ? p->lamps != NG_LAMPS_NOT : p->lamps != NG_LAMPS_ONLY) &&
           !is_skipped(s->snapshot, i, p->skip_light) && !s->copies.hidden.items[instance];
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
        if (!is_drawn(s, key->instance, params) || !inside(planes, instance))
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

uint64_t ng_scene_gpu_seen(const struct ng_scene_gpu *s, const struct ng_seen_params *p)
{
    float planes[6][4];
    frustum_planes(p->view_projection, planes);
    uint64_t key = NG_KEY;
    for (uint32_t i = 0; i < s->snapshot->instance_count; i++) {
        const struct ng_snapshot_instance *instance = &s->snapshot->instances[i];
        if (!is_skipped(s->snapshot, instance, p->skip_light) && inside(planes, instance) &&
            !(p->not_beside && ng_lamp_is_beside(instance, &s->snapshot->lights[p->skip_light])))
            key = ng_key_add(ng_key_add(key, instance->entity.id), instance->version);
    }
    return key;
}

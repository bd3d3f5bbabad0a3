// What a file may leave out: the scene's bounding sphere and a camera. Both come from the boxes of the
// geometries in their rest pose.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/placement.h"
#include "components/scene_scale.h"
#include "components/transform.h"

#include <cglm/cglm.h>

#include <float.h>
#include <stdlib.h>
#include <string.h>

struct bounds {
    vec3 min, max;
    vec3 center; // of the second pass
    float radius_squared;
};

static void local_matrix(const struct ng_transform *t, mat4 out)
{
    mat4 rotation;
    versor q;
    memcpy(q, t->rotation, sizeof q);
    glm_quat_mat4(q, rotation);
    glm_translate_make(out, (float *)t->translation);
    glm_mat4_mul(out, rotation, out);
    glm_scale(out, (float *)t->scale);
}

// [node_count][16], world space; parents come first in the order.
static mat4 *world_matrices(const struct gltf_loader *l)
{
    mat4 *m = calloc((size_t)l->doc->node_count + 1, sizeof *m);
    for (uint32_t i = 0; m && i < l->order_count; i++) {
        uint32_t node = l->order[i], parent = l->parents[node];
        local_matrix(ng_world_get(l->world, l->nodes[node], NG_TRANSFORM), m[node]);
        if (parent != NG_GLTF_NO_NODE)
            glm_mat4_mul(m[parent], m[node], m[node]);
    }
    return m;
}

// Where a node stands and how it stretches, the placement system will keep within its limit.
static void warn_far(struct gltf_loader *l, mat4 *world)
{
    for (uint32_t i = 0; i < l->order_count; i++) {
        uint32_t node = l->order[i];
        bool near = true;
        for (int k = 0; k < 16; k++)
            near = near && fabsf(world[node][k / 4][k % 4]) <= NG_PLACEMENT_MAX;
        if (!near && !l->warned_range) // of the same
            ng_gltf_warn(
                l, &l->warned_far,
                "node %u: its place or its scale in the scene is beyond %g and is moved there, where "
                "it is not seen",
                node, (double)NG_PLACEMENT_MAX);
    }
}

// The corners of a geometry's box, as one matrix places them. What is out of sight does not count.
static void each_corner(const struct ng_geometry *g, mat4 matrix, struct bounds *b,
                        void (*grow)(struct bounds *, vec3))
{
    vec3 p[8];
    for (int corner = 0; corner < 8; corner++) {
        for (int k = 0; k < 3; k++)
            p[corner][k] = corner >> k & 1 ? g->bounds_max[k] : g->bounds_min[k];
        glm_mat4_mulv3(matrix, p[corner], 1, p[corner]);
        for (int k = 0; k < 3; k++)
            if (!(fabsf(p[corner][k]) <= NG_PLACEMENT_MAX))
                return;
    }
    for (int corner = 0; corner < 8; corner++)
        grow(b, p[corner]);
}

static void grow_box(struct bounds *b, vec3 p)
{
    glm_vec3_minv(b->min, p, b->min);
    glm_vec3_maxv(b->max, p, b->max);
}

static void grow_sphere(struct bounds *b, vec3 p)
{
    b->radius_squared = fmaxf(b->radius_squared, glm_vec3_distance2(b->center, p));
}

// The joints that move a geometry.
struct joints {
    bool seen[UINT16_MAX + 1];
    uint16_t list[UINT16_MAX + 1];
    uint32_t count;
};

static void find_joints(const struct ng_geometry *g, struct joints *j)
{
    memset(j, 0, sizeof *j);
    for (size_t i = 0; g->joints && i < (size_t)g->vertex_count * 4; i++)
        if (g->weights[i] > 0 && !j->seen[g->joints[i]]) {
            j->seen[g->joints[i]] = true;
            j->list[j->count++] = g->joints[i];
        }
}

// A skinned vertex lies between the places that its joints would give it.
static void each_joint(const struct gltf_loader *l, const struct gltf_instance *instance,
                       const struct ng_geometry *g, const struct joints *joints, mat4 *world,
                       struct bounds *b, void (*grow)(struct bounds *, vec3))
{
    const struct gltf_skin *skin = &l->doc->skins[instance->skin];
    const struct ng_skeleton *s = ng_assets_skeleton(l->assets, l->skins[instance->skin]);
    for (uint32_t i = 0; i < joints->count; i++) {
        mat4 place;
        memcpy(place, s->inverse_bind + joints->list[i] * (size_t)16, sizeof place);
        glm_mat4_mul(world[skin->joints[joints->list[i]]], place, place);
        each_corner(g, place, b, grow);
    }
}

static int compare_instances(const void *a, const void *b)
{
    const struct gltf_instance *x = a, *y = b;
    if (x->shape.geometry.id != y->shape.geometry.id)
        return x->shape.geometry.id < y->shape.geometry.id ? -1 : 1;
    return (x->skin > y->skin) - (x->skin < y->skin);
}

// The instances are sorted: of those with one geometry and skin, which stand in one place, the first counts.
static void each_box(const struct gltf_loader *l, mat4 *world, struct joints *joints, struct bounds *b,
                     void (*grow)(struct bounds *, vec3))
{
    for (size_t n = 0; n < l->instances.count; n++) {
        const struct gltf_instance *instance = &l->instances.items[n], *last = n ? instance - 1 : NULL;
        const struct ng_geometry *g = ng_assets_geometry(l->assets, instance->shape.geometry);
        if (instance->skin < 0) {
            mat4 place;
            local_matrix(&instance->place, place);
            glm_mat4_mul(world[instance->node], place, place);
            each_corner(g, place, b, grow);
            continue;
        }
        if (!last || last->shape.geometry.id != instance->shape.geometry.id || last->skin < 0)
            find_joints(g, joints);
        else if (last->skin == instance->skin)
            continue;
        each_joint(l, instance, g, joints, world, b, grow);
    }
}

// The sphere around the centre of the scene's box that holds the boxes of all instances.
static ng_result measure(struct gltf_loader *l, mat4 *world, struct ng_scene_scale *out)
{
    *out = (struct ng_scene_scale){.radius = 1};
    struct joints *joints = malloc(sizeof *joints);
    struct bounds b = {.min = {FLT_MAX, FLT_MAX, FLT_MAX}, .max = {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    if (!joints)
        return ng_out_of_memory(l->path);
    if (l->instances.count > 1)
        qsort(l->instances.items, l->instances.count, sizeof l->instances.items[0], compare_instances);
    each_box(l, world, joints, &b, grow_box);
    if (b.min[0] <= b.max[0]) { // something is there
        glm_vec3_center(b.min, b.max, b.center);
        each_box(l, world, joints, &b, grow_sphere);
        glm_vec3_copy(b.center, out->center);
        out->radius = fminf(fmaxf(sqrtf(b.radius_squared), 1e-6f), NG_PLACEMENT_MAX);
    }
    free(joints);
    return NG_OK;
}

// In front of the sphere and a little above it, far enough to see all of it.
static ng_result make_camera(struct gltf_loader *l, const struct ng_scene_scale *scale)
{
    const float pitch = 0.2f;
    struct ng_camera camera;
    memcpy(&camera, ng_camera_component.defaults, sizeof camera);
    float distance = 1.05f * scale->radius / sinf(camera.fov_y / 2);
    camera.near_plane = fminf(fmaxf(scale->radius * 0.01f, 1e-5f), 1e5f);
    struct ng_transform t = {.translation = {scale->center[0], scale->center[1] + distance * sinf(pitch),
                                             scale->center[2] + distance * cosf(pitch)},
                             .rotation = {sinf(-pitch / 2), 0, 0, cosf(pitch / 2)},
                             .scale = {1, 1, 1}};
    NG_TRY(ng_gltf_entity(l, l->out.root, "camera", "camera", 0, &l->out.camera));
    l->out.camera_made = true;
    NG_TRY(ng_gltf_add(l, l->out.camera, "default camera", NG_TRANSFORM, &t));
    return ng_gltf_add(l, l->out.camera, "default camera", NG_CAMERA, &camera);
}

static ng_result find_scale(struct gltf_loader *l, struct ng_scene_scale *out)
{
    const struct ng_scene_scale *given = ng_world_get(l->world, l->out.root, NG_SCENE_SCALE);
    mat4 *world = world_matrices(l);
    if (!world)
        return ng_out_of_memory(l->path);
    warn_far(l, world);
    ng_result r = NG_OK;
    if (given)
        *out = *given;
    else
        r = measure(l, world, out);
    free(world);
    return r == NG_OK && !given ? ng_gltf_add(l, l->out.root, "scene", NG_SCENE_SCALE, out) : r;
}

ng_result ng_gltf_scale_and_camera(struct gltf_loader *l)
{
    struct ng_scene_scale scale;
    NG_TRY(find_scale(l, &scale));
    return ng_entity_is_null(l->out.camera) ? make_camera(l, &scale) : NG_OK;
}

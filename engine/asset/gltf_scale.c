// What a file may leave out: the scene's bounding sphere and a camera. Both come from the boxes of the
// geometries in their rest pose.
#include "asset/gltf_loader_internal.h"
#include "base/log.h"
#include "components/camera.h"
#include "components/components.h"
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

// joint matrix * inverse bind matrix of each joint of a skin; null without memory.
static mat4 *skin_palette(const struct gltf_loader *l, int index, mat4 *world)
{
    const struct gltf_skin *skin = &l->doc->skins[index];
    const struct ng_skeleton *s = ng_assets_skeleton(l->assets, l->skins[index]);
    mat4 *palette = malloc(skin->joint_count * sizeof *palette);
    for (uint32_t i = 0; palette && i < skin->joint_count; i++) {
        mat4 bind;
        memcpy(bind, s->inverse_bind + i * (size_t)16, sizeof bind);
        glm_mat4_mul(world[skin->joints[i]], bind, palette[i]);
    }
    return palette;
}

// The corners of a geometry's box, as one matrix places them.
static void each_corner(const struct ng_geometry *g, mat4 matrix, struct bounds *b,
                        void (*grow)(struct bounds *, vec3))
{
    for (int corner = 0; corner < 8; corner++) {
        vec3 p;
        for (int k = 0; k < 3; k++)
            p[k] = corner >> k & 1 ? g->bounds_max[k] : g->bounds_min[k];
        glm_mat4_mulv3(matrix, p, 1, p);
        grow(b, p);
    }
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

// A skinned vertex lies between the places that its joints would give it.
static bool each_box(const struct gltf_loader *l, mat4 *world, struct bounds *b,
                     void (*grow)(struct bounds *, vec3))
{
    for (size_t n = 0; n < l->instances.count; n++) {
        const struct gltf_instance *instance = &l->instances.items[n];
        const struct ng_geometry *g = ng_assets_geometry(l->assets, instance->geometry);
        if (instance->skin < 0) {
            each_corner(g, world[instance->node], b, grow);
            continue;
        }
        mat4 *palette = skin_palette(l, instance->skin, world);
        if (!palette)
            return false;
        for (uint32_t i = 0; i < l->doc->skins[instance->skin].joint_count; i++)
            each_corner(g, palette[i], b, grow);
        free(palette);
    }
    return true;
}

// The sphere around the centre of the scene's box that holds the boxes of all instances.
static ng_result measure(struct gltf_loader *l, struct ng_scene_scale *out)
{
    *out = (struct ng_scene_scale){.radius = 1};
    if (l->instances.count == 0)
        return NG_OK;
    mat4 *world = world_matrices(l);
    struct bounds b = {.min = {FLT_MAX, FLT_MAX, FLT_MAX}, .max = {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    bool ok = world && each_box(l, world, &b, grow_box);
    glm_vec3_center(b.min, b.max, b.center);
    ok = ok && each_box(l, world, &b, grow_sphere);
    free(world);
    if (!ok)
        return ng_out_of_memory(l->path);
    glm_vec3_copy(b.center, out->center);
    out->radius = fmaxf(sqrtf(b.radius_squared), 1e-6f);
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

ng_result ng_gltf_scale_and_camera(struct gltf_loader *l)
{
    const struct ng_scene_scale *given = ng_world_get(l->world, l->out.root, NG_SCENE_SCALE);
    struct ng_scene_scale scale;
    if (given) {
        scale = *given;
    } else {
        NG_TRY(measure(l, &scale));
        NG_TRY(ng_gltf_add(l, l->out.root, "scene", NG_SCENE_SCALE, &scale));
    }
    return ng_entity_is_null(l->out.camera) ? make_camera(l, &scale) : NG_OK;
}

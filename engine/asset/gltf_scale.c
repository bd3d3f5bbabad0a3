// What a file may leave out: the scene's bounding sphere and a camera. Both come from what is seen when the
// scene begins: the boxes of geometries where their nodes are, and the vertices of skinned ones where joints
// move them.
#include "anim/skinning.h"
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

typedef float matrix[16];

// Where a node stands and how it stretches, the placement system will keep within its limit.
static void warn_far(struct gltf_loader *l, const matrix *world)
{
    for (uint32_t i = 0; i < l->order_count; i++) {
        uint32_t node = l->order[i];
        bool near = true;
        for (int k = 0; k < 16; k++)
            near = near && fabsf(world[node][k]) <= NG_PLACEMENT_MAX;
        if (!near && !l->warned_range) // of the same
            ng_gltf_warn(
                l, &l->warned_far,
                "node %u: its place or its scale in the scene is beyond %g and is moved there, where "
                "it is not seen",
                node, (double)NG_PLACEMENT_MAX);
    }
}

static void corner_of(const float low[3], const float high[3], int corner, float out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = corner >> k & 1 ? high[k] : low[k];
}

// The corners of a box, as one matrix places them. What is out of sight does not count.
static void each_corner(const float low[3], const float high[3], const matrix place, struct bounds *b,
                        void (*grow)(struct bounds *, vec3))
{
    vec3 p[8];
    mat4 m;
    memcpy(m, place, sizeof m);
    for (int corner = 0; corner < 8; corner++) {
        corner_of(low, high, corner, p[corner]);
        glm_mat4_mulv3(m, p[corner], 1, p[corner]);
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

// ---- skinned geometry ------------------------------------------------------------------------------------

// Joints that move a geometry, with their matrices; zeros for all others, which move nothing.
struct palette {
    bool seen[UINT16_MAX + 1];
    uint16_t list[UINT16_MAX + 1];
    uint32_t count;
    struct ng_joint_matrix matrices[UINT16_MAX + 1];
};

// A box of what an instance shows. In world space where joints move it, and then instances of one geometry
// and skin share it; else in object space.
struct box {
    bool known; // in world space
    float low[3], high[3];
};

static void see_joints(const uint16_t *joints, const float *weights, uint32_t vertex_count, struct palette *p)
{
    for (size_t i = 0; joints && i < (size_t)vertex_count * 4; i++)
        if (weights[i] > 0 && !p->seen[joints[i]]) {
            p->seen[joints[i]] = true;
            p->list[p->count++] = joints[i];
        }
}

static void find_joints(const struct ng_geometry *g, struct palette *p)
{
    for (uint32_t i = 0; i < p->count; i++) {
        p->seen[p->list[i]] = false;
        p->matrices[p->list[i]] = (struct ng_joint_matrix){0};
    }
    p->count = 0;
    see_joints(g->joints, g->weights, g->vertex_count, p);
    see_joints(g->joints1, g->weights1, g->vertex_count, p);
}

static void pose_joints(const struct gltf_loader *l, int index, const matrix *world, struct palette *p)
{
    const struct gltf_skin *skin = &l->doc->skins[index];
    const struct ng_skeleton *s = ng_assets_skeleton(l->assets, l->skins[index]);
    for (uint32_t i = 0; i < p->count; i++) {
        uint16_t joint = p->list[i];
        ng_skin_palette(1, world[skin->joints[joint]], s->inverse_bind + joint * (size_t)16,
                        &p->matrices[joint]);
    }
}

// Where the vertices are once the joints have moved them. Those out of sight do not count.
static ng_result box_skinned(const struct gltf_loader *l, const struct ng_geometry *g,
                             const struct palette *palette, struct box *out)
{
    float *points = malloc(((size_t)g->vertex_count * 3 + 1) * sizeof *points);
    if (!points)
        return ng_out_of_memory(l->path);
    ng_skin_vertices(NULL, &(struct ng_skin_params){.vertex_count = g->vertex_count,
                                                    .joint_count = UINT16_MAX + 1,
                                                    .palette = palette->matrices,
                                                    .joints = g->joints,
                                                    .weights = g->weights,
                                                    .joints1 = g->joints1,
                                                    .weights1 = g->weights1,
                                                    .positions = g->positions,
                                                    .out_positions = points});
    for (size_t v = 0; v < g->vertex_count; v++) {
        const float *p = points + v * 3;
        bool near = true;
        for (int k = 0; k < 3; k++)
            near = near && fabsf(p[k]) <= NG_PLACEMENT_MAX;
        for (int k = 0; near && k < 3; k++) {
            out->low[k] = out->known ? fminf(out->low[k], p[k]) : p[k];
            out->high[k] = out->known ? fmaxf(out->high[k], p[k]) : p[k];
        }
        out->known |= near;
    }
    free(points);
    return NG_OK;
}

static int compare_instances(const void *a, const void *b)
{
    const struct gltf_instance *x = a, *y = b;
    if (x->shape.geometry.id != y->shape.geometry.id)
        return x->shape.geometry.id < y->shape.geometry.id ? -1 : 1;
    return (x->skin > y->skin) - (x->skin < y->skin);
}

// The instances are sorted: of those with one geometry and skin, which stand in one place, the first has the
// box.
static ng_result box_all(struct gltf_loader *l, const matrix *world, struct palette *palette,
                         struct box *boxes)
{
    for (size_t n = 0; n < l->instances.count; n++) {
        const struct gltf_instance *instance = &l->instances.items[n], *last = n ? instance - 1 : NULL;
        const struct ng_geometry *g = ng_assets_geometry(l->assets, instance->shape.geometry);
        if (instance->skin < 0 || !g->joints)
            NG_TRY(ng_gltf_shape_bounds(l, instance, boxes[n].low, boxes[n].high));
        bool same_geometry = last && last->shape.geometry.id == instance->shape.geometry.id;
        if (instance->skin < 0 || !g->joints || (same_geometry && last->skin == instance->skin))
            continue;
        if (!same_geometry || last->skin < 0)
            find_joints(g, palette);
        pose_joints(l, instance->skin, world, palette);
        NG_TRY(box_skinned(l, g, palette, &boxes[n]));
    }
    return NG_OK;
}

// ---- the scene -------------------------------------------------------------------------------------------

static void each_corner_of_copy(const struct gltf_instance *instance, const struct box *box,
                                const matrix node, struct bounds *b, void (*grow)(struct bounds *, vec3))
{
    mat4 place, above;
    ng_gltf_local_matrix(&instance->place, (float *)place);
    memcpy(above, node, sizeof above);
    glm_mat4_mul(above, place, place);
    each_corner(box->low, box->high, (const float *)place, b, grow);
}

static void each_box(const struct gltf_loader *l, const matrix *world, const struct box *boxes,
                     struct bounds *b, void (*grow)(struct bounds *, vec3))
{
    static const matrix here = {[0] = 1, [5] = 1, [10] = 1, [15] = 1};
    for (size_t n = 0; n < l->instances.count; n++) {
        const struct gltf_instance *instance = &l->instances.items[n];
        const struct ng_geometry *g = ng_assets_geometry(l->assets, instance->shape.geometry);
        if (boxes[n].known)
            each_corner(boxes[n].low, boxes[n].high, here, b, grow);
        else if (instance->skin < 0 || !g->joints)
            each_corner_of_copy(instance, &boxes[n], world[instance->node], b, grow);
    }
}

static void measure_boxes(const struct gltf_loader *l, const matrix *world, const struct box *boxes,
                          struct bounds *b)
{
    each_box(l, world, boxes, b, grow_box);
    if (b->min[0] > b->max[0]) // nothing is there
        return;
    glm_vec3_center(b->min, b->max, b->center);
    each_box(l, world, boxes, b, grow_sphere);
}

// The box of all that is seen, and the sphere around its centre that holds it.
static ng_result measure(struct gltf_loader *l, const matrix *world, struct bounds *out)
{
    struct palette *palette = calloc(1, sizeof *palette);
    struct box *boxes = calloc(l->instances.count + 1, sizeof *boxes);
    ng_result r = NG_OK;
    *out = (struct bounds){.min = {FLT_MAX, FLT_MAX, FLT_MAX}, .max = {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
    if (!palette || !boxes)
        r = ng_out_of_memory(l->path);
    if (r == NG_OK && l->instances.count > 1)
        qsort(l->instances.items, l->instances.count, sizeof l->instances.items[0], compare_instances);
    if (r == NG_OK)
        r = box_all(l, world, palette, boxes);
    if (r == NG_OK)
        measure_boxes(l, world, boxes, out);
    free(palette);
    free(boxes);
    return r;
}

static void scale_of(const struct bounds *b, struct ng_scene_scale *out)
{
    *out = (struct ng_scene_scale){.radius = 1};
    if (b->min[0] > b->max[0])
        return;
    glm_vec3_copy((float *)b->center, out->center);
    out->radius = fminf(fmaxf(sqrtf(b->radius_squared), 1e-6f), NG_PLACEMENT_MAX);
}

// Far enough along `axes[2]` from the centre that all corners of the box are within the opening angle,
// upright and across, with some room around them.
static float fit(const struct bounds *b, const float axes[3][3], float fov_y)
{
    const float slope = tanf(fov_y / 2) / 1.1f;
    float distance = 0;
    for (int corner = 0; corner < 8; corner++) {
        vec3 p;
        corner_of(b->min, b->max, corner, p);
        glm_vec3_sub(p, (float *)b->center, p);
        float across =
            fmaxf(fabsf(glm_vec3_dot((float *)axes[0], p)), fabsf(glm_vec3_dot((float *)axes[1], p)));
        distance = fmaxf(distance, across / slope + glm_vec3_dot((float *)axes[2], p));
    }
    return distance;
}

// Three quarters from the front, which is +Z, and a little from above.
static ng_result make_camera(struct gltf_loader *l, const struct ng_scene_scale *scale, struct bounds *b)
{
    const float yaw = 0.6f, pitch = 0.3f;
    struct ng_camera camera;
    struct ng_transform t = {.scale = {1, 1, 1}};
    memcpy(&camera, ng_camera_component.defaults, sizeof camera);
    camera.near_plane = fminf(fmaxf(scale->radius * 0.01f, 1e-5f), 1e5f);
    ng_gltf_expose(l, &camera);
    if (b->min[0] > b->max[0]) // nothing is seen: look at where it would be
        for (int k = 0; k < 3; k++) {
            b->center[k] = scale->center[k];
            b->min[k] = scale->center[k] - scale->radius;
            b->max[k] = scale->center[k] + scale->radius;
        }
    const float axes[3][3] = {{cosf(yaw), 0, -sinf(yaw)},
                              {-sinf(yaw) * sinf(pitch), cosf(pitch), -cosf(yaw) * sinf(pitch)},
                              {sinf(yaw) * cosf(pitch), sinf(pitch), cosf(yaw) * cosf(pitch)}};
    float distance = fmaxf(fit(b, axes, camera.fov_y), 2 * camera.near_plane);
    for (int k = 0; k < 3; k++)
        t.translation[k] = b->center[k] + axes[2][k] * distance;
    versor turn, tilt;
    glm_quatv(turn, yaw, (vec3){0, 1, 0});
    glm_quatv(tilt, -pitch, (vec3){1, 0, 0});
    glm_quat_mul(turn, tilt, t.rotation);
    NG_TRY(ng_gltf_entity(l, l->out.root, "camera", "camera", 0, &l->out.camera));
    l->out.camera_made = true;
    NG_TRY(ng_gltf_add(l, l->out.camera, "default camera", NG_TRANSFORM, &t));
    return ng_gltf_add(l, l->out.camera, "default camera", NG_CAMERA, &camera);
}

static ng_result complete(struct gltf_loader *l, const matrix *world)
{
    const struct ng_scene_scale *given = ng_world_get(l->world, l->out.root, NG_SCENE_SCALE);
    bool camera = ng_entity_is_null(l->out.camera);
    struct ng_scene_scale scale = given ? *given : (struct ng_scene_scale){.radius = 1};
    struct bounds bounds;
    warn_far(l, world);
    NG_TRY(measure(l, world, &bounds));
    if (bounds.min[0] <= bounds.max[0]) {
        glm_vec3_copy(bounds.min, l->out.bounds_min);
        glm_vec3_copy(bounds.max, l->out.bounds_max);
    }
    if (!given) {
        scale_of(&bounds, &scale);
        NG_TRY(ng_gltf_add(l, l->out.root, "scene", NG_SCENE_SCALE, &scale));
    }
    return camera ? make_camera(l, &scale, &bounds) : NG_OK;
}

ng_result ng_gltf_scale_and_camera(struct gltf_loader *l)
{
    matrix *world = ng_gltf_pose(l);
    if (!world)
        return ng_out_of_memory(l->path);
    ng_result r = complete(l, (const matrix *)world);
    free(world);
    return r;
}

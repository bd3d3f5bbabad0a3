// The node hierarchy, and what hangs on nodes.
//
// The hierarchy is walked breadth first without recursion: a node that is not reached from any root is on a
// cycle, or below one. Entities get their parents from the leaves up, so that the world's own check for
// cycles has one step to walk, however deep the file is.
#include "asset/gltf_loader_internal.h"
#include "asset/gltf_unit.h"
#include "base/log.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_directional.h"
#include "components/light_point.h"
#include "components/light_spot.h"
#include "components/mesh.h"
#include "components/skin.h"
#include "components/subdivision.h"
#include "components/transform.h"

#include <cglm/cglm.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- the hierarchy ---------------------------------------------------------------------------------------
// Each node keeps the first parent that names it.
static ng_result find_parents(struct gltf_loader *l)
{
    const struct gltf_document *d = l->doc;
    for (uint32_t i = 0; i < d->node_count; i++)
        l->parents[i] = NG_GLTF_NO_NODE;
    for (uint32_t i = 0; i < d->node_count; i++)
        for (uint32_t k = 0; k < d->nodes[i].child_count; k++) {
            int child = d->nodes[i].children[k];
            if (child < 0 || (uint32_t)child >= d->node_count)
                NG_TRY(ng_gltf_fault(&l->faults, "the child is left out",
                                     "node %u: child %d is not one of %u", i, child, d->node_count));
            else if (l->parents[child] != NG_GLTF_NO_NODE)
                NG_TRY(ng_gltf_fault(&l->faults, "the first keeps it",
                                     "node %d: is a child of node %u and of node %u", child,
                                     l->parents[child], i));
            else
                l->parents[child] = i;
        }
    return NG_OK;
}

static bool is_child(const struct gltf_loader *l, int child, uint32_t node)
{
    return child >= 0 && (uint32_t)child < l->doc->node_count && l->parents[child] == node;
}

// Appends a node to the order, once.
static void append(struct gltf_loader *l, uint32_t node)
{
    if (!l->ordered[node])
        l->order[l->order_count++] = node;
    l->ordered[node] = true;
}

// Appends everything below the nodes of the order from `begin` on, as far as it is in the scene. Depths are
// counted by levels of the walk.
static ng_result walk_down(struct gltf_loader *l, uint32_t begin)
{
    for (uint32_t depth = 0; begin < l->order_count; depth++) {
        if (depth >= NG_GLTF_MAX_DEPTH)
            return ng_gltf_unsupported(l, "node %u: is nested deeper than %d levels", l->order[begin],
                                       NG_GLTF_MAX_DEPTH);
        uint32_t end = l->order_count;
        for (; begin < end; begin++) {
            const struct gltf_node *n = &l->doc->nodes[l->order[begin]];
            for (uint32_t k = 0; k < n->child_count; k++)
                if (is_child(l, n->children[k], l->order[begin]) && l->placed[n->children[k]] != GLTF_OUT)
                    append(l, (uint32_t)n->children[k]);
        }
    }
    return NG_OK;
}

// A node of the cycle that is above a node to which no root leads.
static uint32_t find_cycle(struct gltf_loader *l, uint32_t node)
{
    for (; l->placed[node] != GLTF_SEEN; node = l->parents[node])
        l->placed[node] = GLTF_SEEN;
    return node;
}

// The order of the whole file. A node to which no root leads is on a cycle, or below one: of each cycle one
// loses its parent.
static ng_result order_all(struct gltf_loader *l)
{
    memset(l->placed, GLTF_IN, l->doc->node_count);
    for (uint32_t i = 0; i < l->doc->node_count; i++)
        if (l->parents[i] == NG_GLTF_NO_NODE)
            append(l, i);
    NG_TRY(walk_down(l, 0));
    for (uint32_t i = 0; i < l->doc->node_count; i++) {
        if (l->ordered[i])
            continue;
        uint32_t node = find_cycle(l, i);
        NG_TRY(ng_gltf_fault(&l->faults, "it is put at the top",
                             "node %u: is its own ancestor (the hierarchy has a cycle)", node));
        l->parents[node] = NG_GLTF_NO_NODE;
        append(l, node);
        NG_TRY(walk_down(l, l->order_count - 1));
    }
    memset(l->placed, GLTF_IN, l->doc->node_count);
    return NG_OK;
}

static ng_result place_listed(struct gltf_loader *l, const struct gltf_scene *scene)
{
    for (uint32_t i = 0; i < scene->node_count; i++) {
        int node = scene->nodes[i];
        if (node < 0 || (uint32_t)node >= l->doc->node_count) {
            NG_TRY(ng_gltf_fault(&l->faults, "it is left out", "scene: node %d is not one of %u", node,
                                 l->doc->node_count));
            continue;
        }
        if (l->placed[node] != GLTF_OUT)
            NG_TRY(ng_gltf_fault(&l->faults, "it is taken once", "scene: node %d is listed twice", node));
        else if (l->parents[node] != NG_GLTF_NO_NODE)
            NG_TRY(ng_gltf_fault(&l->faults, "it is taken once, where its parents put it",
                                 "scene: node %d is not a root, it is a child of node %u", node,
                                 l->parents[node]));
        l->placed[node] = GLTF_IN;
    }
    return NG_OK;
}

// In the scene is also what is below what it lists; what is above that is needed for its transforms.
static void place_around(struct gltf_loader *l)
{
    for (uint32_t i = 0; i < l->order_count; i++) { // of the whole file: parents come first
        uint32_t parent = l->parents[l->order[i]];
        if (parent != NG_GLTF_NO_NODE && l->placed[parent] == GLTF_IN)
            l->placed[l->order[i]] = GLTF_IN;
    }
    for (uint32_t i = l->order_count; i-- > 0;) {
        uint32_t parent = l->parents[l->order[i]];
        if (l->placed[l->order[i]] != GLTF_OUT && parent != NG_GLTF_NO_NODE && l->placed[parent] == GLTF_OUT)
            l->placed[parent] = GLTF_ABOVE;
    }
}

static ng_result place_joints_of(struct gltf_loader *l, uint32_t index)
{
    const struct gltf_skin *skin = &l->doc->skins[index];
    l->skin_placed[index] = true;
    for (uint32_t k = 0; k < skin->joint_count; k++) {
        int node = skin->joints[k];
        if (node < 0 || (uint32_t)node >= l->doc->node_count || l->placed[node] != GLTF_OUT)
            continue;
        NG_TRY(ng_gltf_fault(&l->faults, "it moves the skin all the same",
                             "skin %u: joint %u: node %d is not in the scene", index, k, node));
        l->placed[node] = GLTF_ABOVE;
    }
    return NG_OK;
}

// Joints of skins that are used move what is seen, whether or not the scene has them.
static ng_result place_joints(struct gltf_loader *l)
{
    const struct gltf_document *d = l->doc;
    for (uint32_t i = 0; i < d->node_count; i++) {
        int skin = d->nodes[i].skin;
        if (l->placed[i] == GLTF_IN && skin >= 0 && (uint32_t)skin < d->skin_count && !l->skin_placed[skin])
            NG_TRY(place_joints_of(l, (uint32_t)skin));
    }
    return NG_OK;
}

// Roots in the order in which the scene lists them, then those that it does not, then all that is below.
static ng_result order_scene(struct gltf_loader *l, const struct gltf_scene *scene)
{
    NG_TRY(place_listed(l, scene));
    place_around(l);
    NG_TRY(place_joints(l));
    place_around(l);
    memset(l->ordered, 0, l->doc->node_count * sizeof *l->ordered);
    l->order_count = 0;
    for (uint32_t i = 0; i < scene->node_count; i++) {
        int node = scene->nodes[i];
        if (node >= 0 && (uint32_t)node < l->doc->node_count && l->parents[node] == NG_GLTF_NO_NODE)
            append(l, (uint32_t)node);
    }
    for (uint32_t i = 0; i < l->doc->node_count; i++)
        if (l->parents[i] == NG_GLTF_NO_NODE && l->placed[i] != GLTF_OUT)
            append(l, i);
    return walk_down(l, 0);
}

static ng_result find_order(struct gltf_loader *l, const struct gltf_scene *scene)
{
    NG_TRY(find_parents(l));
    NG_TRY(order_all(l));
    if (!scene)
        return NG_OK;
    memset(l->placed, GLTF_OUT, l->doc->node_count);
    return order_scene(l, scene);
}

// ---- transforms ------------------------------------------------------------------------------------------
static ng_result copy_numbers(struct gltf_loader *l, const char *where, const char *what,
                              const struct gltf_numbers *in, uint32_t count, float *out)
{
    if (in->count == 0)
        return NG_OK;
    if (in->count != count)
        return ng_gltf_fault(&l->faults, "it is ignored", "%s: %s has %u numbers, not %u", where, what,
                             in->count, count);
    for (uint32_t i = 0; i < count; i++)
        out[i] = (float)in->items[i];
    ng_gltf_keep_within(l, where, what, out, count);
    return NG_OK;
}

// Translation, rotation and scale of a matrix; a mirroring becomes a negative scale, shear is lost.
static void decompose(float m[16], struct ng_transform *out)
{
    mat3 rotation = GLM_MAT3_IDENTITY_INIT;
    glm_vec3_copy(m + 12, out->translation);
    for (int i = 0; i < 3; i++)
        out->scale[i] = glm_vec3_norm(m + i * 4);
    vec3 cross;
    glm_vec3_cross(m, m + 4, cross);
    if (glm_vec3_dot(cross, m + 8) < 0)
        out->scale[0] = -out->scale[0];
    bool flat = false;
    for (int i = 0; i < 3; i++) {
        flat = flat || fabsf(out->scale[i]) < 1e-12f;
        if (!flat)
            glm_vec3_scale(m + i * 4, 1 / out->scale[i], rotation[i]);
    }
    if (flat) // no rotation can be told from a matrix that flattens
        glm_mat3_identity(rotation);
    glm_mat3_quat(rotation, out->rotation);
}

static ng_result read_transform(struct gltf_loader *l, const char *where, uint32_t index,
                                struct ng_transform *out)
{
    const struct gltf_node *n = &l->doc->nodes[index];
    memcpy(out, ng_transform_component.defaults, sizeof *out);
    if (n->matrix.count) {
        float m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        NG_TRY(copy_numbers(l, where, "matrix", &n->matrix, 16, m));
        decompose(m, out);
    } else {
        NG_TRY(copy_numbers(l, where, "translation", &n->translation, 3, out->translation));
        NG_TRY(copy_numbers(l, where, "rotation", &n->rotation, 4, out->rotation));
        NG_TRY(copy_numbers(l, where, "scale", &n->scale, 3, out->scale));
    }
    if (ng_gltf_normalize_rotation(out->rotation))
        return NG_OK;
    glm_vec4_copy((vec4){0, 0, 0, 1}, out->rotation);
    return ng_gltf_fault(&l->faults, "the node is not turned", "%s: rotation is zero or too large", where);
}

static ng_result make_entity(struct gltf_loader *l, uint32_t index)
{
    char where[32];
    snprintf(where, sizeof where, "node %u", index);
    struct ng_transform transform;
    NG_TRY(read_transform(l, where, index, &transform));
    // The root stands in as parent, so that a failure finds every entity below it.
    NG_TRY(ng_gltf_entity(l, l->out.root, l->doc->nodes[index].name, "node", index, &l->nodes[index]));
    return ng_gltf_add(l, l->nodes[index], where, NG_TRANSFORM, &transform);
}

ng_result ng_gltf_nodes(struct gltf_loader *l, const struct gltf_scene *scene)
{
    NG_TRY(find_order(l, scene));
    for (uint32_t i = 0; i < l->order_count; i++)
        NG_TRY(make_entity(l, l->order[i]));
    for (uint32_t i = l->order_count; i-- > 0;) {
        const struct gltf_node *n = &l->doc->nodes[l->order[i]];
        for (uint32_t k = 0; k < n->child_count; k++)
            if (is_child(l, n->children[k], l->order[i]) && !ng_entity_is_null(l->nodes[n->children[k]]))
                NG_TRY(ng_world_set_parent(l->world, l->nodes[n->children[k]], l->nodes[l->order[i]],
                                           (ng_entity){0}));
    }
    return NG_OK;
}

// ---- attachments -----------------------------------------------------------------------------------------

static ng_result attach_skin(struct gltf_loader *l, const char *where, const struct gltf_node *n,
                             const struct gltf_shape *shape, ng_entity e)
{
    struct ng_skin skin;
    NG_TRY(ng_gltf_skin(l, n->skin, &skin.skin));
    if (shape->joint_limit == NG_GLTF_JOINTS_LOST)
        return ng_gltf_follows(&l->faults);
    if (shape->joint_limit == 0)
        return ng_gltf_error(l, "%s: has skin %d, but its mesh has no JOINTS_0", where, n->skin);
    uint32_t joints = l->doc->skins[n->skin].joint_count;
    if (shape->joint_limit > joints)
        return ng_gltf_error(l, "%s: JOINTS_0 refers to joint %u of skin %d, which has %u", where,
                             shape->joint_limit - 1, n->skin, joints);
    return ng_gltf_add(l, e, where, NG_SKIN, &skin);
}

// Gives the number of a skin that moves the shape, or -1.
static ng_result try_skin(struct gltf_loader *l, const char *where, const struct gltf_node *n,
                          const struct gltf_shape *shape, ng_entity e, int *skin)
{
    struct gltf_part part;
    *skin = -1;
    if (n->skin == -1)
        return NG_OK;
    ng_gltf_part_begin(&part, "it stands where its node is");
    part.where = where;
    NG_TRY(ng_gltf_part_end(&l->faults, &part, attach_skin(l, where, n, shape, e)));
    *skin = part.lost ? -1 : n->skin;
    return NG_OK;
}

static ng_result find_material(struct gltf_loader *l, int mesh, uint32_t primitive, ng_entity *out)
{
    int index = l->doc->meshes[mesh].primitives[primitive].material;
    *out = (ng_entity){0};
    if (index >= 0 && (uint32_t)index < l->doc->material_count)
        *out = l->materials[index];
    else if (index != -1)
        return ng_gltf_fault(&l->faults, "the default is used",
                             "mesh %d, primitive %u: material %d is not one of %u", mesh, primitive, index,
                             l->doc->material_count);
    return NG_OK;
}

static ng_result attach_primitive(struct gltf_loader *l, const char *where, uint32_t node, uint32_t index,
                                  const struct ng_transform *place, ng_entity e)
{
    const struct gltf_node *n = &l->doc->nodes[node];
    const struct gltf_primitive *p = &l->doc->meshes[n->mesh].primitives[index];
    struct gltf_instance instance = {.node = node, .primitive = index, .place = *place, .entity = e};
    NG_TRY(ng_gltf_shape(l, (uint32_t)n->mesh, index, &instance.shape));
    if (!instance.shape.geometry.id) // points or lines, or it was lost
        return NG_OK;
    struct ng_mesh mesh = {.geometry = instance.shape.geometry, .visible = true};
    NG_TRY(find_material(l, n->mesh, index, &mesh.material));
    NG_TRY(ng_gltf_add(l, e, where, NG_MESH, &mesh));
    NG_TRY(ng_gltf_add_morph(l, where, node, instance.shape.geometry, e));
    NG_TRY(try_skin(l, where, n, &instance.shape, e, &instance.skin));
    if (!ng_array_push(&l->instances, instance))
        return ng_out_of_memory(l->path);
    l->out.primitive_count++;
    l->out.triangle_count += ng_assets_geometry(l->assets, instance.shape.geometry)->index_count / 3;
    return ng_gltf_components(l, e, where, p->extension, "cage");
}

// The primitives of a node's mesh, on an entity that stands at a place below the node.
static ng_result attach_primitives(struct gltf_loader *l, const char *where, uint32_t node,
                                   const struct ng_transform *place, ng_entity e)
{
    const struct gltf_mesh *m = &l->doc->meshes[l->doc->nodes[node].mesh];
    if (m->primitive_count == 1)
        return attach_primitive(l, where, node, 0, place, e);
    for (uint32_t i = 0; i < m->primitive_count; i++) {
        ng_entity child;
        NG_TRY(ng_gltf_entity(l, e, "", "primitive", i, &child));
        NG_TRY(ng_gltf_add(l, child, where, NG_TRANSFORM, ng_transform_component.defaults));
        NG_TRY(attach_primitive(l, where, node, i, place, child));
    }
    return NG_OK;
}

static ng_result attach_copies(struct gltf_loader *l, const char *where, uint32_t node,
                               const struct ng_transform *places, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        ng_entity copy;
        NG_TRY(ng_gltf_entity(l, l->nodes[node], "", "copy", i, &copy));
        NG_TRY(ng_gltf_add(l, copy, where, NG_TRANSFORM, &places[i]));
        NG_TRY(attach_primitives(l, where, node, &places[i], copy));
    }
    return NG_OK;
}

static ng_result attach_mesh(struct gltf_loader *l, const char *where, uint32_t node)
{
    const struct gltf_node *n = &l->doc->nodes[node];
    if (n->mesh == -1)
        return NG_OK;
    if (n->mesh < 0 || (uint32_t)n->mesh >= l->doc->mesh_count)
        return ng_gltf_fault(&l->faults, "the node has none", "%s: mesh %d is not one of %u", where, n->mesh,
                             l->doc->mesh_count);
    struct ng_transform *places;
    uint32_t count;
    ng_result r = ng_gltf_copies(l, where, n, &places, &count);
    if (r == NG_OK)
        r = count ? attach_copies(l, where, node, places, count)
                  : attach_primitives(l, where, node, ng_transform_component.defaults, l->nodes[node]);
    free(places);
    return r;
}

static ng_result perspective_camera(struct gltf_loader *l, int index, const struct gltf_camera *c,
                                    struct ng_camera *out)
{
    if (c->fov_y > 0 && c->fov_y < GLM_PI)
        out->fov_y = (float)c->fov_y;
    else
        NG_TRY(ng_gltf_fault(&l->faults, "the default is used", "camera %d: yfov %g is not in 0 to pi", index,
                             c->fov_y));
    if (c->near_plane > 0)
        out->near_plane = (float)c->near_plane;
    else
        NG_TRY(ng_gltf_fault(&l->faults, "the default is used", "camera %d: znear %g is not above 0", index,
                             c->near_plane));
    return NG_OK;
}

// Its near plane may be where it stands.
static ng_result orthographic_camera(struct gltf_loader *l, int index, const struct gltf_camera *c,
                                     struct ng_camera *out)
{
    out->projection = NG_PROJECTION_ORTHOGRAPHIC;
    if (fabs(c->y_mag) > 0)
        out->height = (float)fmin(fmax(2 * fabs(c->y_mag), 1e-4), 1e6);
    else
        NG_TRY(ng_gltf_fault(&l->faults, "the default is used", "camera %d: ymag is 0", index));
    out->near_plane = (float)fmin(fmax(c->near_plane, 1e-5), 1e5);
    return NG_OK;
}

static ng_result attach_camera(struct gltf_loader *l, const char *where, uint32_t node)
{
    int index = l->doc->nodes[node].camera;
    if (index == -1)
        return NG_OK;
    if (index < 0 || (uint32_t)index >= l->doc->camera_count)
        return ng_gltf_fault(&l->faults, "the node has none", "%s: camera %d is not one of %u", where, index,
                             l->doc->camera_count);
    const struct gltf_camera *c = &l->doc->cameras[index];
    struct ng_camera camera;
    memcpy(&camera, ng_camera_component.defaults, sizeof camera);
    if (c->orthographic)
        NG_TRY(orthographic_camera(l, index, c, &camera));
    else if (c->perspective)
        NG_TRY(perspective_camera(l, index, c, &camera));
    else
        return ng_gltf_fault(&l->faults, "the node has none",
                             "camera %d: is neither perspective nor orthographic", index);
    ng_gltf_expose(l, &camera);
    return ng_gltf_add(l, l->nodes[node], where, NG_CAMERA, &camera);
}

static ng_result light_color(struct gltf_loader *l, const char *where, const struct gltf_light *light,
                             float out[3])
{
    if (light->color.count != 0 && light->color.count != 3)
        return ng_gltf_fault(&l->faults, "it is white", "%s: a light's color has %u numbers, not 3", where,
                             light->color.count);
    for (uint32_t i = 0; i < light->color.count; i++)
        out[i] = (float)light->color.items[i];
    return NG_OK;
}

// Exporters write a sharp cone as two equal angles, which the standard does not allow.
static ng_result cone_angles(struct gltf_loader *l, const char *where, const struct gltf_light *light,
                             struct ng_light_spot *out)
{
    out->inner_angle = (float)light->inner_angle;
    out->outer_angle = (float)light->outer_angle;
    if (out->inner_angle < out->outer_angle)
        return NG_OK;
    out->inner_angle = nextafterf(out->outer_angle, 0);
    return ng_gltf_fault(&l->faults, "its edge is sharp",
                         "%s: a spot light's innerConeAngle %g is not below its outerConeAngle %g", where,
                         light->inner_angle, light->outer_angle);
}

static ng_result add_light(struct gltf_loader *l, const char *where, const struct gltf_light *light,
                           ng_entity e)
{
    float c[3] = {1, 1, 1}, strength = (float)light->intensity;
    NG_TRY(light_color(l, where, light, c));
    if (strcmp(light->type, "point") == 0) {
        struct ng_light_point point = {.on = true, .color = {c[0], c[1], c[2]}, .intensity = strength};
        return ng_gltf_add(l, e, where, NG_LIGHT_POINT, &point);
    }
    if (strcmp(light->type, "directional") == 0) {
        struct ng_light_directional sun = {.on = true, .color = {c[0], c[1], c[2]}, .irradiance = strength};
        return ng_gltf_add(l, e, where, NG_LIGHT_DIRECTIONAL, &sun);
    }
    if (strcmp(light->type, "spot") != 0)
        return ng_gltf_fault(&l->faults, "it is left out",
                             "%s: light type \"%.40s\" is not point, spot or directional", where,
                             light->type);
    struct ng_light_spot spot = {.on = true, .color = {c[0], c[1], c[2]}, .intensity = strength};
    NG_TRY(cone_angles(l, where, light, &spot));
    return ng_gltf_add(l, e, where, NG_LIGHT_SPOT, &spot);
}

static ng_result attach_light(struct gltf_loader *l, const char *where, uint32_t node)
{
    int index = l->doc->nodes[node].light;
    if (index == -1)
        return NG_OK;
    if (index < 0 || (uint32_t)index >= l->doc->light_count)
        return ng_gltf_fault(&l->faults, "the node has none", "%s: light %d is not one of %u", where, index,
                             l->doc->light_count);
    return add_light(l, where, &l->doc->lights[index], l->nodes[node]);
}

static void count_light(struct gltf_loader *l, ng_entity e)
{
    for (ng_component c = 0; c < NG_COMPONENT_COUNT; c++)
        l->out.light_count += ng_component_is_light(c) && ng_world_has(l->world, e, c);
}

static void note_camera(struct gltf_loader *l, ng_entity e)
{
    if (ng_entity_is_null(l->out.camera) && ng_world_has(l->world, e, NG_CAMERA))
        l->out.camera = e;
}

// Cages of primitives, to be named by the subdivision of their entities. Where one was refused, the triangles
// are drawn as they are.
static ng_result attach_cages(struct gltf_loader *l)
{
    for (size_t i = 0; i < l->instances.count; i++) {
        const struct gltf_instance *instance = &l->instances.items[i];
        if (!instance->shape.has_cage || !ng_world_has(l->world, instance->entity, NG_SUBDIVISION))
            continue;
        if (!instance->shape.cage.id) {
            NG_TRY(ng_world_remove(l->world, instance->entity, NG_SUBDIVISION));
            continue;
        }
        struct ng_subdivision *subdivision = ng_world_edit(l->world, instance->entity, NG_SUBDIVISION);
        if (!subdivision)
            return NG_ERROR_MEMORY;
        subdivision->cage = instance->shape.cage;
    }
    return NG_OK;
}

ng_result ng_gltf_attachments(struct gltf_loader *l)
{
    for (uint32_t i = 0; i < l->order_count; i++) {
        uint32_t node = l->order[i];
        char where[32];
        if (l->placed[node] == GLTF_ABOVE)
            continue;
        snprintf(where, sizeof where, "node %u", node);
        NG_TRY(attach_mesh(l, where, node));
        NG_TRY(attach_camera(l, where, node));
        NG_TRY(attach_light(l, where, node));
        NG_TRY(ng_gltf_components(l, l->nodes[node], where, l->doc->nodes[node].extension, NULL));
    }
    NG_TRY(attach_cages(l));
    ng_entity top = l->out.root;
    for (ng_entity e = top; !ng_entity_is_null(e); e = ng_world_next_below(l->world, top, e)) {
        count_light(l, e);
        note_camera(l, e);
    }
    return NG_OK;
}

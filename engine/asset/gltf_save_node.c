// Nodes: their transform, and what hangs on them.
#include "asset/gltf_save_internal.h"
#include "asset/gltf_unit.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_directional.h"
#include "components/light_point.h"
#include "components/light_spot.h"
#include "components/mesh.h"
#include "components/morph.h"
#include "components/transform.h"

#include <cglm/cglm.h>
#include <cjson/cJSON.h>

#include <math.h>
#include <string.h>

// ---- transform -------------------------------------------------------------------------------------------

// As loading does it.
static void normalize_rotation(float *q)
{
    (void)ng_gltf_normalize_rotation(q);
}

static bool same_bits(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

static void save_transform(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node)
{
    static const struct ng_transform identity = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    const struct ng_transform *now = ng_world_get(s->world, p->entity, NG_TRANSFORM);
    now = now ? now : &identity;
    bool moved = false;
    for (uint32_t i = 0; i < ng_transform_component.field_count; i++) {
        const struct ng_field *f = &ng_transform_component.fields[i];
        const char *start = (const char *)&identity + f->offset;
        moved |= p->kept ? ng_gltf_field_changed(s, p, NG_TRANSFORM, f)
                         : memcmp((const char *)now + f->offset, start, ng_field_size(f->type)) != 0;
    }
    if (!moved)
        return;
    float rotation[4];
    ng_gltf_before_normalizing(normalize_rotation, 4, now->rotation, rotation);
    bool turned = !same_bits(now->rotation, identity.rotation, sizeof rotation);
    bool scaled = !same_bits(now->scale, identity.scale, sizeof now->scale);
    bool placed = !same_bits(now->translation, identity.translation, sizeof now->translation);
    bool matrix = ng_gltf_json_get(node, "matrix");
    ng_gltf_json_remove(node, "matrix");
    const struct {
        const char *key;
        const float *values;
        size_t count;
        bool is_set;
    } parts[] = {{"translation", now->translation, 3, placed},
                 {"rotation", rotation, 4, turned},
                 {"scale", now->scale, 3, scaled}};
    for (size_t i = 0; i < NG_COUNT(parts); i++) {
        const struct ng_field *f = ng_component_field(&ng_transform_component, parts[i].key);
        if (p->kept && !matrix && !ng_gltf_field_changed(s, p, NG_TRANSFORM, f))
            continue;
        if (parts[i].is_set)
            ng_gltf_json_floats(&s->w, node, parts[i].key, parts[i].values, parts[i].count);
        else
            ng_gltf_json_remove(node, parts[i].key);
    }
}

// ---- cameras ---------------------------------------------------------------------------------------------

static bool field_changed(struct gltf_saver *s, const struct gltf_saved *p, ng_component component,
                          const char *name)
{
    return ng_gltf_field_changed(s, p, component,
                                 ng_component_field(ng_world_component(s->world, component), name));
}

// Cameras and lights that others have too are left to them: a changed one is an object of its own.
static cJSON *new_object(struct gltf_saver *s, enum ng_gltf_list list, int old, int *index)
{
    cJSON *object;
    const cJSON *from = ng_gltf_at(&s->w, list, old);
    *index = ng_gltf_append(&s->w, list, &object);
    for (const cJSON *item = from ? from->child : NULL; item && object; item = item->next) {
        cJSON *copy = cJSON_Duplicate(item, true);
        s->w.failed |= !copy || !cJSON_AddItemToObject(object, item->string, copy);
    }
    return object;
}

// The object that a node names, if no other node does: it may be changed in place.
static cJSON *own_object(struct gltf_saver *s, enum ng_gltf_list list, int (*named_by)(const cJSON *node),
                         int old, int *index)
{
    unsigned users = 0;
    for (size_t i = 0; old >= 0 && i < s->w.lists[NG_GLTF_NODES].count; i++)
        users += named_by(s->w.lists[NG_GLTF_NODES].items[i]) == old;
    *index = old;
    return old >= 0 && users == 1 ? ng_gltf_at(&s->w, list, old) : new_object(s, list, old, index);
}

static int camera_of(const cJSON *node)
{
    return ng_gltf_json_index(node, "camera");
}

static void write_perspective(struct gltf_saver *s, const struct ng_camera *now, cJSON *camera)
{
    ng_gltf_json_text(&s->w, camera, "type", "perspective");
    ng_gltf_json_remove(camera, "orthographic");
    cJSON *perspective = ng_gltf_json_object(&s->w, camera, "perspective");
    ng_gltf_json_floats(&s->w, perspective, "yfov", &now->fov_y, 1);
    ng_gltf_json_floats(&s->w, perspective, "znear", &now->near_plane, 1);
}

// The standard wants a width and a far plane, which we do not have: a square, and far away.
static void write_orthographic(struct gltf_saver *s, const struct ng_camera *now, cJSON *camera)
{
    const float half = 0.5f * now->height, far = 1e6f;
    ng_gltf_json_text(&s->w, camera, "type", "orthographic");
    ng_gltf_json_remove(camera, "perspective");
    cJSON *orthographic = ng_gltf_json_object(&s->w, camera, "orthographic");
    if (!ng_gltf_json_get(orthographic, "xmag"))
        ng_gltf_json_floats(&s->w, orthographic, "xmag", &half, 1);
    ng_gltf_json_floats(&s->w, orthographic, "ymag", &half, 1);
    ng_gltf_json_floats(&s->w, orthographic, "znear", &now->near_plane, 1);
    if (!ng_gltf_json_get(orthographic, "zfar"))
        ng_gltf_json_floats(&s->w, orthographic, "zfar", &far, 1);
}

static void save_camera(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node)
{
    const struct ng_camera *now = ng_world_get(s->world, p->entity, NG_CAMERA);
    int old = camera_of(node), index;
    bool was = p->kept && p->kept->components >> NG_CAMERA & 1, changed = !was;
    if (!now && was)
        ng_gltf_json_remove(node, "camera");
    uint64_t standard = 0;
    bool parallel = now && now->projection == NG_PROJECTION_ORTHOGRAPHIC;
    const char *const fields[] = {"projection", parallel ? "height" : "fov_y", "near_plane"};
    for (size_t i = 0; now && (!was || old >= 0) && i < NG_COUNT(fields); i++) {
        standard |= ng_gltf_field_bit(s, NG_CAMERA, fields[i]);
        changed |= was && field_changed(s, p, NG_CAMERA, fields[i]);
    }
    if (standard && changed) {
        cJSON *camera = own_object(s, NG_GLTF_CAMERAS, camera_of, old, &index);
        if (parallel)
            write_orthographic(s, now, camera);
        else
            write_perspective(s, now, camera);
        ng_gltf_json_number(&s->w, node, "camera", index);
    }
    ng_gltf_save_component(s, p, node, NG_CAMERA, standard);
}

// ---- lights ----------------------------------------------------------------------------------------------

// What KHR_lights_punctual has a place for.
static const struct punctual {
    ng_component component;
    const char *type, *strength;
} punctuals[] = {{NG_LIGHT_POINT, "point", "intensity"},
                 {NG_LIGHT_DIRECTIONAL, "directional", "irradiance"},
                 {NG_LIGHT_SPOT, "spot", "intensity"}};

static int light_of(const cJSON *node)
{
    const cJSON *extensions = ng_gltf_json_get(node, "extensions");
    return ng_gltf_json_index(ng_gltf_json_get(extensions, "KHR_lights_punctual"), "light");
}

// The component that a node's light of the document became; of a node without one, the first that may.
static const struct punctual *find_punctual(const struct gltf_saver *s, const struct gltf_saved *p,
                                            const cJSON *node)
{
    const cJSON *type = ng_gltf_json_get(ng_gltf_at(&s->w, NG_GLTF_LIGHTS, light_of(node)), "type");
    for (size_t i = 0; i < NG_COUNT(punctuals); i++) {
        const struct punctual *u = &punctuals[i];
        bool was = p->kept && p->kept->components >> u->component & 1;
        if (cJSON_IsString(type) ? strcmp(type->valuestring, u->type) == 0
                                 : !was && ng_world_has(s->world, p->entity, u->component))
            return u;
    }
    return NULL;
}

// The standard keeps colours below 1; others are NG_scene's.
static bool is_standard_color(const float color[3])
{
    return color[0] <= 1 && color[1] <= 1 && color[2] <= 1;
}

static void put_angles(struct gltf_saver *s, cJSON *light, const struct ng_light_spot *spot)
{
    cJSON *json = ng_gltf_json_object(&s->w, light, "spot");
    ng_gltf_json_number(&s->w, json, "innerConeAngle", ng_gltf_decimal(spot->inner_angle));
    ng_gltf_json_number(&s->w, json, "outerConeAngle", fmin(ng_gltf_decimal(spot->outer_angle), GLM_PI_2));
}

static void put_light(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node, const struct punctual *u,
                      const float *color)
{
    const struct ng_component_desc *desc = ng_world_component(s->world, u->component);
    const char *now = ng_world_get(s->world, p->entity, u->component);
    int index;
    cJSON *light = own_object(s, NG_GLTF_LIGHTS, light_of, light_of(node), &index);
    float shown[3];
    for (int i = 0; i < 3; i++)
        shown[i] = fminf(color[i], 1);
    ng_gltf_json_text(&s->w, light, "type", u->type);
    ng_gltf_json_floats(&s->w, light, "color", shown, 3);
    ng_gltf_json_floats(&s->w, light, "intensity",
                        (const float *)(now + ng_component_field(desc, u->strength)->offset), 1);
    if (u->component == NG_LIGHT_SPOT)
        put_angles(s, light, (const struct ng_light_spot *)now);
    ng_gltf_json_number(&s->w, ng_gltf_json_extension(&s->w, node, "KHR_lights_punctual"), "light", index);
}

// `*out`: the component that has its light in the document now.
static uint64_t save_light(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node, ng_component *out)
{
    const struct punctual *u = find_punctual(s, p, node);
    if (!u)
        return 0;
    const struct ng_component_desc *desc = ng_world_component(s->world, u->component);
    const char *now = ng_world_get(s->world, p->entity, u->component);
    *out = u->component;
    if (!now) {
        ng_gltf_json_remove_extension(node, "KHR_lights_punctual");
        return NG_GLTF_IMPLIED;
    }
    const float *color = (const float *)(now + ng_component_field(desc, "color")->offset);
    uint64_t standard = ng_gltf_field_bit(s, u->component, u->strength);
    standard |= is_standard_color(color) ? ng_gltf_field_bit(s, u->component, "color") : 0;
    bool spot = u->component == NG_LIGHT_SPOT;
    if (spot)
        standard |= ng_gltf_field_bit(s, NG_LIGHT_SPOT, "inner_angle") |
                    ng_gltf_field_bit(s, NG_LIGHT_SPOT, "outer_angle");
    bool differs = light_of(node) < 0 || field_changed(s, p, u->component, "color") ||
                   field_changed(s, p, u->component, u->strength) ||
                   (spot && (field_changed(s, p, NG_LIGHT_SPOT, "inner_angle") ||
                             field_changed(s, p, NG_LIGHT_SPOT, "outer_angle")));
    if (differs)
        put_light(s, p, node, u, color);
    return standard;
}

// ---- morph targets ---------------------------------------------------------------------------------------

// The weights of the mesh that is the node's own; those of several primitives are theirs.
static void save_weights(struct gltf_saver *s, const struct gltf_saved *p, cJSON *node)
{
    const struct ng_morph *now = ng_world_get(s->world, p->entity, NG_MORPH);
    const struct ng_mesh *mesh = ng_world_get(s->world, p->entity, NG_MESH);
    const struct ng_geometry *g = mesh ? ng_assets_geometry(s->assets, mesh->geometry) : NULL;
    if (!now || !g || !g->target_count) {
        ng_gltf_save_component(s, p, node, NG_MORPH, 0);
        return;
    }
    bool differs = false;
    for (uint32_t i = 0; i < ng_morph_component.field_count; i++)
        differs |= p->kept ? ng_gltf_field_changed(s, p, NG_MORPH, &ng_morph_component.fields[i])
                           : now->weights[i * 4] != 0 || now->weights[i * 4 + 1] != 0 ||
                                 now->weights[i * 4 + 2] != 0 || now->weights[i * 4 + 3] != 0;
    double weights[NG_MORPH_TARGETS];
    for (uint32_t i = 0; i < g->target_count; i++)
        weights[i] = ng_gltf_decimal(now->weights[i]);
    if (differs)
        ng_gltf_json_numbers(&s->w, node, "weights", weights, g->target_count);
    ng_gltf_save_component(s, p, node, NG_MORPH, ~(uint64_t)0);
}

void ng_gltf_save_node(struct gltf_saver *s, const struct gltf_saved *p)
{
    cJSON *node = ng_gltf_saved_json(s, p);
    ng_component light = NG_COMPONENT_COUNT;
    ng_gltf_save_name(s, p, node);
    save_transform(s, p, node);
    ng_gltf_save_mesh(s, p);
    save_camera(s, p, node);
    uint64_t but = (uint64_t)1 << NG_TRANSFORM | (uint64_t)1 << NG_SKIN | (uint64_t)1 << NG_CAMERA |
                   (uint64_t)1 << NG_MESH | (uint64_t)1 << NG_MORPH;
    save_weights(s, p, node);
    uint64_t fields = save_light(s, p, node, &light);
    if (fields) {
        ng_gltf_save_component(s, p, node, light, fields);
        but |= (uint64_t)1 << light;
    }
    if (ng_world_has(s->world, p->entity, NG_MESH))
        ng_gltf_save_component(s, p, node, NG_MESH,
                               NG_GLTF_IMPLIED | ng_gltf_field_bit(s, NG_MESH, "material"));
    ng_gltf_save_others(s, p, node, but);
}

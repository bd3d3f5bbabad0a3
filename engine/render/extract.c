// The steps of an extraction. What entities there are is found out from counts and high-water marks of change
// ticks; only where these moved are lists made anew. Everything else follows single rows that changed.
#include "render/extract.h"

#include "base/hash.h"
#include "base/log.h"
#include "base/serial.h"
#include "components/camera.h"
#include "components/name.h"
#include "components/scene_scale.h"
#include "render/extract_internal.h"

#include <assert.h>
#include <cglm/cglm.h>
#include <stdlib.h>
#include <string.h>

bool ng_extract_warn_once(struct ng_extractor *x, ng_entity e, enum ng_extract_warning kind)
{
    uint64_t key = ng_hash_combine(e.id, kind) | 1;
    if (ng_index_map_get(&x->warned, key) != UINT32_MAX)
        return false;
    return ng_index_map_set(&x->warned, key, 0); // out of memory: rather silent than every frame
}

ng_result ng_extractor_create(struct ng_extractor **out)
{
    struct ng_extractor *x = calloc(1, sizeof *x);
    *out = x;
    if (!x)
        return ng_out_of_memory("the frame's scene");
    x->clock = ng_serial_range();
    ng_result r = ng_extract_make_builtin(x);
    if (r != NG_OK)
        ng_extractor_destroy(out);
    return r;
}

void ng_extractor_destroy(struct ng_extractor **extractor)
{
    struct ng_extractor *x = *extractor;
    *extractor = NULL;
    if (!x)
        return;
    struct ng_query **queries[] = {&x->meshes,    &x->placed,  &x->skinned, &x->subdivided,
                                   &x->materials, &x->cameras, &x->scales};
    for (size_t i = 0; i < NG_COUNT(queries); i++)
        ng_query_destroy(queries[i]);
    for (uint32_t i = 0; i < x->light_types; i++)
        ng_query_destroy(&x->lights[i]);
    for (size_t i = 0; i < x->pieces.count; i++)
        ng_extract_free_deformed(&x->pieces.items[i].deformed);
    for (size_t i = 0; i < x->old_pieces.count; i++)
        ng_extract_free_deformed(&x->old_pieces.items[i].deformed);
    ng_extract_finish_poses(x);
    ng_extract_finish_lights(x);
    ng_extract_finish_shapes(x);
    ng_array_finish(&x->pieces);
    ng_array_finish(&x->old_pieces);
    ng_array_finish(&x->moved);
    ng_array_finish(&x->morphing);
    ng_array_finish(&x->skinning);
    ng_array_finish(&x->posing);
    ng_array_finish(&x->records);
    ng_array_finish(&x->old_records);
    ng_array_finish(&x->image_ids);
    ng_array_finish(&x->mesh_array);
    ng_array_finish(&x->instances);
    ng_array_finish(&x->old_instances);
    ng_array_finish(&x->images);
    ng_array_finish(&x->material_array);
    ng_array_finish(&x->light_array);
    ng_index_map_finish(&x->piece_of);
    ng_index_map_finish(&x->material_of);
    ng_index_map_finish(&x->image_of);
    ng_index_map_finish(&x->warned);
    free(x);
}

struct ng_extract_stats ng_extractor_stats_of(const struct ng_extractor *x)
{
    return x->stats;
}

// ---- what is there ---------------------------------------------------------------------------------------
static ng_result query_of(struct ng_world *world, ng_component first, ng_component second,
                          struct ng_query **out)
{
    struct ng_query_desc desc = {.terms = {{.component = first}, {.component = second}}, .term_count = 2};
    desc.term_count -= first == second;
    return ng_query_create(world, &desc, out);
}

static ng_result bind_world(struct ng_extractor *x, const struct ng_extract_params *p)
{
    NG_REQUIRE(p->world && p->assets, "ng_extract needs a world and an asset store");
    NG_REQUIRE(!x->world || (x->world == p->world && x->assets == p->assets),
               "an extractor belongs to one world and one asset store");
    x->jobs = p->jobs;
    if (x->world)
        return NG_OK;
    NG_TRY(query_of(p->world, NG_MESH, NG_MESH, &x->meshes));
    NG_TRY(query_of(p->world, NG_PLACEMENT, NG_MESH, &x->placed));
    NG_TRY(query_of(p->world, NG_SKIN, NG_MESH, &x->skinned));
    NG_TRY(query_of(p->world, NG_SUBDIVISION, NG_MESH, &x->subdivided));
    NG_TRY(query_of(p->world, NG_MATERIAL, NG_MATERIAL, &x->materials));
    NG_TRY(query_of(p->world, NG_CAMERA, NG_CAMERA, &x->cameras));
    NG_TRY(query_of(p->world, NG_SCENE_SCALE, NG_SCENE_SCALE, &x->scales));
    for (; ng_light_types[x->light_types]; x->light_types++) {
        assert(x->light_types < NG_COUNT(x->lights));
        ng_component component = ng_light_types[x->light_types]->component;
        NG_TRY(query_of(p->world, component, component, &x->lights[x->light_types]));
    }
    x->world = p->world;
    x->assets = p->assets;
    return NG_OK;
}

static struct ng_extract_counts count_all(const struct ng_extractor *x)
{
    struct ng_extract_counts c = {.meshes = ng_query_count(x->meshes),
                                  .placed = ng_query_count(x->placed),
                                  .skinned = ng_query_count(x->skinned),
                                  .subdivided = ng_query_count(x->subdivided),
                                  .materials = ng_query_count(x->materials)};
    for (uint32_t i = 0; i < x->light_types; i++)
        c.lights += ng_query_count(x->lights[i]);
    return c;
}

static bool parts_changed(const struct ng_extractor *x, const struct ng_extract_counts *now)
{
    const struct ng_extract_counts *was = &x->counts;
    static const ng_component parts[] = {NG_MESH, NG_SKIN, NG_SUBDIVISION};
    for (size_t i = 0; i < NG_COUNT(parts); i++)
        if (ng_world_component_changed_at(x->world, parts[i]) > x->since)
            return true;
    return now->meshes != was->meshes || now->placed != was->placed || now->skinned != was->skinned ||
           now->subdivided != was->subdivided;
}

// ---- scale and camera ------------------------------------------------------------------------------------
static void read_scale(struct ng_extractor *x)
{
    ng_query_each (it, x->scales) {
        const struct ng_scene_scale *scale = it.columns[0];
        memcpy(x->snapshot.scene_center, scale->center, sizeof scale->center);
        x->snapshot.scene_radius = scale->radius;
        x->has_scale = true;
        ng_query_stop(&it);
        return;
    }
}

// A world that does not say how large it is is as large as what was in it when first extracted.
static void guess_scale(struct ng_extractor *x)
{
    float low[3] = {0}, high[3] = {0}, half[3];
    if (x->has_scale || !x->pieces.count)
        return;
    for (size_t i = 0; i < x->pieces.count; i++) {
        const struct ng_snapshot_instance *instance = &x->instances.items[i];
        for (int k = 0; k < 3; k++) {
            low[k] = i && low[k] < instance->bounds_min[k] ? low[k] : instance->bounds_min[k];
            high[k] = i && high[k] > instance->bounds_max[k] ? high[k] : instance->bounds_max[k];
        }
    }
    glm_vec3_center(low, high, x->snapshot.scene_center);
    glm_vec3_sub(high, x->snapshot.scene_center, half);
    x->snapshot.scene_radius = glm_vec3_norm(half);
    x->has_scale = true;
}

// The camera asked for: by name, or the first; of several with one name, the one with the smallest index.
static ng_entity find_camera(struct ng_extractor *x, const char *wanted)
{
    ng_entity best = {0};
    uint32_t found = 0;
    ng_query_each (it, x->cameras) {
        for (uint32_t i = 0; i < it.count; i++) {
            const struct ng_name *name = ng_world_get(x->world, it.entities[i], NG_NAME);
            if (wanted && wanted[0] && (!name || strcmp(name->text, wanted) != 0))
                continue;
            if (!found++ || ng_entity_index(it.entities[i]) < ng_entity_index(best))
                best = it.entities[i];
        }
    }
    if (found > 1 && ng_extract_warn_once(x, (ng_entity){0}, NG_WARN_CAMERAS)) {
        char name[NG_TEXT_SIZE];
        ng_log_warn("%u cameras to choose from: '%s' (entity %u) is used; name another to change that", found,
                    ng_extract_name(x, best, name), ng_entity_index(best));
    }
    return best;
}

// World to camera of a placement: scale and shear do not matter to a camera, but a mirror shows what mirrors
// show. Looks along -Z; where Y does not say what is up, anything is.
static void view_of(const float placement[16], float view[16], float position[3])
{
    mat4 m;
    vec3 x, y, z;
    memcpy(m, placement, sizeof m);
    memcpy(position, m[3], 3 * sizeof(float));
    glm_vec3_cross(m[0], m[1], x);
    bool mirrors = glm_vec3_dot(x, m[2]) < 0;
    glm_vec3_normalize_to(m[2], z);
    if (!(glm_vec3_norm2(z) > 0))
        z[2] = 1;
    glm_vec3_normalize_to(m[1], y);
    glm_vec3_muladds(z, -glm_vec3_dot(y, z), y);
    if (!(glm_vec3_norm2(y) > 1e-12f))
        glm_vec3_ortho(z, y);
    glm_vec3_normalize(y);
    glm_vec3_cross(y, z, x);
    glm_vec3_scale(x, mirrors ? -1.0f : 1.0f, x);
    const float *rows[3] = {x, y, z};
    memset(view, 0, sizeof m);
    for (int row = 0; row < 3; row++) {
        for (int c = 0; c < 3; c++)
            view[c * 4 + row] = rows[row][c];
        view[12 + row] = -glm_vec3_dot((float *)rows[row], position);
    }
    view[15] = 1;
}

// No camera at all: the whole sphere of the scene, seen along -Z.
static struct ng_free_camera whole_scene(const struct ng_snapshot *s)
{
    struct ng_free_camera c = {{.fov_y = 0.7f, .near_plane = 0.01f, .exposure = 1},
                               {{[0] = 1, [5] = 1, [10] = 1, [15] = 1}}};
    memcpy(c.placement.matrix + 12, s->scene_center, sizeof s->scene_center);
    c.placement.matrix[14] += s->scene_radius / sinf(0.5f * c.lens.fov_y);
    return c;
}

static struct ng_free_camera camera_of(const struct ng_extractor *x, ng_entity e,
                                       const struct ng_extract_params *p)
{
    const struct ng_camera *lens = ng_world_get(x->world, e, NG_CAMERA);
    struct ng_free_camera c;
    if (p->free_camera)
        return *p->free_camera;
    if (!lens)
        return whole_scene(&x->snapshot);
    c.lens = *lens;
    memcpy(c.placement.matrix, ng_extract_placement(x, e), sizeof c.placement.matrix);
    return c;
}

static void read_camera(struct ng_extractor *x, ng_entity e, const struct ng_extract_params *p)
{
    struct ng_snapshot_camera *c = &x->snapshot.camera, before = *c;
    const struct ng_free_camera from = camera_of(x, e, p);
    view_of(from.placement.matrix, c->view, c->position);
    c->fov_y = from.lens.fov_y;
    c->orthographic = from.lens.projection == NG_PROJECTION_ORTHOGRAPHIC;
    c->height = c->orthographic ? from.lens.height : 0;
    c->near_plane = from.lens.near_plane;
    c->subpixel = p->subpixel;
    c->exposure = from.lens.exposure;
    c->auto_exposure = from.lens.auto_exposure;
    memcpy(c->background, from.lens.background, sizeof c->background);
    bool is_free = p->free_camera != NULL;
    bool same_camera =
        x->frames && ng_entity_same(before.entity, e) && is_free == x->free_camera && !p->still;
    memcpy(c->previous_view, same_camera ? before.view : c->view, sizeof c->view);
    c->entity = e;
    x->free_camera = is_free;
    if (p->exposure.mode != NG_EXPOSURE_CAMERA) {
        c->auto_exposure = p->exposure.mode == NG_EXPOSURE_AUTO;
        c->exposure = c->auto_exposure ? 1 : p->exposure.factor;
    }
    c->exposure *= exp2f(p->exposure.stops);
    if (x->snapshot.environment != NG_NONE)
        memset(c->background, 0, sizeof c->background);
}

// ---- the extraction --------------------------------------------------------------------------------------
static void stop_motion(struct ng_extractor *x)
{
    for (size_t i = 0; i < x->moved.count; i++) {
        struct ng_snapshot_instance *instance = &x->instances.items[x->moved.items[i]];
        memcpy(instance->previous_matrix, instance->matrix, sizeof instance->matrix);
        x->mesh_array.items[instance->mesh].previous_positions = NULL;
    }
}

// After a failure half-way: the next extraction begins anew.
static void forget(struct ng_extractor *x)
{
    for (size_t i = 0; i < x->pieces.count; i++)
        ng_extract_free_deformed(&x->pieces.items[i].deformed);
    for (size_t i = 0; i < x->old_pieces.count; i++)
        ng_extract_free_deformed(&x->old_pieces.items[i].deformed);
    for (size_t i = 0; i < x->slots.count; i++)
        x->slots.items[i].instance = NG_NONE;
    x->pieces.count = x->old_pieces.count = x->instances.count = x->old_instances.count = 0;
    x->moved.count = x->records.count = 0;
    ng_index_map_clear(&x->piece_of);
    x->counts = (struct ng_extract_counts){0};
    x->assets_revision = (struct ng_asset_revision){0};
    x->since = 0;
    x->image_list_dirty = true;
}

static void publish(struct ng_extractor *x, double time)
{
    struct ng_snapshot *s = &x->snapshot;
    s->time = time;
    s->frame = x->frames++;
    s->mesh_count = (uint32_t)x->mesh_array.count;
    s->meshes = x->mesh_array.items;
    s->instance_count = (uint32_t)x->instances.count;
    s->instances = x->instances.items;
    s->image_count = (uint32_t)x->images.count;
    s->images = x->images.items;
    s->material_count = (uint32_t)x->material_array.count;
    s->materials = x->material_array.items;
    s->light_count = (uint32_t)x->slots.count;
    s->lights = x->light_array.items;
}

static ng_result update(struct ng_extractor *x)
{
    struct ng_extract_counts counts = count_all(x);
    struct ng_asset_revision revision = ng_assets_latest(x->assets);
    bool assets_changed = revision.content != x->assets_revision.content, lights_listed, materials_listed;
    bool others = revision.topology != x->assets_revision.topology;
    read_scale(x);
    NG_TRY(ng_extract_list_lights(x, counts.lights != x->counts.lights, &lights_listed));
    NG_TRY(ng_extract_read_materials(x, counts.materials != x->counts.materials, assets_changed,
                                     &materials_listed));
    if (assets_changed)
        NG_TRY(ng_extract_follow_shapes(x));
    if (lights_listed || materials_listed || others || parts_changed(x, &counts))
        NG_TRY(ng_extract_list_pieces(x));
    else
        NG_TRY(ng_extract_follow_pieces(x, assets_changed));
    NG_TRY(ng_extract_pose(x));
    guess_scale(x);
    NG_TRY(ng_extract_update_lights(x, lights_listed));
    NG_TRY(ng_extract_write_materials(x));
    x->counts = counts;
    x->assets_revision = revision;
    return NG_OK;
}

ng_result ng_extract(struct ng_extractor *x, const struct ng_extract_params *p,
                     const struct ng_snapshot **out)
{
    *out = NULL;
    NG_TRY(bind_world(x, p));
    ng_entity camera = p->free_camera ? (ng_entity){0} : find_camera(x, p->camera);
    if (!p->free_camera && ng_entity_is_null(camera) && p->camera && p->camera[0]) {
        ng_log_error("no camera is named '%s'; `lightformer info SCENE` lists the cameras", p->camera);
        return NG_ERROR_NOT_FOUND;
    }
    uint32_t now = ng_world_stamp(x->world);
    ng_extract_settle(x);
    ng_result r = update(x);
    if (r != NG_OK) {
        forget(x);
        return r;
    }
    x->since = now;
    read_camera(x, camera, p);
    if (p->still)
        stop_motion(x);
    publish(x, p->time);
    *out = &x->snapshot;
    return NG_OK;
}

// Extraction: what it lists, what it says has changed, motion, skinning, emitters, warnings.
#include "test.h"

#include "asset/assets.h"
#include "asset/geometry.h"
#include "base/jobs.h"
#include "base/rng.h"
#include "components/animation.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_disk.h"
#include "components/light_environment.h"
#include "components/light_mesh.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/light_sphere.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/morph.h"
#include "components/name.h"
#include "components/placement.h"
#include "components/placement_system.h"
#include "components/scene_scale.h"
#include "components/skin.h"
#include "components/subdivision.h"
#include "components/transform.h"
#include "render/extract.h"
#include "render/scene_systems.h"
#include "scene/system.h"
#include "scene/world.h"

#include <math.h>

#define NEAR(a, b, e) assert_true(fabs((double)(a) - (double)(b)) <= (e))
#define OK(call)      assert_int_equal((call), NG_OK)

struct scene {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_jobs *jobs;
    struct ng_extractor *extractor;
    ng_asset box;
    ng_entity scale, camera, material;
};

static ng_entity add_entity(struct scene *s, const char *name, float x, float y, float z)
{
    ng_entity e = ng_entity_create(s->world);
    struct ng_transform transform = {.translation = {x, y, z}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    struct ng_name text = {{0}};
    snprintf(text.text, sizeof text.text, "%s", name);
    OK(ng_world_add(s->world, e, NG_NAME, &text));
    OK(ng_world_add(s->world, e, NG_TRANSFORM, &transform));
    return e;
}

static void *copy_of(const void *data, size_t size)
{
    void *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, data, size);
    return copy;
}

// A flat strip of `n` quads along x, one unit each, in the plane z = 0.
static struct ng_geometry strip(uint32_t n)
{
    struct ng_geometry g = {.vertex_count = 2 * (n + 1), .index_count = 6 * n};
    g.positions = calloc(g.vertex_count, 3 * sizeof(float));
    g.indices = calloc(g.index_count, sizeof(uint32_t));
    assert_true(g.positions && g.indices);
    for (uint32_t i = 0; i < g.vertex_count; i++) {
        uint32_t column = i / 2;
        g.positions[i * 3] = (float)column;
        g.positions[i * 3 + 1] = (float)(i % 2);
    }
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t v = 2 * i, quad[6] = {v, v + 2, v + 1, v + 1, v + 2, v + 3};
        memcpy(g.indices + (size_t)i * 6, quad, sizeof quad);
    }
    g.normals = calloc(g.vertex_count, 3 * sizeof(float));
    assert_non_null(g.normals);
    for (uint32_t i = 0; i < g.vertex_count; i++)
        g.normals[i * 3 + 2] = 1;
    return g;
}

static ng_asset take(struct scene *s, struct ng_geometry *g)
{
    ng_asset id;
    OK(ng_geometry_complete(g));
    OK(ng_assets_take_geometry(s->assets, "strip", g, &id));
    return id;
}

static ng_entity add_piece(struct scene *s, const char *name, float x, float y, float z)
{
    ng_entity e = add_entity(s, name, x, y, z);
    OK(ng_world_add(s->world, e, NG_MESH,
                    &(struct ng_mesh){.geometry = s->box, .material = s->material, .visible = true}));
    return e;
}

static void open_scene(struct scene *s, uint32_t threads)
{
    *s = (struct scene){0};
    OK(ng_world_create(NULL, &s->world));
    OK(ng_components_register(s->world));
    OK(ng_assets_create(&s->assets));
    OK(ng_jobs_create(&(struct ng_jobs_params){.threads = threads}, &s->jobs));
    OK(ng_scene_systems_add(s->world, s->assets, s->jobs));
    OK(ng_extractor_create(&s->extractor));
    struct ng_geometry g = strip(1);
    s->box = take(s, &g);
    s->scale = ng_entity_create(s->world);
    OK(ng_world_add(s->world, s->scale, NG_SCENE_SCALE, &(struct ng_scene_scale){.radius = 10}));
    s->camera = add_entity(s, "front", 0, 0, 5);
    OK(ng_world_add(s->world, s->camera, NG_CAMERA, NULL));
    s->material = ng_entity_create(s->world);
    OK(ng_world_add(s->world, s->material, NG_MATERIAL, NULL));
}

static void close_scene(struct scene *s)
{
    ng_extractor_destroy(&s->extractor);
    ng_world_destroy(&s->world);
    ng_assets_destroy(&s->assets);
    ng_jobs_destroy(&s->jobs);
}

static const struct ng_snapshot *frame(struct scene *s, double time)
{
    const struct ng_snapshot *snapshot;
    OK(ng_world_run(s->world, time));
    struct ng_extract_params p = {.world = s->world, .assets = s->assets, .jobs = s->jobs, .time = time};
    OK(ng_extract(s->extractor, &p, &snapshot));
    return snapshot;
}

static const struct ng_snapshot_instance *instance_of(const struct ng_snapshot *s, ng_entity e)
{
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (ng_entity_same(s->instances[i].entity, e))
            return &s->instances[i];
    return NULL;
}

static uint32_t moved_count(const struct ng_snapshot *s)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->instance_count; i++)
        count += (s->instances[i].flags & NG_INSTANCE_MOVED) != 0;
    return count;
}

static void move(struct scene *s, ng_entity e, float x)
{
    struct ng_transform *t = ng_world_edit(s->world, e, NG_TRANSFORM);
    t->translation[0] = x;
}

// ---- what has changed ------------------------------------------------------------------------------------
static void test_a_still_scene_stays_the_same(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 2);
    for (int i = 0; i < 5; i++)
        add_piece(&s, "piece", (float)i, 0, 0);
    ng_entity lamp = add_entity(&s, "lamp", 0, 3, 0);
    OK(ng_world_add(s.world, lamp, NG_LIGHT_RECTANGLE, NULL));
    const struct ng_snapshot *n = frame(&s, 0);
    assert_int_equal(n->instance_count, 6);
    assert_int_equal(n->mesh_count, 2); // shared by the pieces; the emitter's
    assert_int_equal(moved_count(n), 6);
    uint64_t geometry = n->geometry_version, light = n->lights[0].version, versions[6];
    for (uint32_t i = 0; i < 6; i++)
        versions[i] = n->instances[i].version;
    for (int k = 1; k < 4; k++) {
        n = frame(&s, k);
        assert_int_equal(moved_count(n), 0);
        assert_true(n->geometry_version == geometry && n->lights[0].version == light);
        assert_int_equal(n->frame, k);
        for (uint32_t i = 0; i < 6; i++)
            assert_true(n->instances[i].version == versions[i]);
    }
    close_scene(&s);
}

// Small and black: what rays may pass, and what no version of surfaces follows.
static void test_lamps_are_small_and_reflect_nothing(void **state)
{
    (void)state;
    const struct ng_light_rectangle light = {
        .on = true, .color = {1, 1, 1}, .radiance = 1, .size = {0.5f, 0.5f}};
    struct scene s;
    open_scene(&s, 1);
    add_piece(&s, "piece", 0, 0, 0);
    ng_entity lamp = add_entity(&s, "lamp", 0, 3, 0);
    OK(ng_world_add(s.world, lamp, NG_LIGHT_RECTANGLE, &light));
    const struct ng_snapshot *n = frame(&s, 0);
    uint64_t surfaces = n->surface_version, geometry = n->geometry_version;
    assert_true(n->lights[0].lamp);
    assert_true(instance_of(n, lamp)->flags & NG_INSTANCE_LAMP);
    assert_false(n->instances[0].flags & NG_INSTANCE_LAMP);

    move(&s, lamp, 1);
    n = frame(&s, 1);
    assert_true(n->surface_version == surfaces && n->geometry_version > geometry);

    struct ng_light_rectangle *edited = ng_world_edit(s.world, lamp, NG_LIGHT_RECTANGLE);
    edited->albedo[1] = 0.1f;
    n = frame(&s, 2);
    assert_false(n->lights[0].lamp);
    assert_true(n->surface_version > surfaces);
    surfaces = n->surface_version;
    move(&s, lamp, 2); // an object now
    n = frame(&s, 3);
    assert_true(n->surface_version > surfaces);

    edited = ng_world_edit(s.world, lamp, NG_LIGHT_RECTANGLE);
    edited->albedo[1] = 0;
    assert_true(frame(&s, 4)->lights[0].lamp);
    edited = ng_world_edit(s.world, lamp, NG_LIGHT_RECTANGLE);
    edited->size[0] = 5;
    n = frame(&s, 5);
    assert_false(n->lights[0].lamp);
    surfaces = n->surface_version;
    struct ng_scene_scale *larger = ng_world_edit(s.world, s.scale, NG_SCENE_SCALE);
    larger->radius = 50; // the scene grows around it
    n = frame(&s, 6);
    assert_true(n->lights[0].lamp && n->surface_version > surfaces);
    surfaces = n->surface_version;
    OK(ng_entity_destroy(s.world, lamp));
    assert_true(frame(&s, 7)->surface_version > surfaces);
    close_scene(&s);
}

static void test_moving_one_piece_marks_that_one(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity pieces[8];
    for (int i = 0; i < 8; i++)
        pieces[i] = add_piece(&s, "piece", (float)i, 0, 0);
    uint64_t geometry = frame(&s, 0)->geometry_version;
    frame(&s, 1);
    move(&s, pieces[3], 30);
    const struct ng_snapshot *n = frame(&s, 2);
    assert_int_equal(moved_count(n), 1);
    assert_true(n->geometry_version > geometry);
    const struct ng_snapshot_instance *moved = instance_of(n, pieces[3]);
    assert_true(moved->flags & NG_INSTANCE_MOVED);
    assert_true(moved->matrix[3] == 30 && moved->previous_matrix[3] == 3);
    NEAR(moved->bounds_min[0], 30, 0);
    NEAR(moved->bounds_max[0], 31, 0);
    n = frame(&s, 3); // at rest again
    moved = instance_of(n, pieces[3]);
    assert_int_equal(moved_count(n), 0);
    assert_true(moved->previous_matrix[3] == 30);
    close_scene(&s);
}

static void test_still_extraction_has_no_motion(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity piece = add_piece(&s, "piece", 0, 0, 0);
    frame(&s, 0);
    move(&s, piece, 5);
    move(&s, s.camera, 5);
    OK(ng_world_run(s.world, 1));
    const struct ng_snapshot *n;
    struct ng_extract_params p = {.world = s.world, .assets = s.assets, .time = 1, .still = true};
    OK(ng_extract(s.extractor, &p, &n));
    assert_true(n->instances[0].previous_matrix[3] == 5);
    assert_true(n->instances[0].flags & NG_INSTANCE_MOVED); // it did change: caches must know
    assert_memory_equal(n->camera.view, n->camera.previous_view, sizeof n->camera.view);
    close_scene(&s);
}

static void test_pieces_come_and_go(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity a = add_piece(&s, "a", 0, 0, 0), b = add_piece(&s, "b", 1, 0, 0);
    frame(&s, 0);
    ng_entity c = add_piece(&s, "c", 2, 0, 0);
    const struct ng_snapshot *n = frame(&s, 1);
    assert_int_equal(n->instance_count, 3);
    assert_int_equal(moved_count(n), 1);
    assert_true(instance_of(n, c)->flags & NG_INSTANCE_MOVED);
    uint64_t geometry = n->geometry_version;
    OK(ng_entity_destroy(s.world, a)); // nothing but a count tells this
    n = frame(&s, 2);
    assert_int_equal(n->instance_count, 2);
    assert_true(n->geometry_version > geometry);
    assert_int_equal(moved_count(n), 0);
    ((struct ng_mesh *)ng_world_edit(s.world, b, NG_MESH))->visible = false;
    n = frame(&s, 3);
    assert_int_equal(n->instance_count, 1);
    assert_null(instance_of(n, b));
    OK(ng_world_remove(s.world, c, NG_TRANSFORM)); // back to the origin
    n = frame(&s, 4);
    assert_true(instance_of(n, c)->matrix[3] == 0);
    assert_int_equal(moved_count(n), 1);
    close_scene(&s);
}

static void test_material_edits_mark_their_pieces(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity a = add_piece(&s, "a", 0, 0, 0), b = add_piece(&s, "b", 1, 0, 0);
    ng_entity other = ng_entity_create(s.world);
    OK(ng_world_add(s.world, other, NG_MATERIAL, NULL));
    ((struct ng_mesh *)ng_world_edit(s.world, b, NG_MESH))->material = other;
    frame(&s, 0);
    struct ng_material *m = ng_world_edit(s.world, other, NG_MATERIAL);
    m->roughness = 0.123f;
    m->double_sided = true;
    const struct ng_snapshot *n = frame(&s, 1);
    assert_int_equal(moved_count(n), 1);
    const struct ng_snapshot_instance *i = instance_of(n, b);
    assert_true(i->flags & NG_INSTANCE_MOVED && i->flags & NG_INSTANCE_DOUBLE_SIDED);
    NEAR(n->materials[i->material].roughness, 0.123f, 0);
    assert_true(ng_entity_same(n->materials[instance_of(n, a)->material].entity, s.material));
    // A NaN that stays is no change.
    ((struct ng_material *)ng_world_edit(s.world, other, NG_MATERIAL))->metallic = NAN;
    frame(&s, 2);
    ng_world_edit(s.world, other, NG_MATERIAL);
    assert_int_equal(moved_count(frame(&s, 3)), 0);
    ((struct ng_material *)ng_world_edit(s.world, other, NG_MATERIAL))->metallic = 0;
    frame(&s, 4);
    // What shines differently does not reflect differently.
    ((struct ng_material *)ng_world_edit(s.world, other, NG_MATERIAL))->emissive[0] = 1;
    n = frame(&s, 5);
    assert_int_equal(moved_count(n), 0);
    assert_true(n->materials[instance_of(n, b)->material].emission[0] > 0);
    close_scene(&s);
}

// A mesh keeps the name of its material, whatever becomes of that.
static void test_materials_that_come_and_go_mark_their_pieces(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    const uint32_t looks = NG_INSTANCE_DOUBLE_SIDED | NG_INSTANCE_MASKED;
    ng_entity a = add_piece(&s, "a", 0, 0, 0);
    struct ng_material *m = ng_world_edit(s.world, s.material, NG_MATERIAL), kept;
    m->alpha_mode = NG_ALPHA_MASK;
    m->double_sided = true;
    kept = *m;
    assert_int_equal(instance_of(frame(&s, 0), a)->flags & looks, looks);
    OK(ng_world_remove(s.world, s.material, NG_MATERIAL));
    const struct ng_snapshot *n = frame(&s, 1);
    assert_int_equal(instance_of(n, a)->flags, NG_INSTANCE_MOVED);
    assert_int_equal(moved_count(frame(&s, 2)), 0);
    OK(ng_world_add(s.world, s.material, NG_MATERIAL, &kept));
    assert_int_equal(instance_of(frame(&s, 3), a)->flags, looks | NG_INSTANCE_MOVED);
    OK(ng_world_remove(s.world, s.material, NG_MATERIAL)); // unseen
    OK(ng_world_add(s.world, s.material, NG_MATERIAL, &kept));
    assert_int_equal(moved_count(frame(&s, 4)), 0);
    OK(ng_entity_destroy(s.world, s.material));
    assert_int_equal(instance_of(frame(&s, 5), a)->flags, NG_INSTANCE_MOVED);
    close_scene(&s);
}

static ng_asset add_image(struct scene *s)
{
    struct ng_image image = {.width = 1, .height = 1, .levels = 1, .pixels = calloc(1, 4), .size = 4};
    ng_asset id;
    assert_non_null(image.pixels);
    OK(ng_assets_take_image(s->assets, "texel", &image, &id));
    return id;
}

// Both images are the first of the snapshot's list, one after the other.
static void test_textures_are_told_apart(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity a = add_piece(&s, "a", 0, 0, 0);
    struct ng_material *m = ng_world_edit(s.world, s.material, NG_MATERIAL);
    ng_asset first = add_image(&s), second = add_image(&s);
    m->base_color_texture = first;
    m->emissive_texture = first;
    uint64_t emission = frame(&s, 0)->emission_version;
    m = ng_world_edit(s.world, s.material, NG_MATERIAL);
    m->emissive_texture = second;
    const struct ng_snapshot *n = frame(&s, 1);
    assert_true(n->emission_version > emission);
    assert_int_equal(moved_count(n), 0);
    emission = n->emission_version;
    assert_true(ng_assets_remove(s.assets, first)); // which a material still names
    n = frame(&s, 2);
    assert_true(n->emission_version == emission);
    assert_int_equal(n->materials[instance_of(n, a)->material].textures[NG_TEXTURE_BASE_COLOR].image,
                     NG_NONE);
    assert_int_equal(moved_count(n), 1);
    assert_int_equal(moved_count(frame(&s, 3)), 0);
    assert_true(ng_assets_remove(s.assets, second));
    assert_true(frame(&s, 4)->emission_version > emission);
    // What emits nothing does so at any strength.
    emission = frame(&s, 5)->emission_version;
    ((struct ng_material *)ng_world_edit(s.world, s.material, NG_MATERIAL))->emissive_strength = 7;
    assert_true(frame(&s, 6)->emission_version == emission);
    close_scene(&s);
}

static void test_mirrored_placement_is_flagged(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity piece = add_piece(&s, "piece", 0, 0, 0);
    assert_false(frame(&s, 0)->instances[0].flags & NG_INSTANCE_MIRRORED);
    ((struct ng_transform *)ng_world_edit(s.world, piece, NG_TRANSFORM))->scale[1] = -1;
    assert_true(frame(&s, 1)->instances[0].flags & NG_INSTANCE_MIRRORED);
    close_scene(&s);
}

static void test_a_removed_asset_takes_its_pieces_along(void **state)
{
    (void)state;
    struct scene s;
    struct test_log log;
    open_scene(&s, 1);
    add_piece(&s, "ghost", 0, 0, 0);
    assert_int_equal(frame(&s, 0)->instance_count, 1);
    assert_true(ng_assets_remove(s.assets, s.box));
    test_log_begin(&log);
    assert_int_equal(frame(&s, 1)->instance_count, 0);
    frame(&s, 2);
    test_log_end(&log);
    assert_int_equal(log.warnings, 1);
    assert_non_null(strstr(log.text, "ghost"));
    close_scene(&s);
}

// ---- animation, skinning, subdivision --------------------------------------------------------------------
// A clip that moves an entity along x, one metre a second, for two seconds.
static void animate_x(struct scene *s, ng_entity target)
{
    const float times[2] = {0, 2}, values[6] = {0, 0, 0, 2, 0, 0};
    struct ng_channel channel = {.target = target,
                                 .component = NG_TRANSFORM,
                                 .field_offset = offsetof(struct ng_transform, translation),
                                 .width = 3,
                                 .interpolation = NG_INTERPOLATION_LINEAR,
                                 .key_count = 2,
                                 .times = copy_of(times, sizeof times),
                                 .values = copy_of(values, sizeof values)};
    struct ng_clip clip = {.channel_count = 1, .channels = copy_of(&channel, sizeof channel), .duration = 2};
    ng_asset id;
    OK(ng_assets_take_clip(s->assets, "x", &clip, &id));
    ng_entity player = ng_entity_create(s->world);
    OK(ng_world_add(s->world, player, NG_ANIMATION,
                    &(struct ng_animation){.clip = id, .weight = 1, .speed = 1, .playing = true}));
}

static void test_animation_moves_and_rests(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 2);
    ng_entity a = add_piece(&s, "a", 7, 0, 0);
    add_piece(&s, "b", 9, 0, 0);
    animate_x(&s, a);
    frame(&s, 0.5);
    const struct ng_snapshot *n = frame(&s, 1);
    assert_int_equal(moved_count(n), 1);
    NEAR(instance_of(n, a)->matrix[3], 1, 1e-6);
    NEAR(instance_of(n, a)->previous_matrix[3], 0.5, 1e-6);
    frame(&s, 2);
    assert_int_equal(moved_count(frame(&s, 3)), 0); // past the end, nothing moves any more
    close_scene(&s);
}

enum { JOINTS = 3, QUADS = 40 };

// A strip whose left, middle and right follow three joints.
static ng_entity add_character(struct scene *s, ng_entity joints[JOINTS])
{
    struct ng_geometry g = strip(QUADS);
    g.joints = calloc(g.vertex_count, 4 * sizeof(uint16_t));
    g.weights = calloc(g.vertex_count, 4 * sizeof(float));
    assert_true(g.joints && g.weights);
    for (uint32_t i = 0; i < g.vertex_count; i++) {
        float t = g.positions[i * 3] / QUADS * 2, low = fminf(floorf(t), 1);
        g.joints[i * 4] = (uint16_t)low;
        g.joints[i * 4 + 1] = (uint16_t)(low + 1);
        g.weights[i * 4] = 1 - (t - low);
        g.weights[i * 4 + 1] = t - low;
    }
    ng_asset geometry = take(s, &g);
    float inverse_bind[JOINTS][16] = {{0}};
    for (int j = 0; j < JOINTS; j++) {
        joints[j] = add_entity(s, "joint", (float)j, 0, 0);
        for (int i = 0; i < 4; i++)
            inverse_bind[j][i * 5] = 1;
        inverse_bind[j][12] = -(float)j;
    }
    struct ng_skeleton skeleton = {.joint_count = JOINTS,
                                   .joints = copy_of(joints, JOINTS * sizeof joints[0]),
                                   .inverse_bind = copy_of(inverse_bind, sizeof inverse_bind)};
    ng_asset skin;
    OK(ng_assets_take_skeleton(s->assets, "skeleton", &skeleton, &skin));
    ng_entity e = add_entity(s, "character", 100, 0, 0); // its own placement does not count
    OK(ng_world_add(s->world, e, NG_MESH,
                    &(struct ng_mesh){.geometry = geometry, .material = s->material, .visible = true}));
    OK(ng_world_add(s->world, e, NG_SKIN, &(struct ng_skin){.skin = skin}));
    return e;
}

static const struct ng_snapshot_mesh *mesh_of(const struct ng_snapshot *n, ng_entity e)
{
    return &n->meshes[instance_of(n, e)->mesh];
}

static void test_skinned_positions(void **state)
{
    (void)state;
    struct scene s;
    ng_entity joints[JOINTS];
    open_scene(&s, 2);
    ng_entity e = add_character(&s, joints);
    const struct ng_snapshot *n = frame(&s, 0);
    const struct ng_snapshot_mesh *m = mesh_of(n, e);
    assert_true(m->dynamic);
    assert_null(m->previous_positions);
    for (uint32_t i = 0; i < m->vertex_count; i++) { // joints at rest: as it was made
        uint32_t column = i / 2;
        NEAR(m->positions[i * 3], column, 1e-5);
    }
    uint64_t key = m->key, revision = m->revision;
    static float before[2 * (QUADS + 1) * 3];
    memcpy(before, m->positions, sizeof before);

    move(&s, joints[1], 5); // 4 to the right
    n = frame(&s, 1);
    m = mesh_of(n, e);
    assert_true(m->key == key && m->revision > revision);
    assert_memory_equal(m->previous_positions, before, sizeof before);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        uint32_t column = i / 2;
        float x = (float)column, weight = 1 - fabsf(x / QUADS * 2 - 1);
        NEAR(m->positions[i * 3], x + 4 * weight, 1e-4);
    }
    const struct ng_snapshot_instance *instance = instance_of(n, e);
    assert_true(instance->matrix[0] == 1 && instance->matrix[3] == 0);
    assert_true(instance->flags & NG_INSTANCE_MOVED);
    NEAR(instance->bounds_max[0], QUADS, 1e-4);

    revision = m->revision;
    n = frame(&s, 2); // at rest
    m = mesh_of(n, e);
    assert_true(m->revision == revision && !m->previous_positions);
    assert_int_equal(moved_count(n), 0);
    add_piece(&s, "another", 0, 0, 0); // a new list keeps the skin's buffers
    n = frame(&s, 3);
    assert_true(mesh_of(n, e)->revision == revision && mesh_of(n, e)->key == key);
    assert_int_equal(moved_count(n), 1);
    OK(ng_world_remove(s.world, e, NG_SKIN)); // now it is a rigid mesh at its own placement
    n = frame(&s, 4);
    assert_false(mesh_of(n, e)->dynamic);
    assert_true(instance_of(n, e)->matrix[3] == 100);
    close_scene(&s);
}

// Two targets of a geometry: one lifts the upper edge, the other, of a single vertex, turns its normal.
static void add_targets(struct ng_geometry *g)
{
    uint32_t n = g->vertex_count;
    g->target_count = 2;
    g->delta_count = n / 2 + 1;
    g->target_ends = copy_of((const uint32_t[]){n / 2, n / 2 + 1}, 2 * sizeof(uint32_t));
    g->delta_vertices = calloc(g->delta_count, sizeof(uint32_t));
    g->delta_positions = calloc(g->delta_count, 3 * sizeof(float));
    g->delta_normals = calloc(g->delta_count, 3 * sizeof(float));
    assert_true(g->delta_vertices && g->delta_positions && g->delta_normals);
    for (uint32_t i = 0; i < n / 2; i++) {
        g->delta_vertices[i] = 2 * i + 1;
        g->delta_positions[i * 3 + 1] = 2;
    }
    g->delta_normals[n / 2 * 3] = 1; // of vertex 0
}

static void test_morphed_positions(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 2);
    struct ng_geometry g = strip(QUADS);
    add_targets(&g);
    ng_asset geometry = take(&s, &g);
    ng_entity e = add_entity(&s, "face", 3, 0, 0);
    OK(ng_world_add(s.world, e, NG_MESH,
                    &(struct ng_mesh){.geometry = geometry, .material = s.material, .visible = true}));
    const struct ng_snapshot *n = frame(&s, 0); // without weights: as it was made
    const struct ng_geometry *made = ng_assets_geometry(s.assets, geometry);
    assert_memory_equal(mesh_of(n, e)->positions, made->positions, made->vertex_count * 12);
    assert_memory_equal(mesh_of(n, e)->normals, made->normals, made->vertex_count * 12);
    uint64_t key = mesh_of(n, e)->key;
    OK(ng_world_add(s.world, e, NG_MORPH, &(struct ng_morph){{0.5f, 1}}));
    n = frame(&s, 1);
    const struct ng_snapshot_mesh *m = mesh_of(n, e);
    assert_true(m->key == key && m->dynamic && m->previous_positions);
    for (size_t i = 0; i < m->vertex_count; i++)
        NEAR(m->positions[i * 3 + 1], i % 2 ? 2 : 0, 1e-6);
    NEAR(m->normals[0], sqrtf(0.5f), 1e-6);
    NEAR(m->normals[2], sqrtf(0.5f), 1e-6);
    NEAR(m->normals[3], 0, 0); // the others are as they were
    NEAR(instance_of(n, e)->bounds_max[1], 2, 1e-6);
    NEAR(instance_of(n, e)->bounds_min[0], 3, 1e-6); // where it stands
    move(&s, e, 7);
    n = frame(&s, 2);
    NEAR(instance_of(n, e)->matrix[3], 7, 1e-6);
    assert_null(mesh_of(n, e)->previous_positions); // it moved, its vertices did not
    struct ng_morph *morph = ng_world_edit(s.world, e, NG_MORPH);
    morph->weights[NG_MORPH_TARGETS - 1] = 3; // of no target
    assert_int_equal(moved_count(frame(&s, 3)), 0);
    OK(ng_world_remove(s.world, e, NG_MORPH));
    assert_memory_equal(mesh_of(frame(&s, 4), e)->positions, made->positions, made->vertex_count * 12);
    close_scene(&s);
}

// Targets come first, then joints move what they have made.
static void test_morphed_and_skinned(void **state)
{
    (void)state;
    struct scene s;
    ng_entity joints[JOINTS];
    open_scene(&s, 2);
    ng_entity e = add_character(&s, joints);
    struct ng_mesh *mesh = ng_world_edit(s.world, e, NG_MESH);
    struct ng_geometry g = *ng_assets_geometry(s.assets, mesh->geometry), with = strip(QUADS);
    with.joints = copy_of(g.joints, g.vertex_count * 8);
    with.weights = copy_of(g.weights, g.vertex_count * 16);
    add_targets(&with);
    mesh->geometry = take(&s, &with);
    OK(ng_world_add(s.world, e, NG_MORPH, &(struct ng_morph){{1}}));
    for (int j = 0; j < JOINTS; j++) { // a quarter turn about x: up becomes forward
        struct ng_transform *t = ng_world_edit(s.world, joints[j], NG_TRANSFORM);
        t->rotation[0] = t->rotation[3] = sqrtf(0.5f);
    }
    const struct ng_snapshot *n = frame(&s, 0);
    const struct ng_snapshot_mesh *m = mesh_of(n, e);
    for (size_t i = 0; i < m->vertex_count; i++) {
        NEAR(m->positions[i * 3 + 1], 0, 1e-5);
        NEAR(m->positions[i * 3 + 2], i % 2 ? 3 : 0, 1e-5);
    }
    NEAR(m->normals[1], -1, 1e-5);
    assert_true(instance_of(n, e)->matrix[3] == 0); // joints say where it is
    OK(ng_world_add(s.world, e, NG_SUBDIVISION, &(struct ng_subdivision){.level = 2})); // the same of a cage
    float high[2];
    for (int i = 0; i < 2; i++) {
        ((struct ng_morph *)ng_world_edit(s.world, e, NG_MORPH))->weights[0] = (float)i;
        n = frame(&s, 1 + i);
        NEAR(instance_of(n, e)->bounds_max[1], 0, 1e-5);
        high[i] = instance_of(n, e)->bounds_max[2];
    }
    assert_true(high[0] > 0.1f);
    NEAR(high[1], 3 * high[0], 1e-5);
    close_scene(&s);
}

// A cage is refined from where its targets, and then its joints, have put it.
static void test_morphed_cage(void **state)
{
    (void)state;
    struct scene s;
    struct test_log log;
    open_scene(&s, 2);
    struct ng_geometry g = strip(QUADS);
    add_targets(&g);
    ng_asset geometry = take(&s, &g);
    ng_entity e = add_entity(&s, "face", 0, 0, 0);
    OK(ng_world_add(s.world, e, NG_MESH,
                    &(struct ng_mesh){.geometry = geometry, .material = s.material, .visible = true}));
    OK(ng_world_add(s.world, e, NG_SUBDIVISION, &(struct ng_subdivision){.level = 2}));
    test_log_begin(&log);
    const struct ng_snapshot_mesh *m = mesh_of(frame(&s, 0), e);
    size_t count = m->vertex_count;
    float *rest = copy_of(m->positions, count * 12);
    const float top = instance_of(frame(&s, 1), e)->bounds_max[1];
    OK(ng_world_add(s.world, e, NG_MORPH, &(struct ng_morph){{0.5f, 1}}));
    m = mesh_of(frame(&s, 2), e);
    test_log_end(&log);
    assert_int_equal(log.warnings, 0);
    assert_int_equal(m->vertex_count, count);
    for (size_t i = 0; i < count; i++) { // stretched along y: the surface follows its cage
        NEAR(m->positions[i * 3], rest[i * 3], 1e-5);
        NEAR(m->positions[i * 3 + 1], 2 * rest[i * 3 + 1], 1e-5);
    }
    NEAR(instance_of(frame(&s, 3), e)->bounds_max[1], 2 * top, 1e-5);
    struct ng_morph *morph = ng_world_edit(s.world, e, NG_MORPH);
    morph->weights[0] = morph->weights[1] = 0;
    assert_memory_equal(mesh_of(frame(&s, 4), e)->positions, rest, count * 12);
    free(rest);
    close_scene(&s);
}

static void test_unusable_skin_warns_once(void **state)
{
    (void)state;
    struct scene s;
    struct test_log log;
    open_scene(&s, 1);
    ng_entity e = add_piece(&s, "stiff", 0, 0, 0);
    OK(ng_world_add(s.world, e, NG_SKIN, &(struct ng_skin){{77}}));
    test_log_begin(&log);
    frame(&s, 0);
    add_piece(&s, "another", 0, 0, 0);
    assert_false(mesh_of(frame(&s, 1), e)->dynamic);
    test_log_end(&log);
    assert_int_equal(log.warnings, 1);
    close_scene(&s);
}

static void test_subdivided_pieces_share_one_shape(void **state)
{
    (void)state;
    struct scene s;
    ng_entity joints[JOINTS];
    open_scene(&s, 2);
    ng_entity a = add_piece(&s, "a", 0, 0, 0), b = add_piece(&s, "b", 3, 0, 0),
              c = add_piece(&s, "c", 6, 0, 0);
    OK(ng_world_add(s.world, a, NG_SUBDIVISION, &(struct ng_subdivision){.level = 2}));
    OK(ng_world_add(s.world, b, NG_SUBDIVISION, &(struct ng_subdivision){.level = 2}));
    const struct ng_snapshot *n = frame(&s, 0);
    assert_int_equal(n->mesh_count, 2);
    assert_true(mesh_of(n, a) == mesh_of(n, b) && mesh_of(n, a) != mesh_of(n, c));
    assert_true(mesh_of(n, a)->index_count > mesh_of(n, c)->index_count);
    uint64_t key = mesh_of(n, a)->key;
    ((struct ng_subdivision *)ng_world_edit(s.world, b, NG_SUBDIVISION))->level = 3;
    n = frame(&s, 1);
    assert_true(mesh_of(n, a)->key == key && mesh_of(n, b)->key != key);
    assert_int_equal(moved_count(n), 1);
    // A skinned cage, made from triangles, has no joints: refused with a warning, not drawn wrong.
    struct test_log log;
    ng_entity e = add_character(&s, joints);
    OK(ng_world_add(s.world, e, NG_SUBDIVISION, &(struct ng_subdivision){.level = 1}));
    test_log_begin(&log);
    n = frame(&s, 2);
    test_log_end(&log);
    if (log.warnings) {
        assert_false(mesh_of(n, e)->dynamic);
    } else { // it kept its vertex map: it moves with its joints
        assert_true(mesh_of(n, e)->dynamic);
        float right = mesh_of(n, e)->bounds_max[0];
        for (int j = 0; j < JOINTS; j++)
            move(&s, joints[j], (float)j + 2);
        n = frame(&s, 3);
        NEAR(mesh_of(n, e)->bounds_max[0], right + 2, 1e-4);
    }
    close_scene(&s);
}

// ---- lights ----------------------------------------------------------------------------------------------
static void test_emitters_are_visible(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity rectangle = add_entity(&s, "ceiling", 1, 2, 3), disk = add_entity(&s, "disk", 0, 0, 0);
    ng_entity sphere = add_entity(&s, "ball", 0, 5, 0), point = add_entity(&s, "bulb", 0, 0, 0);
    OK(ng_world_add(
        s.world, rectangle, NG_LIGHT_RECTANGLE,
        &(struct ng_light_rectangle){
            .on = true, .color = {1, 0.5f, 0}, .radiance = 4, .size = {2, 3}, .albedo = {0.8f, 0.7f, 0.6f}}));
    OK(ng_world_add(s.world, disk, NG_LIGHT_DISK,
                    &(struct ng_light_disk){.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 2}));
    OK(ng_world_add(
        s.world, sphere, NG_LIGHT_SPHERE,
        &(struct ng_light_sphere){.on = true, .color = {1, 1, 1}, .radiance = 1, .radius = 0.5f}));
    OK(ng_world_add(s.world, point, NG_LIGHT_POINT, NULL));
    const struct ng_snapshot *n = frame(&s, 0);
    assert_int_equal(n->light_count, 4);
    assert_int_equal(n->instance_count, 3);
    const struct ng_snapshot_instance *i = instance_of(n, rectangle);
    NEAR(i->bounds_min[0], 0, 1e-6);
    NEAR(i->bounds_max[1], 3.5, 1e-6);
    assert_true(ng_entity_same(n->lights[i->light].entity, rectangle));
    assert_string_equal(n->lights[i->light].name, "ceiling");
    const struct ng_snapshot_material *m = &n->materials[i->material];
    NEAR(m->emission[0], 4, 1e-6);
    NEAR(m->emission[1], 2, 1e-6);
    NEAR(m->base_color[2], 0.6f, 1e-6);
    assert_false(m->double_sided);
    NEAR(instance_of(n, disk)->bounds_max[0], 2, 1e-4);
    NEAR(instance_of(n, sphere)->bounds_max[1], 5.5, 1e-4);
    assert_null(instance_of(n, point));
    // The shapes' triangles wind the way their normals point.
    for (uint32_t k = 0; k < n->mesh_count; k++) {
        const struct ng_snapshot_mesh *mesh = &n->meshes[k];
        for (uint32_t t = 0; t + 2 < mesh->index_count; t += 3) {
            const float *p[3], *normal = mesh->normals + (size_t)mesh->indices[t] * 3;
            float a[3], b[3];
            for (int v = 0; v < 3; v++)
                p[v] = mesh->positions + (size_t)mesh->indices[t + (uint32_t)v] * 3;
            for (int c = 0; c < 3; c++) {
                a[c] = p[1][c] - p[0][c];
                b[c] = p[2][c] - p[0][c];
            }
            float facing = (a[1] * b[2] - a[2] * b[1]) * normal[0] + (a[2] * b[0] - a[0] * b[2]) * normal[1] +
                           (a[0] * b[1] - a[1] * b[0]) * normal[2];
            assert_true(facing > -1e-7f);
        }
    }
    close_scene(&s);
}

static void test_light_versions(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity a = add_entity(&s, "a", 0, 0, 0), b = add_entity(&s, "b", 0, 0, 0);
    OK(ng_world_add(s.world, a, NG_LIGHT_POINT, NULL));
    OK(ng_world_add(s.world, b, NG_LIGHT_RECTANGLE, NULL));
    const struct ng_snapshot *n = frame(&s, 0);
    uint64_t va = n->lights[0].version, vb = n->lights[1].version;
    float power = n->lights[0].power;
    ((struct ng_light_point *)ng_world_edit(s.world, a, NG_LIGHT_POINT))->intensity *= 2;
    n = frame(&s, 1);
    assert_true(n->lights[0].version > va && n->lights[1].version == vb);
    assert_true(n->lights[0].unit_version == va); // brightness alone
    NEAR(n->lights[0].power, 2 * power, 1e-3 * (double)power);
    va = n->lights[0].version;
    move(&s, b, 4);
    n = frame(&s, 2);
    assert_true(n->lights[0].version == va && n->lights[1].version > vb);
    assert_true(n->lights[1].unit_version == n->lights[1].version);
    const struct ng_snapshot_instance *i = instance_of(n, b);
    assert_true(i->flags & NG_INSTANCE_MOVED && i->previous_matrix[3] == 0 && i->matrix[3] == 4);
    OK(ng_entity_destroy(s.world, a)); // the light that stays keeps its version and its history
    vb = n->lights[1].version;
    n = frame(&s, 3);
    assert_int_equal(n->light_count, 1);
    assert_true(n->lights[0].version == vb);
    assert_int_equal(n->instances[0].light, 0);
    assert_int_equal(moved_count(n), 0);
    close_scene(&s);
}

static void test_mesh_light(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity lamp = add_piece(&s, "lamp", 2, 0, 0);
    struct ng_material *m = ng_world_edit(s.world, s.material, NG_MATERIAL);
    m->emissive[0] = m->emissive[1] = m->emissive[2] = 1;
    m->emissive_strength = 3;
    OK(ng_world_add(s.world, lamp, NG_LIGHT_MESH,
                    &(struct ng_light_mesh){.on = true, .color = {1, 0, 0}, .scale = 2}));
    const struct ng_snapshot *n = frame(&s, 0);
    assert_int_equal(n->light_count, 1);
    NEAR(n->lights[0].power, 3.14159265 * 6 / 3, 1e-4); // a unit square, red only
    const struct ng_snapshot_instance *i = instance_of(n, lamp);
    assert_int_equal(i->light, 0);
    NEAR(n->materials[i->material].emission[0], 6, 1e-5);
    assert_true(n->materials[i->material].emission[1] == 0);
    struct ng_light_sample sample;
    ng_light_sample_at(&n->lights[0].source, (float[2]){0.3f, 0.6f}, &sample);
    assert_true(sample.position[0] >= 2 && sample.position[0] <= 3 && sample.normal[2] == 1);
    uint64_t version = n->lights[0].version;
    struct ng_transform *t = ng_world_edit(s.world, lamp, NG_TRANSFORM);
    t->scale[0] = -2; // mirrored and twice as large: it still shines the way its front faces
    n = frame(&s, 1);
    assert_true(n->lights[0].version > version);
    NEAR(n->lights[0].power, 2 * 3.14159265 * 6 / 3, 1e-4);
    ng_light_sample_at(&n->lights[0].source, (float[2]){0.3f, 0.6f}, &sample);
    assert_true(sample.position[0] <= 2 && sample.position[0] >= 0 && sample.normal[2] == 1);
    close_scene(&s);
}

// A light of a material: all its meshes shine together, mirrored ones the way they face.
static void test_light_of_a_material(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity a = add_piece(&s, "a", 2, 0, 0), b = add_piece(&s, "b", -4, 0, 0),
              own = add_piece(&s, "own", 6, 0, 0);
    struct ng_material *m = ng_world_edit(s.world, s.material, NG_MATERIAL);
    m->emissive[0] = m->emissive[1] = m->emissive[2] = 1;
    ((struct ng_transform *)ng_world_edit(s.world, b, NG_TRANSFORM))->scale[0] = -2;
    OK(ng_world_add(s.world, s.material, NG_LIGHT_MESH, NULL));
    OK(ng_world_add(s.world, own, NG_LIGHT_MESH, NULL));
    const struct ng_snapshot *n = frame(&s, 0);
    const struct ng_snapshot_instance *ia = instance_of(n, a), *ib = instance_of(n, b);
    assert_int_equal(n->light_count, 2);
    assert_int_equal(ia->light, ib->light);
    assert_int_not_equal(ia->light, instance_of(n, own)->light);
    const struct ng_snapshot_light *light = &n->lights[ia->light];
    NEAR(light->power, 3 * 3.14159265, 1e-4); // one square, and one of twice its size
    assert_int_equal(light->source.triangle_count, 4);
    assert_int_equal(ia->light_triangle + ib->light_triangle, 2);
    uint32_t on_b = 0;
    for (int i = 0; i < 64; i++) {
        struct ng_light_sample sample;
        const int column = i % 8, row = i / 8;
        const float u[2] = {((float)column + 0.5f) / 8, ((float)row + 0.5f) / 8};
        ng_light_sample_at(&light->source, u, &sample);
        assert_true(sample.normal[2] == 1 && (sample.position[0] < 0 || sample.position[0] < 4));
        on_b += sample.position[0] < 0;
    }
    assert_true(on_b > 64 / 2 && on_b < 64); // two thirds

    // What others do does not matter to it; what its meshes do, does.
    uint64_t version = light->version;
    move(&s, own, 7);
    n = frame(&s, 1);
    assert_true(n->lights[instance_of(n, a)->light].version == version);
    ((struct ng_mesh *)ng_world_edit(s.world, a, NG_MESH))->visible = false;
    n = frame(&s, 2);
    light = &n->lights[instance_of(n, b)->light];
    assert_true(light->version > version);
    assert_int_equal(light->source.triangle_count, 2);
    assert_int_equal(instance_of(n, b)->light_triangle, 0);
    OK(ng_world_add(s.world, b, NG_LIGHT_MESH, NULL)); // a light of its own from here on
    n = frame(&s, 3);
    assert_int_equal(n->light_count, 3);
    NEAR(n->lights[instance_of(n, b)->light].power, 2 * 3.14159265, 1e-4);
    OK(ng_world_remove(s.world, b, NG_LIGHT_MESH));
    OK(ng_world_remove(s.world, s.material, NG_LIGHT_MESH));
    n = frame(&s, 4);
    assert_int_equal(instance_of(n, b)->light, NG_NONE);
    close_scene(&s);
}

// Emission of a lamp's material as the snapshot shows it.
static void assert_emission(struct scene *s, double time, ng_entity lamp, float red, float green)
{
    const struct ng_snapshot *n = frame(s, time);
    const struct ng_snapshot_material *m = &n->materials[instance_of(n, lamp)->material];
    NEAR(m->emission[0], red, 1e-5);
    NEAR(m->emission[1], green, 1e-5);
}

// However often the materials are written again, what is seen is what the light gives.
static void test_mesh_light_shows_its_radiance(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity lamp = add_piece(&s, "lamp", 0, 0, 0), other = ng_entity_create(s.world);
    struct ng_material *m = ng_world_edit(s.world, s.material, NG_MATERIAL);
    m->emissive[0] = m->emissive[1] = 1;
    m->emissive_strength = 3;
    OK(ng_world_add(s.world, other, NG_MATERIAL, NULL));
    OK(ng_world_add(s.world, lamp, NG_LIGHT_MESH,
                    &(struct ng_light_mesh){.on = true, .color = {1, 0.5f, 0}, .scale = 2}));
    assert_emission(&s, 0, lamp, 6, 3);
    uint64_t version = frame(&s, 1)->lights[0].version;
    ((struct ng_material *)ng_world_edit(s.world, other, NG_MATERIAL))->roughness = 0.3f;
    assert_emission(&s, 2, lamp, 6, 3);
    assert_true(frame(&s, 3)->lights[0].version == version);
    // The rest of its material is the scene's, also while the light itself stays the same.
    ((struct ng_material *)ng_world_edit(s.world, s.material, NG_MATERIAL))->roughness = 0.4f;
    assert_emission(&s, 4, lamp, 6, 3);
    const struct ng_snapshot *n = frame(&s, 5);
    NEAR(n->materials[instance_of(n, lamp)->material].roughness, 0.4f, 0);
    ((struct ng_light_mesh *)ng_world_edit(s.world, lamp, NG_LIGHT_MESH))->on = false;
    assert_emission(&s, 6, lamp, 0, 0);
    ((struct ng_material *)ng_world_edit(s.world, other, NG_MATERIAL))->roughness = 0.5f;
    assert_emission(&s, 7, lamp, 0, 0);
    close_scene(&s);
}

static void test_warnings_come_once(void **state)
{
    (void)state;
    struct scene s;
    struct test_log log;
    open_scene(&s, 1);
    ng_entity glow = add_piece(&s, "glow", 0, 0, 0), ball = add_entity(&s, "egg", 0, 0, 0);
    struct ng_material *m = ng_world_edit(s.world, s.material, NG_MATERIAL);
    m->emissive[0] = m->emissive_strength = 1;
    OK(ng_world_add(s.world, ball, NG_LIGHT_SPHERE, NULL));
    ((struct ng_transform *)ng_world_edit(s.world, ball, NG_TRANSFORM))->scale[1] = 2;
    ng_entity second = add_entity(&s, "side", 0, 0, 0);
    OK(ng_world_add(s.world, second, NG_CAMERA, NULL));
    test_log_begin(&log);
    for (int i = 0; i < 3; i++) {
        move(&s, glow, (float)i);
        move(&s, ball, (float)i);
        add_piece(&s, "more", 0, 0, 0); // new lists must not warn again
        ((struct ng_mesh *)ng_world_edit(s.world, glow, NG_MESH))->visible = true;
        frame(&s, i);
        for (uint32_t k = 0; i == 0 && k < 3; k++)
            assert_non_null(
                strstr(log.text, (const char *[]){"'glow' emits", "'egg' has a scale", "'front'"}[k]));
    }
    test_log_end(&log);
    assert_int_equal(log.warnings, 3 + 3); // and one for each of the pieces that were added: they glow too
    close_scene(&s);
}

static void test_environment(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    assert_int_equal(frame(&s, 0)->environment, NG_NONE);
    const float texels[8] = {1, 2, 3, 1, 1, 2, 3, 1};
    struct ng_image image = {
        .width = 2, .height = 1, .levels = 1, .format = NG_PIXEL_RGBA32F, .size = sizeof texels};
    image.pixels = copy_of(texels, sizeof texels);
    ng_asset map;
    OK(ng_assets_take_image(s.assets, "sky", &image, &map));
    ng_entity sky = add_entity(&s, "sky", 0, 0, 0);
    OK(ng_world_add(
        s.world, sky, NG_LIGHT_ENVIRONMENT,
        &(struct ng_light_environment){.on = true, .color = {1, 1, 1}, .intensity = 1, .map = map}));
    const struct ng_snapshot *n = frame(&s, 1);
    assert_int_equal(n->environment, 0);
    assert_int_equal(n->image_count, 1);
    assert_int_equal(n->lights[0].image, 0);
    NEAR(n->lights[0].power, 3.14159265 * 100 * 4 * 3.14159265 * 2, 1);
    close_scene(&s);
}

// ---- camera ----------------------------------------------------------------------------------------------
// Sees what one in the world would, and moves like one; from one to the other is a cut.
static void test_free_camera(void **state)
{
    (void)state;
    struct scene s;
    const struct ng_snapshot *n;
    open_scene(&s, 1);
    const struct ng_transform place = {{8, 1, -0.0f}, {0, 0.6f, 0, 0.8f}, {-1, 1, 1}};
    struct ng_camera lens = {
        .projection = NG_PROJECTION_ORTHOGRAPHIC, .height = 3, .near_plane = 0.5f, .exposure = 2};
    ng_entity side = add_entity(&s, "side", 0, 0, 0);
    OK(ng_world_set(s.world, side, NG_TRANSFORM, &place));
    OK(ng_world_add(s.world, side, NG_CAMERA, &lens));
    OK(ng_world_run(s.world, 0));
    struct ng_extract_params p = {.world = s.world, .assets = s.assets, .camera = "side"};
    OK(ng_extract(s.extractor, &p, &n));
    struct ng_snapshot_camera inside = n->camera;
    struct ng_free_camera camera = {lens, ng_placement_of(&place)};
    p.free_camera = &camera;
    OK(ng_extract(s.extractor, &p, &n));
    assert_true(ng_entity_is_null(n->camera.entity));
    inside.entity = n->camera.entity;
    assert_memory_equal(&n->camera, &inside, sizeof inside);
    camera.placement.matrix[12] = 9;
    OK(ng_extract(s.extractor, &p, &n));
    assert_memory_equal(n->camera.previous_view, inside.view, sizeof inside.view);
    assert_memory_not_equal(n->camera.view, inside.view, sizeof inside.view);
    p.free_camera = NULL;
    OK(ng_extract(s.extractor, &p, &n));
    assert_memory_equal(n->camera.view, n->camera.previous_view, sizeof n->camera.view);
    close_scene(&s);
}

static void test_cameras(void **state)
{
    (void)state;
    struct scene s;
    struct test_log log;
    open_scene(&s, 1);
    ng_entity side = add_entity(&s, "side", 8, 0, 0);
    OK(ng_world_add(s.world, side, NG_CAMERA, NULL));
    OK(ng_world_run(s.world, 0));
    const struct ng_snapshot *n;
    struct ng_extract_params p = {.world = s.world, .assets = s.assets, .camera = "side"};
    OK(ng_extract(s.extractor, &p, &n));
    assert_true(ng_entity_same(n->camera.entity, side));
    NEAR(n->camera.view[12], -8, 1e-6);
    move(&s, side, 9);
    OK(ng_world_run(s.world, 1));
    OK(ng_extract(s.extractor, &p, &n));
    NEAR(n->camera.view[12], -9, 1e-6);
    NEAR(n->camera.previous_view[12], -8, 1e-6);
    p.camera = "front"; // a cut is not a motion
    OK(ng_extract(s.extractor, &p, &n));
    assert_memory_equal(n->camera.view, n->camera.previous_view, sizeof n->camera.view);
    p.camera = "nobody";
    test_log_begin(&log);
    assert_int_equal(ng_extract(s.extractor, &p, &n), NG_ERROR_NOT_FOUND);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "nobody"));
    OK(ng_entity_destroy(s.world, side));
    OK(ng_entity_destroy(s.world, s.camera));
    p.camera = NULL;
    OK(ng_extract(s.extractor, &p, &n));
    assert_true(n->camera.position[2] > 10); // outside the scene's sphere, looking at it
    close_scene(&s);
}

// ---- determinism -----------------------------------------------------------------------------------------
static void test_threads_do_not_matter(void **state)
{
    (void)state;
    struct scene s[2];
    ng_entity joints[2][JOINTS], characters[2][4];
    for (uint32_t k = 0; k < 2; k++) {
        open_scene(&s[k], k ? 4 : 1);
        for (int i = 0; i < 4; i++)
            characters[k][i] = add_character(&s[k], joints[k]);
        for (int j = 0; j < JOINTS; j++)
            animate_x(&s[k], joints[k][j]);
        animate_x(&s[k], joints[k][1]); // two clips on one field
    }
    for (int f = 0; f < 4; f++) {
        const struct ng_snapshot *a = frame(&s[0], f * 0.3), *b = frame(&s[1], f * 0.3);
        assert_int_equal(a->instance_count, b->instance_count);
        for (int i = 0; i < 4; i++) {
            const struct ng_snapshot_mesh *x = mesh_of(a, characters[0][i]),
                                          *y = mesh_of(b, characters[1][i]);
            assert_memory_equal(x->positions, y->positions, x->vertex_count * 3 * sizeof(float));
            assert_memory_equal(x->normals, y->normals, x->vertex_count * 3 * sizeof(float));
        }
        // Each counts from a number of its own.
        for (uint32_t i = 0; i < a->instance_count; i++) {
            assert_true(a->instances[i].version - a->instances[0].version ==
                        b->instances[i].version - b->instances[0].version);
            assert_true(a->instances[i].version != b->instances[i].version);
        }
    }
    close_scene(&s[0]);
    close_scene(&s[1]);
}

// What nobody sees makes no light another: a texture's coordinates without the texture, that a light's
// material would be unlit, and all that an emitter without triangles says but how bright it would be.
static void test_dark_emitters_stay_as_they_are(void **state)
{
    (void)state;
    struct scene s;
    open_scene(&s, 1);
    ng_entity lamp = add_piece(&s, "lamp", 0, 0, 0);
    ((struct ng_material *)ng_world_edit(s.world, s.material, NG_MATERIAL))->emissive[0] = 1;
    OK(ng_world_add(s.world, lamp, NG_LIGHT_MESH, NULL));
    uint64_t version = frame(&s, 0)->lights[0].version;
    ((struct ng_material *)ng_world_edit(s.world, s.material, NG_MATERIAL))->emissive_uv_set = 1;
    assert_true(frame(&s, 1)->lights[0].version == version);
    ((struct ng_material *)ng_world_edit(s.world, s.material, NG_MATERIAL))->unlit =
        true; // but it is a light
    const struct ng_snapshot *n = frame(&s, 1.5);
    assert_true(n->lights[0].version == version && moved_count(n) == 0);
    ((struct ng_material *)ng_world_edit(s.world, s.material, NG_MATERIAL))->unlit = false;
    ((struct ng_material *)ng_world_edit(s.world, s.material, NG_MATERIAL))->emissive_texture = add_image(&s);
    n = frame(&s, 2);
    assert_true(n->lights[0].version > version);
    version = n->lights[0].version;
    ((struct ng_material *)ng_world_edit(s.world, s.material, NG_MATERIAL))->emissive_uv_set = 0;
    n = frame(&s, 3);
    assert_true(n->lights[0].version > version);
    OK(ng_entity_destroy(s.world, lamp));
    OK(ng_world_add(s.world, s.material, NG_LIGHT_MESH, NULL)); // a light of the material, which nothing has
    version = frame(&s, 4)->lights[0].version;
    struct ng_material *m = ng_world_edit(s.world, s.material, NG_MATERIAL);
    m->emissive_uv_set = 1;
    m->emissive_transform.rotation = 1;
    m->double_sided = !m->double_sided;
    n = frame(&s, 5);
    assert_true(n->lights[0].version == version && !(n->lights[0].power > 0));
    close_scene(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_still_scene_stays_the_same),
        cmocka_unit_test(test_lamps_are_small_and_reflect_nothing),
        cmocka_unit_test(test_moving_one_piece_marks_that_one),
        cmocka_unit_test(test_still_extraction_has_no_motion),
        cmocka_unit_test(test_pieces_come_and_go),
        cmocka_unit_test(test_material_edits_mark_their_pieces),
        cmocka_unit_test(test_materials_that_come_and_go_mark_their_pieces),
        cmocka_unit_test(test_textures_are_told_apart),
        cmocka_unit_test(test_mirrored_placement_is_flagged),
        cmocka_unit_test(test_a_removed_asset_takes_its_pieces_along),
        cmocka_unit_test(test_animation_moves_and_rests),
        cmocka_unit_test(test_skinned_positions),
        cmocka_unit_test(test_morphed_positions),
        cmocka_unit_test(test_morphed_and_skinned),
        cmocka_unit_test(test_morphed_cage),
        cmocka_unit_test(test_unusable_skin_warns_once),
        cmocka_unit_test(test_subdivided_pieces_share_one_shape),
        cmocka_unit_test(test_emitters_are_visible),
        cmocka_unit_test(test_light_versions),
        cmocka_unit_test(test_mesh_light),
        cmocka_unit_test(test_light_of_a_material),
        cmocka_unit_test(test_mesh_light_shows_its_radiance),
        cmocka_unit_test(test_warnings_come_once),
        cmocka_unit_test(test_environment),
        cmocka_unit_test(test_dark_emitters_stay_as_they_are),
        cmocka_unit_test(test_free_camera),
        cmocka_unit_test(test_cameras),
        cmocka_unit_test(test_threads_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#include "test.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "asset/png.h"
#include "base/file.h"
#include "components/animation.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_directional.h"
#include "components/light_point.h"
#include "components/light_rectangle.h"
#include "components/light_spot.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/scene_scale.h"
#include "components/skin.h"
#include "components/subdivision.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>

// A world and a store, and a file loaded into them.
struct loaded {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
};

static ng_result load(struct loaded *l, const char *path)
{
    assert_int_equal(ng_world_create(NULL, &l->world), NG_OK);
    assert_int_equal(ng_components_register(l->world), NG_OK);
    assert_int_equal(ng_assets_create(&l->assets), NG_OK);
    return ng_gltf_load(path, l->world, l->assets, NULL, &l->scene);
}

static void finish(struct loaded *l)
{
    ng_assets_destroy(&l->assets);
    ng_world_destroy(&l->world);
}

// The entity of this name, which must exist.
static ng_entity named(const struct loaded *l, const char *name)
{
    for (ng_entity e = l->scene.root; !ng_entity_is_null(e);
         e = ng_world_next_below(l->world, l->scene.root, e)) {
        const char *text = ng_world_get(l->world, e, NG_NAME);
        if (text && strcmp(text, name) == 0)
            return e;
    }
    fail_msg("no entity is called %s", name);
    return (ng_entity){0};
}

static void test_triangle(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load(&l, "tests/files/good/triangle.gltf"), NG_OK);
    const struct ng_mesh *mesh = ng_world_get(l.world, named(&l, "triangle"), NG_MESH);
    assert_non_null(mesh);
    const struct ng_geometry *g = ng_assets_geometry(l.assets, mesh->geometry);
    assert_int_equal(g->vertex_count, 3);
    assert_float_equal(g->normals[2], 1, 1e-6);
    const struct ng_material *m = ng_world_get(l.world, mesh->material, NG_MATERIAL);
    assert_float_equal(m->base_color[1], 0.25, 1e-6);
    finish(&l);
}

// Nearly every feature in one file.
static struct loaded everything(void)
{
    struct loaded l;
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(load(&l, "tests/files/good/everything.gltf"), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.warnings, 0);
    return l;
}

// Loads a file of which one part is out of range: one warning, which names the file and the part.
static struct loaded load_warned(const char *path, const char *part)
{
    struct loaded l;
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(load(&l, path), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.warnings, 1);
    assert_int_equal(log.errors, 0);
    assert_non_null(strstr(log.text, path));
    if (!strstr(log.text, part))
        fail_msg("\"%s\" is not in \"%s\"", part, log.text);
    return l;
}

static void test_numbers_out_of_range_are_moved(void **state)
{
    NG_UNUSED(state);
    struct loaded l = load_warned("tests/files/good/huge_translation.gltf", "node 0: translation");
    const struct ng_scene_scale *scale = ng_world_get(l.world, l.scene.root, NG_SCENE_SCALE);
    assert_float_equal(scale->radius, 1, 0); // of a scene in which nothing can be seen
    finish(&l);
    l = load_warned("tests/files/good/far.gltf", "node 1: its place");
    scale = ng_world_get(l.world, l.scene.root, NG_SCENE_SCALE);
    assert_true(scale->radius < 1); // of the triangle that is near
    finish(&l);
    l = load_warned("tests/files/good/animation_value_range.gltf", "key 1 of base_color");
    finish(&l);
}

static void test_hierarchy(void **state)
{
    NG_UNUSED(state);
    struct loaded l = everything();
    ng_entity pair = named(&l, "pair"), quad = named(&l, "quad");
    assert_true(ng_entity_same(ng_world_parent(l.world, pair), l.scene.root));
    assert_true(ng_entity_same(ng_world_parent(l.world, quad), pair));
    assert_true(ng_entity_same(ng_world_next_sibling(l.world, quad), named(&l, "quad again")));
    // The matrix: scale 2, a quarter turn about Y, translation 1 2 3.
    const struct ng_transform *t = ng_world_get(l.world, pair, NG_TRANSFORM);
    assert_float_equal(t->translation[2], 3, 1e-6);
    for (int i = 0; i < 3; i++)
        assert_float_equal(t->scale[i], 2, 1e-5);
    assert_float_equal(t->rotation[1], 0.7071068, 1e-5);
    assert_float_equal(t->rotation[3], 0.7071068, 1e-5);
    // A rotation that is not of unit length is made so.
    t = ng_world_get(l.world, named(&l, "quad again"), NG_TRANSFORM);
    assert_float_equal(t->rotation[2], 0.7071068, 1e-6);
    finish(&l);
}

static void test_meshes(void **state)
{
    NG_UNUSED(state);
    struct loaded l = everything();
    assert_int_equal(l.scene.primitive_count, 4);
    assert_int_equal(l.scene.triangle_count, 8);
    const struct ng_mesh *first = ng_world_get(l.world, named(&l, "primitive 0"), NG_MESH);
    const struct ng_mesh *strip = ng_world_get(l.world, named(&l, "primitive 1"), NG_MESH);
    const struct ng_mesh *quad = ng_world_get(l.world, named(&l, "quad"), NG_MESH);
    const struct ng_mesh *again = ng_world_get(l.world, named(&l, "quad again"), NG_MESH);
    assert_int_equal(quad->geometry.id, again->geometry.id);
    assert_int_equal(quad->geometry.id, first->geometry.id); // the same accessors in another mesh
    assert_int_not_equal(quad->geometry.id, strip->geometry.id);
    const struct ng_geometry *g = ng_assets_geometry(l.assets, quad->geometry);
    assert_int_equal(g->index_count, 6);
    for (uint32_t i = 0; i < g->vertex_count; i++) {
        assert_float_equal(g->normals[i * 3 + 2], 1, 1e-6);
        assert_float_equal(g->tangents[i * 4], 1, 1e-5);  // u grows along x
        assert_float_equal(g->tangents[i * 4 + 3], 1, 0); // the bitangent points to the texture's top
        assert_float_equal(g->uvs[i * 2], g->positions[i * 3] > 0, 1e-6);
    }
    assert_float_equal(g->bounds_max[1], 1, 0);
    // The strip's corners come from sparse values over zeros.
    g = ng_assets_geometry(l.assets, strip->geometry);
    assert_int_equal(g->index_count, 6);
    assert_float_equal(g->bounds_min[0], -1, 0);
    assert_float_equal(g->bounds_max[0], 2, 0);
    assert_non_null(ng_world_get(l.world, named(&l, "primitive 1"), NG_LIGHT_MESH));
    finish(&l);
}

static void test_materials(void **state)
{
    NG_UNUSED(state);
    struct loaded l = everything();
    const struct ng_material *wood = ng_world_get(l.world, named(&l, "wood"), NG_MATERIAL);
    const struct ng_material *glow = ng_world_get(l.world, named(&l, "glow"), NG_MATERIAL);
    assert_true(wood->alpha_mode == NG_ALPHA_MASK && wood->double_sided);
    assert_float_equal(wood->alpha_cutoff, 0.25, 0);
    assert_float_equal(wood->roughness, 0.5, 0);
    assert_float_equal(wood->normal_scale, 0.5, 0);
    assert_true(glow->alpha_mode == NG_ALPHA_BLEND && !glow->double_sided);
    assert_float_equal(glow->emissive_strength, 7, 0);
    const struct ng_image *color = ng_assets_image(l.assets, wood->base_color_texture);
    const struct ng_image *normal = ng_assets_image(l.assets, wood->normal_texture);
    assert_int_equal(color->format, NG_PIXEL_RGBA8_SRGB);
    assert_int_equal(normal->format, NG_PIXEL_RGBA8);
    assert_true(color->sampling.wrap_u == NG_WRAP_CLAMP && color->sampling.wrap_v == NG_WRAP_MIRROR &&
                normal->sampling.wrap_u == NG_WRAP_REPEAT);
    assert_int_equal(wood->normal_texture.id, wood->metallic_roughness_texture.id);
    finish(&l);
}

// Extensions of materials; those that are not followed are named once, with their numbers.
static void test_material_extensions(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    struct test_log log;
    test_log_begin(&log);
    assert_int_equal(load(&l, "tests/files/good/materials.gltf"), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.warnings, 1);
    assert_non_null(strstr(log.text, "KHR_materials_transmission (1)"));
    assert_non_null(strstr(log.text, "KHR_materials_clearcoat (2)"));
    const struct ng_material *glass = ng_world_get(l.world, named(&l, "glass"), NG_MATERIAL);
    assert_true(glass->alpha_mode == NG_ALPHA_BLEND && !glass->unlit);
    assert_float_equal(glass->ior, 2, 0);
    assert_float_equal(glass->specular, 0.5, 0);
    assert_float_equal(glass->specular_color[2], 2, 0);
    assert_int_equal(glass->specular_color_uv_set, 1);
    const struct ng_image *image = ng_assets_image(l.assets, glass->specular_color_texture);
    assert_true(image->format == NG_PIXEL_RGBA8_SRGB && image->sampling.wrap_u == NG_WRAP_MIRROR &&
                image->sampling.magnify == NG_FILTER_NEAREST && image->sampling.minify == NG_FILTER_NEAREST &&
                image->sampling.mips == NG_MIP_LINEAR);
    image = ng_assets_image(l.assets, glass->specular_texture);
    assert_true(image->format == NG_PIXEL_RGBA8 && image->sampling.minify == NG_FILTER_LINEAR &&
                image->sampling.mips == NG_MIP_NONE);

    const struct ng_material *turned = ng_world_get(l.world, named(&l, "turned"), NG_MATERIAL);
    assert_float_equal(turned->base_color_transform.offset[1], -1, 0);
    assert_float_equal(turned->base_color_transform.rotation, 0.5, 0);
    assert_float_equal(turned->base_color_transform.scale[1], 3, 0);
    assert_int_equal(turned->base_color_uv_set, 1);
    assert_true(((const struct ng_material *)ng_world_get(l.world, named(&l, "plain"), NG_MATERIAL))->unlit);

    // F0 is the specular colour as it is; what it leaves is diffuse.
    const struct ng_material *old = ng_world_get(l.world, named(&l, "old"), NG_MATERIAL);
    assert_float_equal(old->ior, 0, 0);
    assert_float_equal(old->specular_color[0], 0.5, 0);
    assert_float_equal(old->alpha, 0.75, 0);
    assert_float_equal(old->metallic, 0, 0);
    const unsigned char *rough = ng_assets_image(l.assets, old->metallic_roughness_texture)->pixels;
    assert_int_equal(rough[1], 128);          // 1 - 0.5 * 1
    assert_int_equal(rough[4 + 1], 255 - 64); // 1 - 0.5 * 128 / 255
    const unsigned char *base = ng_assets_image(l.assets, old->base_color_texture)->pixels;
    assert_int_equal(base[0], 191); // 0.5 / 0.96, as sRGB
    assert_int_equal(base[4], 0);
    assert_int_equal(base[4 + 3], 128);
    finish(&l);
}

static void test_lights_and_camera(void **state)
{
    NG_UNUSED(state);
    struct loaded l = everything();
    assert_int_equal(l.scene.light_count, 6);
    const struct ng_light_point *bulb = ng_world_get(l.world, named(&l, "bulb"), NG_LIGHT_POINT);
    assert_float_equal(bulb->intensity, 20, 0);
    assert_float_equal(bulb->color[2], 0.25, 0);
    const struct ng_light_directional *sun = ng_world_get(l.world, named(&l, "sun"), NG_LIGHT_DIRECTIONAL);
    assert_float_equal(sun->irradiance, 3, 0);
    const struct ng_light_spot *lamp = ng_world_get(l.world, named(&l, "lamp"), NG_LIGHT_SPOT);
    assert_float_equal(lamp->inner_angle, 0.1, 1e-6);
    const struct ng_light_rectangle *ceiling =
        ng_world_get(l.world, named(&l, "ceiling"), NG_LIGHT_RECTANGLE);
    assert_float_equal(ceiling->radiance, 12, 0);
    assert_float_equal(ceiling->size[0], 2, 0);
    assert_true(ceiling->on); // left out: the default
    assert_non_null(ng_assets_image(l.assets, ceiling->texture));
    assert_true(ng_entity_same(l.scene.camera, named(&l, "eye")));
    const struct ng_camera *camera = ng_world_get(l.world, l.scene.camera, NG_CAMERA);
    assert_float_equal(camera->fov_y, 0.9, 1e-6); // from the standard part
    assert_float_equal(camera->exposure, 1.5, 0); // from the extension
    const struct ng_scene_scale *scale = ng_world_get(l.world, l.scene.root, NG_SCENE_SCALE);
    assert_float_equal(scale->radius, 4, 0);
    finish(&l);
}

static void test_animation(void **state)
{
    NG_UNUSED(state);
    struct loaded l = everything();
    const struct ng_animation *a = ng_world_get(l.world, named(&l, "all"), NG_ANIMATION);
    assert_true(!a->loop && a->playing);
    assert_float_equal(a->speed, 2, 0);
    const struct ng_clip *clip = ng_assets_clip(l.assets, a->clip);
    assert_int_equal(clip->channel_count, 5);
    assert_float_equal(clip->duration, 2, 0);
    assert_float_equal(l.scene.duration, 2, 0);
    const struct ng_channel *c = clip->channels;
    assert_true(ng_entity_same(c[0].target, named(&l, "quad")));
    assert_int_equal(c[0].component, NG_TRANSFORM);
    assert_int_equal(c[0].field_offset, offsetof(struct ng_transform, translation));
    assert_int_equal(c[0].interpolation, NG_INTERPOLATION_LINEAR);
    assert_float_equal(c[0].values[5], 3, 0);
    assert_true(c[1].rotation && c[1].interpolation == NG_INTERPOLATION_STEP);
    assert_float_equal(c[1].values[5], 1, 1e-6); // normalised bytes
    assert_int_equal(c[2].interpolation, NG_INTERPOLATION_CUBIC);
    assert_float_equal(c[2].values[12], 2, 0);
    assert_int_equal(c[3].component, NG_LIGHT_RECTANGLE);
    assert_int_equal(c[3].width, 1);
    assert_true(ng_entity_same(c[4].target, named(&l, "wood")));
    assert_int_equal(c[4].field_offset, offsetof(struct ng_material, base_color));
    finish(&l);
}

static void test_skin(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load(&l, "tests/files/good/skin.gltf"), NG_OK);
    ng_entity e = named(&l, "node 0");
    const struct ng_skin *skin = ng_world_get(l.world, e, NG_SKIN);
    const struct ng_skeleton *s = ng_assets_skeleton(l.assets, skin->skin);
    assert_int_equal(s->joint_count, 1);
    assert_true(ng_entity_same(s->joints[0], e));
    assert_float_equal(s->inverse_bind[5], 1, 0);
    const struct ng_mesh *mesh = ng_world_get(l.world, e, NG_MESH);
    const struct ng_geometry *g = ng_assets_geometry(l.assets, mesh->geometry);
    assert_float_equal(g->weights[4], 1, 0);
    finish(&l);
}

static void test_cage(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load(&l, "tests/files/good/cage.gltf"), NG_OK);
    const struct ng_mesh *mesh = ng_world_get(l.world, named(&l, "node 0"), NG_MESH);
    const struct ng_subdivision *sub = ng_world_get(l.world, named(&l, "node 0"), NG_SUBDIVISION);
    assert_int_equal(sub->level, 1);
    assert_int_equal(ng_assets_geometry(l.assets, mesh->geometry)->index_count, 3);
    const struct ng_cage *cage = ng_assets_cage(l.assets, sub->cage);
    assert_non_null(cage);
    assert_int_equal(cage->face_count, 1);
    assert_int_equal(cage->vertex_count, 3);
    assert_float_equal(cage->positions[3], 1, 0);
    finish(&l);
}

// Without a scale and a camera in the file both are made, and the camera sees the whole box.
static void test_defaults(void **state)
{
    NG_UNUSED(state);
    struct loaded l;
    assert_int_equal(load(&l, "tests/files/good/triangle.gltf"), NG_OK);
    const struct ng_scene_scale *scale = ng_world_get(l.world, l.scene.root, NG_SCENE_SCALE);
    assert_float_equal(scale->center[0], 2, 1e-6);
    assert_float_equal(scale->center[1], 3, 1e-6);
    assert_float_equal(scale->radius, 1.4142136, 1e-5);
    const struct ng_camera *camera = ng_world_get(l.world, l.scene.camera, NG_CAMERA);
    const struct ng_transform *t = ng_world_get(l.world, l.scene.camera, NG_TRANSFORM);
    float d[3], distance = 0;
    for (int i = 0; i < 3; i++) {
        d[i] = t->translation[i] - scale->center[i];
        distance += d[i] * d[i];
    }
    distance = sqrtf(distance);
    assert_true(distance * tanf(camera->fov_y / 2) > 0.7f * scale->radius); // the triangle is flat
    // It looks along -Z turned by its rotation: towards the centre (of the box, here of the sphere too).
    float x = t->rotation[0], y = t->rotation[1], z = t->rotation[2], w = t->rotation[3];
    assert_float_equal(2 * (x * z + w * y), d[0] / distance, 1e-5);
    assert_float_equal(2 * (y * z - w * x), d[1] / distance, 1e-5);
    assert_float_equal(1 - 2 * (x * x + y * y), d[2] / distance, 1e-5);
    finish(&l);
}

// Two files in one world, and one that fails between them.
static void test_several_files(void **state)
{
    NG_UNUSED(state);
    struct loaded l = everything();
    struct ng_gltf_scene other;
    struct test_log log;
    uint32_t entities = ng_world_entity_count(l.world);
    size_t memory = ng_assets_memory(l.assets);
    test_log_begin(&log);
    const struct ng_gltf_params strict = {.strict = true};
    assert_int_not_equal(
        ng_gltf_load("tests/files/bad/animation_times.gltf", l.world, l.assets, &strict, &other), NG_OK);
    test_log_end(&log);
    assert_int_equal(ng_world_entity_count(l.world), entities);
    assert_int_equal(ng_assets_memory(l.assets), memory);
    assert_int_equal(ng_gltf_load("tests/files/good/triangle.gltf", l.world, l.assets, NULL, &other), NG_OK);
    assert_int_equal(ng_world_entity_count(l.world), entities + other.entity_count);
    finish(&l);
}

// ---- the hash --------------------------------------------------------------------------------------------
static void write_file(const char *name, const void *data, size_t size)
{
    char path[512];
    test_path(path, sizeof path, name);
    assert_int_equal(ng_file_write(path, data, size), NG_OK);
}

static void write_pixel(const char *name, unsigned char grey)
{
    char path[512];
    test_path(path, sizeof path, name);
    const unsigned char rgba[4] = {grey, grey, grey, 255};
    assert_int_equal(ng_png_write(path, &(struct ng_png_params){.width = 1, .height = 1, .pixels = rgba}),
                     NG_OK);
}

static uint64_t hash_of(const char *name)
{
    char path[512];
    struct loaded l;
    test_path(path, sizeof path, name);
    assert_int_equal(load(&l, path), NG_OK);
    uint64_t hash = l.scene.hash;
    finish(&l);
    return hash;
}

// A scene is all of its files: document, buffers, textures, what a component names.
static void test_the_hash_is_of_all_files(void **state)
{
    NG_UNUSED(state);
    static const char text[] =
        "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"a.bin\", \"byteLength\": 4}],"
        " \"images\": [{\"uri\": \"texture.png\"}], \"textures\": [{\"source\": 0}],"
        " \"materials\": [{\"normalTexture\": {\"index\": 0}}],"
        " \"nodes\": [{\"extensions\": {\"NG_scene\": {\"components\":"
        " {\"light_rectangle\": {\"texture\": {\"uri\": \"lamp.png\"}}}}}}]}";
    write_file("a.gltf", text, sizeof text - 1);
    write_file("a.bin", "1234", 4);
    write_pixel("texture.png", 1);
    write_pixel("lamp.png", 2);
    uint64_t hash = hash_of("a.gltf");
    assert_true(hash == hash_of("a.gltf"));
    write_file("a.bin", "1235", 4);
    assert_true(hash != hash_of("a.gltf"));
    write_file("a.bin", "1234", 4);
    write_pixel("texture.png", 3);
    assert_true(hash != hash_of("a.gltf"));
    write_pixel("texture.png", 1);
    write_pixel("lamp.png", 3);
    assert_true(hash != hash_of("a.gltf"));
    write_pixel("lamp.png", 2);
    assert_true(hash == hash_of("a.gltf"));
    write_file("b.gltf", text, sizeof text - 1);
    assert_true(hash == hash_of("b.gltf")); // whatever the file is called
    char spaced[sizeof text];
    memcpy(spaced, text, sizeof text);
    spaced[sizeof text - 1] = ' ';
    write_file("a.gltf", spaced, sizeof spaced);
    assert_true(hash != hash_of("a.gltf"));
}

struct names {
    const char *const *expected;
    uint32_t seen; // a bit for each
};

static void see_name(void *user, const char *path)
{
    struct names *names = user;
    for (uint32_t i = 0; names->expected[i]; i++)
        if (strcmp(strrchr(path, '/') + 1, names->expected[i]) == 0)
            names->seen |= 1u << i;
}

// Those that are not used are named too.
static void test_all_files_are_named(void **state)
{
    NG_UNUSED(state);
    static const char text[] =
        "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"a.bin\", \"byteLength\": 4}],"
        " \"images\": [{\"uri\": \"tex%74ure.png\"}, {\"uri\": \"unused.png\"}],"
        " \"textures\": [{\"source\": 0}], \"materials\": [{\"normalTexture\": {\"index\": 0}}],"
        " \"nodes\": [{\"extensions\": {\"NG_scene\": {\"components\":"
        " {\"light_rectangle\": {\"texture\": {\"uri\": \"lamp.png\"}}}}}}]}";
    static const char *const files[] = {"a.bin", "texture.png", "unused.png", "lamp.png", NULL};
    struct names names = {.expected = files};
    const struct ng_gltf_params params = {.file = see_name, .user = &names};
    struct loaded l;
    char path[512];
    write_file("named.gltf", text, sizeof text - 1);
    write_file("a.bin", "1234", 4);
    write_pixel("texture.png", 1);
    write_pixel("lamp.png", 2);
    test_path(path, sizeof path, "named.gltf");
    assert_int_equal(load(&l, path), NG_OK);
    assert_int_equal(ng_entity_destroy(l.world, l.scene.root), NG_OK);
    assert_int_equal(ng_gltf_load(path, l.world, l.assets, &params, &l.scene), NG_OK);
    assert_int_equal(names.seen, (1u << (NG_COUNT(files) - 1)) - 1);
    finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_triangle),
        cmocka_unit_test(test_numbers_out_of_range_are_moved),
        cmocka_unit_test(test_hierarchy),
        cmocka_unit_test(test_meshes),
        cmocka_unit_test(test_materials),
        cmocka_unit_test(test_material_extensions),
        cmocka_unit_test(test_lights_and_camera),
        cmocka_unit_test(test_animation),
        cmocka_unit_test(test_skin),
        cmocka_unit_test(test_cage),
        cmocka_unit_test(test_defaults),
        cmocka_unit_test(test_several_files),
        cmocka_unit_test(test_the_hash_is_of_all_files),
        cmocka_unit_test(test_all_files_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

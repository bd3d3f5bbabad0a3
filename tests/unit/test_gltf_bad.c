// Files that must be refused, or lose a part: each with one line that says what, where and which rule. Of a
// file that is refused nothing is left behind.
#define _POSIX_C_SOURCE 200809L // symlink
#include "test.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/array.h"
#include "base/file.h"
#include "components/components.h"
#include "components/name.h"
#include "components/transform.h"
#include "scene/world.h"

#include <unistd.h>

// Files in tests/files/bad, and a part of the message.
struct bad_file {
    const char *name, *message;
};

static const struct bad_file refused_files[] = {
    {"malformed", "malformed JSON at byte"},
    {"truncated", "malformed JSON at byte"},
    {"not_json", "is not a glTF file"},
    {"empty", "is not a glTF file"},
    {"array", "the document: an array where an object is needed"},
    {"no_asset", "asset.version: is missing"},
    {"asset_version_missing", "asset.version: is missing"},
    {"asset_version", "asset.version: \"3.0\" is not supported"},
    {"asset_min_version", "asset.minVersion: \"2.1\" is not supported"},
    {"extension_required", "\"KHR_gaussian_splatting\" is not supported"},
};

// Refused where the load is strict; else a part is lost.
static const struct bad_file faulty_files[] = {
    {"asset_version_number", "asset.version: \"2\" is not two numbers"},
    {"type_view_offset", "bufferViews[0].byteOffset: -4 where a whole number >= 0 is needed"},
    {"type_required", "extensionsRequired: a string where an array is needed"},
    {"type_scene_negative", "scene: -1 where an index"},
    {"type_scene_string", "scene: a string where an index"},
    {"type_children", "nodes[0].children: a string where an array is needed"},
    {"type_extensions", "nodes[0].extensions: an array where an object is needed"},
    {"type_extension", "nodes[0].extensions.NG_scene: 5 where an object is needed"},
    {"type_extension_null", "NG_scene: components is not an object"},
    {"type_large_index", "nodes[0].mesh: 4294967295 where an index"},
    {"type_attribute", "meshes[0].primitives[0].attributes.POSITION: a string where an index"},
    {"type_boolean", "materials[0].doubleSided: 1 where true or false is needed"},
    {"type_number", "materials[0].pbrMetallicRoughness.metallicFactor: a string where a number is needed"},
    {"type_name", "nodes[0].name: 7 where a string is needed"},
    {"type_light", "extensions.KHR_lights_punctual.lights[0].intensity: a string where a number is needed"},
    {"big_integer", "accessors[0].count: 4294967299 where a whole number >= 0 is needed"},
    {"cycle", "is a child of node 0 and of node 2"},
    {"cycle_alone", "is its own ancestor"},
    {"self_parent", "is its own ancestor"},
    {"two_parents", "node 2: is a child of node 0 and of node 1"},
    {"child_range", "node 0: child 5 is not one of 1"},
    {"scene_range", "scene 3 is not one of 1"},
    {"scene_node_range", "scene: node 9 is not one of 1"},
    {"scene_node_twice", "scene: node 0 is listed twice"},
    {"scene_node_child", "scene: node 1 is not a root"},
    {"zero_rotation", "node 0: rotation is zero"},
    {"rotation_count", "rotation has 3 numbers, not 4"},
    {"matrix_count", "matrix has 15 numbers, not 16"},
    {"mesh_range", "node 0: mesh 4 is not one of 1"},
    {"mesh_negative", "nodes[0].mesh: -7 where an index"},
    {"camera_range", "node 0: camera 1 is not one of 0"},
    {"camera_fov", "camera 0: yfov 7 is not in 0 to pi"},
    {"light_range", "node 0: light 2 is not one of 0"},
    {"light_type", "light type \"laser\""},
    {"light_color", "color has 2 numbers, not 3"},
    {"light_cone", "innerConeAngle"},
    {"light_negative", "light_point.intensity"},
    {"material_range", "material 3 is not one of 1"},
    {"material_roughness", "material 0: material.roughness"},
    {"alpha_mode", "alphaMode \"GLASS\""},
    {"texture_range", "material 0: texture 3 is not one of 1"},
    {"image_range", "texture 0: image 2 is not one of 1"},
    {"sampler_range", "texture 0: sampler 1 is not one of 0"},
    {"sampler_wrap", "sampler 0: wrapS has no mode 7"},
    {"image_missing", "image 0: tests/files/bad/missing.png: cannot open"},
    {"image_webp", "image 0: not a PNG, JPEG"},
    {"image_radiance", "image 0: \"image/vnd.radiance\" is not a type that the standard has"},
    {"image_zero", "images[0].uri: a string that holds the character \\u0000 where a string is needed"},
    {"image_encoded_zero", "image 0: \"a.png%00b\" holds the character %00"},
    {"image_escapes", "image 0: \"../good/x.png\" is not a file in the document"},
    {"image_view_range", "buffer view 9 is not one of 2"},
    {"image_not_a_picture", "not a PNG, JPEG, WebP, OpenEXR or Radiance HDR picture"},
    {"image_truncated_png", "PNG"},
    {"buffer_missing", "buffer 0: tests/files/bad/missing.bin: cannot open"},
    {"buffer_type", "buffer 0: \"application/x-thing\" is not a type that the standard has"},
    {"buffer_zero", "buffers[0].uri: a string that holds the character \\u0000 where a string is needed"},
    {"buffer_encoded_zero", "buffer 0: \"a.bin%00b\" holds the character %00"},
    {"buffer_escapes", "buffer 0: \"../../secret.bin\" is not a file in the document"},
    {"buffer_encoded_escape", "is not a file in the document"},
    {"buffer_absolute", "is not a file in the document"},
    {"buffer_network", "is not a file in the document"},
    {"buffer_length", "buffer 0: has 44 bytes of the 50 of its byteLength"},
    {"buffer_negative_length", "buffers[0].byteLength: -1 where a whole number >= 0 is needed"},
    {"view_range", "buffer view 0: bytes 0 + 100 run past buffer 0 of 44 bytes"},
    {"view_offset", "buffer view 0: bytes 4294967295 + 36 run past"},
    {"view_buffer", "buffer view 0: buffer 7 is not one of 1"},
    {"view_stride", "buffer view 0: stride 4 does not fit elements of 12 bytes"},
    {"view_stride_range", "accessor 0: 3 elements from byte 0 run past buffer view 0"},
    {"accessor_view", "accessor 0: buffer view 5 is not one of 2"},
    {"accessor_range", "POSITION: accessor 8 is not one of 2"},
    {"accessor_count", "accessor 0: 4 elements from byte 0 run past buffer view 0 of 36 bytes"},
    {"accessor_zero", "accessor 0: count 0"},
    {"accessor_offset", "accessor 0: 3 elements from byte 4 run past"},
    {"accessor_misaligned",
     "accessor 0: byte offset 0 + 1 or stride 12 is not a multiple of the component size 4"},
    {"accessor_shape", "accessor 0: 2 components an element are not allowed for POSITION"},
    {"accessor_component", "accessor 1: element 0 is 9.18355e-41, not a whole number from 0 (indices)"},
    {"accessor_component_unknown", "accessor 0: component type 99 is not allowed"},
    {"accessor_type_unknown", "accessor 0: its type is none of SCALAR"},
    {"accessor_huge", "accessor 0: 268435455 elements without bytes in the file, more than the limit"},
    {"nan_position", "mesh 0, primitive 0: the POSITION of vertex 1 is not a finite number"},
    {"infinite_position", "mesh 0, primitive 0: the POSITION of vertex 2 is not a finite number"},
    {"index_range", "mesh 0, primitive 0: index 3 is not below the 3 vertices"},
    {"index_count", "mesh 0, primitive 0: 2 indices make no triangle"},
    {"mode", "there is no mode 9"},
    {"attribute_count", "2 elements where NORMAL needs 3"},
    {"sparse_range", "accessor 0: sparse index 1 is 3: not below 3"},
    {"sparse_order", "accessor 0: sparse index 1 is 1: not increasing"},
    {"sparse_count", "accessor 0: sparse count 9 is not in 1 to 3"},
    {"sparse_zero", "sparse count 0"},
    {"sparse_type", "accessor 0: sparse index 0 is"},
    {"sparse_view", "buffer view 77"},
    {"skin_joint_range", "skin 0: joint 0: node 7 is not one of 1"},
    {"skin_skeleton", "skin 0: skeleton: node 999999 is not one of 1"},
    {"skin_joint_twice", "skin 0: joint 1: node 0 is listed twice"},
    {"skin_empty", "skin 0: has no joints"},
    {"skin_bind_count", "skin 0: 1 inverse bind matrices for 2 joints"},
    {"skin_vertex_joint", "JOINTS_0 refers to joint 5 of skin 0, which has 1"},
    {"skin_range", "skin 3 is not one of 1"},
    {"skin_without_joints", "its mesh has no JOINTS_0"},
    {"skin_no_weights", "JOINTS_0 and WEIGHTS_0 must come together"},
    {"animation_times", "animation 0, channel 0: times are not increasing at key 1"},
    {"animation_negative_time", "the first time -1 is negative"},
    {"animation_nan_time", "animation 0, channel 0: key 1 has what is no finite number"},
    {"animation_count", "do not fit 2 keys of translation"},
    {"animation_path", "there is no path \"colour\""},
    {"animation_interpolation", "there is no interpolation \"MAGIC\""},
    {"animation_node_range", "node 4 is not one of 1"},
    {"animation_sampler_range", "sampler 2 is not one of 1"},
    {"animation_zero_rotation",
     "animation 0, channel 0: key 1 has what is no finite number, or a rotation of length 0"},
    {"animation_cubic_count", "do not fit 2 keys"},
    {"animation_width", "3 components an element are not allowed"},
    {"animation_field", "transform has no field \"colour\""},
    {"animation_component", "its target has no light_point"},
    {"animation_not_float", "is not made of floats"},
    {"component_unknown", "there is no component \"light_laser\""},
    {"component_field", "light_sphere has no field \"brightness\""},
    {"component_type", "light_sphere.radius: expected a number"},
    {"component_count", "light_sphere.color: expected an array"},
    {"component_value_range", "light_sphere.radius"},
    {"component_choice", "expected one of \"edge_only\" \"edge_and_corner\""},
    {"component_derived", "placement is computed"},
    {"component_texture_range", "texture 4 is not one of 0"},
    {"component_uri_missing", "node 0: tests/files/bad/missing.exr: cannot open"},
    {"component_asset", "mesh.geometry: expected the standard part"},
    {"extension_member", "NG_scene: unknown member \"lights\""},
};

// Files whose cage is refused, but not the scene.
static const struct {
    const char *name, *message;
} bad_cages[] = {
    {"cage_index", "a vertex is out of range at face 0"},
    {"cage_no_faces", "has no faceSizes"},
    {"cage_face_size", "the number of corners is not in 3 to 1,024 at face 0"},
    {"cage_sum", "the faces have 3 corners, but there are 4 indices"},
    {"cage_vertex_map", "vertexMap: 7 at 1 is not below 3"},
    {"cage_no_vertices", "needs a vertexMap"},
    {"cage_crease", "a vertex is out of range at crease 0"},
    {"cage_sharpness", "the sharpness is not in 0 to 10 at crease 0"},
    {"cage_sharpness_count", "2 values of creaseSharpness where 1 are needed"},
    {"cage_crease_odd", "odd number of entries"},
    {"cage_member", "unknown member \"holes\""},
    {"cage_accessor", "accessor 99 is not one of"},
};

struct fixture {
    struct ng_world *world;
    struct ng_assets *assets;
};

static struct fixture begin(void)
{
    struct fixture f;
    assert_int_equal(ng_world_create(NULL, &f.world), NG_OK);
    assert_int_equal(ng_components_register(f.world), NG_OK);
    assert_int_equal(ng_assets_create(&f.assets), NG_OK);
    return f;
}

static void end(struct fixture *f)
{
    ng_assets_destroy(&f->assets);
    ng_world_destroy(&f->world);
}

static void check_message(const char *path, const char *message, const struct test_log *log)
{
    if (!strstr(log->text, message))
        fail_msg("%s: \"%s\" is not in \"%s\"", path, message, log->text);
    if (strlen(log->text) > 600)
        fail_msg("%s: the message repeats too much of the file: %s", path, log->text);
    if (strncmp(log->text, path, strcspn(path, ".")) != 0)
        fail_msg("%s: the message does not name the file: %s", path, log->text);
}

static void expect_refused_by(const char *path, const char *message, const struct ng_gltf_params *params)
{
    struct fixture f = begin();
    struct ng_gltf_scene scene;
    struct test_log log;
    test_log_begin(&log);
    ng_result r = ng_gltf_load(path, f.world, f.assets, params, &scene);
    test_log_end(&log);
    if (r == NG_OK)
        fail_msg("%s: was not refused", path);
    if (log.errors != 1 || log.warnings)
        fail_msg("%s: %d errors, %d warnings: %s", path, log.errors, log.warnings, log.text);
    check_message(path, message, &log);
    assert_int_equal(scene.root.id, 0);
    assert_int_equal(ng_world_entity_count(f.world), 0);
    assert_int_equal(ng_assets_memory(f.assets), 0);
    end(&f);
}

static void expect_refused(const char *path, const char *message)
{
    expect_refused_by(path, message, NULL);
}

// What follows from a fault may be a second one.
static void expect_part_lost(const char *path, const char *message)
{
    struct fixture f = begin();
    struct ng_gltf_scene scene;
    struct test_log log;
    test_log_begin(&log);
    ng_result r = ng_gltf_load(path, f.world, f.assets, NULL, &scene);
    test_log_end(&log);
    if (r != NG_OK || log.errors || log.warnings < 1 || log.warnings > 2)
        fail_msg("%s: %d errors, %d warnings: %s", path, log.errors, log.warnings, log.text);
    check_message(path, message, &log);
    if (!strstr(log.text, "; "))
        fail_msg("%s: the message does not say what is done: %s", path, log.text);
    assert_int_not_equal(scene.root.id, 0);
    end(&f);
}

static const struct ng_gltf_params strict = {.strict = true};

static void test_refused_files(void **state)
{
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(refused_files); i++) {
        char path[256];
        snprintf(path, sizeof path, "tests/files/bad/%s.gltf", refused_files[i].name);
        expect_refused_by(path, refused_files[i].message, &strict);
        expect_refused(path, refused_files[i].message);
    }
}

static void test_faulty_files(void **state)
{
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(faulty_files); i++) {
        char path[256];
        snprintf(path, sizeof path, "tests/files/bad/%s.gltf", faulty_files[i].name);
        expect_refused_by(path, faulty_files[i].message, &strict);
        expect_part_lost(path, faulty_files[i].message);
    }
}

// One warning, and the primitive's triangles alone.
static void expect_cage_refused(const char *path, const char *message)
{
    struct fixture f = begin();
    struct ng_gltf_scene scene;
    struct test_log log;
    test_log_begin(&log);
    ng_result r = ng_gltf_load(path, f.world, f.assets, NULL, &scene);
    test_log_end(&log);
    if (r != NG_OK || log.errors || log.warnings != 1)
        fail_msg("%s: %d errors, %d warnings: %s", path, log.errors, log.warnings, log.text);
    if (strncmp(log.text, path, strlen(path)) != 0 || !strstr(log.text, message))
        fail_msg("\"%s: ... %s\" is not what was said: %s", path, message, log.text);
    assert_non_null(strstr(log.text, "; it is drawn by its triangles"));
    const struct ng_geometry *g =
        ng_assets_geometry(f.assets, ng_assets_next(f.assets, NG_ASSET_GEOMETRY, (ng_asset){0}));
    assert_int_equal(g->index_count, 3);
    assert_int_equal(ng_assets_next(f.assets, NG_ASSET_CAGE, (ng_asset){0}).id, 0);
    for (ng_entity e = scene.root; !ng_entity_is_null(e); e = ng_world_next_below(f.world, scene.root, e))
        assert_false(ng_world_has(f.world, e, NG_SUBDIVISION));
    end(&f);
}

static void test_cages(void **state)
{
    NG_UNUSED(state);
    for (size_t i = 0; i < NG_COUNT(bad_cages); i++) {
        char path[256];
        snprintf(path, sizeof path, "tests/files/bad/%s.gltf", bad_cages[i].name);
        expect_cage_refused(path, bad_cages[i].message);
    }
}

static void test_missing_file(void **state)
{
    NG_UNUSED(state);
    expect_refused("tests/files/bad/no_such_file.gltf", "cannot open");
    expect_refused("tests/files/bad", "not a regular file");
}

// ---- files that are too large to keep ---------------------------------------------------------------------

// Text that is written piece by piece and then loaded.
struct text {
    NG_ARRAY(char) bytes;
};

static void put(struct text *t, const char *piece)
{
    size_t n = strlen(piece);
    assert_true(ng_array_reserve(&t->bytes, t->bytes.count + n));
    memcpy(t->bytes.items + t->bytes.count, piece, n);
    t->bytes.count += n;
}

static void put_repeated(struct text *t, const char *piece, int times)
{
    for (int i = 0; i < times; i++)
        put(t, piece);
}

static void refuse_text(struct text *t, const char *name, const char *message)
{
    char path[512];
    test_path(path, sizeof path, name);
    assert_int_equal(ng_file_write(path, t->bytes.items, t->bytes.count), NG_OK);
    expect_refused(path, message);
    ng_array_finish(&t->bytes);
}

static void test_deep_json(void **state)
{
    NG_UNUSED(state);
    struct text t = {0};
    put(&t, "{\"asset\": {\"version\": \"2.0\", \"extras\": ");
    put_repeated(&t, "[", 1000000);
    put_repeated(&t, "]", 1000000);
    put(&t, "}}");
    refuse_text(&t, "deep.gltf", "nested deeper than 64 levels");
}

static void test_many_values(void **state)
{
    NG_UNUSED(state);
    struct text t = {0};
    put(&t, "{\"asset\": {\"version\": \"2.0\", \"extras\": [0");
    put_repeated(&t, ",0", 4 << 20);
    put(&t, "]}}");
    refuse_text(&t, "values.gltf", "more than 4194304 values");
}

static void put_chain(struct text *t, int length)
{
    char node[64];
    put(t, "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0]}], \"nodes\": [");
    for (int i = 1; i < length; i++) {
        snprintf(node, sizeof node, "{\"children\": [%d]},", i);
        put(t, node);
    }
    put(t, "{}");
}

static void test_deep_hierarchy(void **state)
{
    NG_UNUSED(state);
    struct text t = {0};
    put_chain(&t, 100000);
    put(&t, "]}");
    refuse_text(&t, "chain.gltf", "nested deeper than 1024 levels");
}

static void test_many_entities(void **state)
{
    NG_UNUSED(state);
    struct text t = {0};
    put(&t, "{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{}");
    put_repeated(&t, ",{}", 300000);
    put(&t, "]}");
    refuse_text(&t, "entities.gltf", "more than the limit of 262144 entities");
}

static void test_many_joints(void **state)
{
    NG_UNUSED(state);
    struct text t = {0};
    void *good;
    size_t size;
    assert_int_equal(ng_file_read("tests/files/good/skin.gltf", 0, &good, &size), NG_OK);
    char *joints = strstr(good, "\"joints\": [0");
    assert_non_null(joints);
    char saved = joints[12];
    joints[12] = 0;
    put(&t, good);
    put_repeated(&t, ", 0", 99999);
    joints[12] = saved;
    put(&t, joints + 12);
    free(good);
    refuse_text(&t, "joints.gltf", "skin 0: 100000 joints, more than the limit of 4096");
}

// A document that names itself as each of its buffers: what is read grows with the square of its size.
static void test_many_buffers(void **state)
{
    NG_UNUSED(state);
    static const char buffer[] = ",{\"byteLength\": 66000, \"uri\": \"buffers.gltf\"}";
    char text[66000];
    size_t n = (size_t)snprintf(text, sizeof text, "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [%s",
                                buffer + 1);
    while (n + sizeof buffer + 2 < sizeof text)
        n += (size_t)snprintf(text + n, sizeof text - n, "%s", buffer);
    memset(text + n, ' ', sizeof text - n);
    text[sizeof text - 2] = ']';
    text[sizeof text - 1] = '}';
    char path[512];
    test_path(path, sizeof path, "buffers.gltf");
    assert_int_equal(ng_file_write(path, text, sizeof text), NG_OK);
    struct fixture f = begin();
    struct ng_gltf_scene scene;
    struct test_log log;
    const struct ng_gltf_params params = {.max_file_size = 3 * sizeof text + 7};
    test_log_begin(&log);
    assert_int_equal(ng_gltf_load(path, f.world, f.assets, &params, &scene), NG_ERROR_MEMORY);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "buffer 3: "));
    assert_non_null(strstr(log.text, "has 66000 bytes, more than the limit of 7"));
    end(&f);
}

// A scene from elsewhere may come with links: what they show of our disk is none of its business.
static void test_links_lead_nowhere_else(void **state)
{
    NG_UNUSED(state);
    static const char *const files[] = {
        "\"buffers\": [{\"uri\": \"%s\", \"byteLength\": 4}]",
        "\"images\": [{\"uri\": \"%s\"}], \"textures\": [{\"source\": 0}], \"materials\": "
        "[{\"normalTexture\": {\"index\": 0}}]",
    };
    static const char *const links[] = {"link.bin", "folder/secret.bin"};
    char path[512], link[512];
    test_path(path, sizeof path, "outside");
    assert_int_equal(ng_file_make_directory(path), NG_OK);
    test_path(path, sizeof path, "inside");
    assert_int_equal(ng_file_make_directory(path), NG_OK);
    test_path(path, sizeof path, "outside/secret.bin");
    assert_int_equal(ng_file_write(path, "1234", 4), NG_OK);
    test_path(link, sizeof link, "inside/link.bin");
    remove(link);
    assert_int_equal(symlink("../outside/secret.bin", link), 0);
    test_path(link, sizeof link, "inside/folder");
    remove(link);
    assert_int_equal(symlink("../outside", link), 0);
    for (size_t i = 0; i < NG_COUNT(files) * NG_COUNT(links); i++) {
        char text[512];
        struct text t = {0};
        snprintf(text, sizeof text, files[i / NG_COUNT(links)], links[i % NG_COUNT(links)]);
        put(&t, "{\"asset\": {\"version\": \"2.0\"}, ");
        put(&t, text);
        put(&t, "}");
        test_path(path, sizeof path, "inside/scene.gltf");
        assert_int_equal(ng_file_write(path, t.bytes.items, t.bytes.count), NG_OK);
        ng_array_finish(&t.bytes);
        expect_part_lost(path, "is a link that leads out of the document's directory");
    }
}

// glTF 2.0 lets a later minor version say that 2.0 suffices, and asks to try where it says nothing.
static void test_later_version(void **state)
{
    NG_UNUSED(state);
    static const char *const texts[] = {"{\"asset\": {\"version\": \"2.1\"}}",
                                        "{\"asset\": {\"version\": \"2.1\", \"minVersion\": \"2.0\"}}"};
    for (size_t i = 0; i < NG_COUNT(texts); i++) {
        struct fixture f = begin();
        struct ng_gltf_scene scene;
        char path[512];
        test_path(path, sizeof path, "later.gltf");
        assert_int_equal(ng_file_write(path, texts[i], strlen(texts[i])), NG_OK);
        assert_int_equal(ng_gltf_load(path, f.world, f.assets, NULL, &scene), NG_OK);
        end(&f);
    }
}

static void test_gigapixel(void **state)
{
    NG_UNUSED(state);
    // IHDR of 40,000 x 30,000 pixels with its checksum, and nothing after it.
    static const unsigned char png[] = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00,
                                        0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00, 0x9c, 0x40, 0x00, 0x00,
                                        0x75, 0x30, 0x08, 0x02, 0x00, 0x00, 0x00, 0x43, 0x74, 0x77, 0x57};
    char path[512];
    test_path(path, sizeof path, "giga.png");
    assert_int_equal(ng_file_write(path, png, sizeof png), NG_OK);
    struct text t = {0};
    put(&t,
        "{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"extensions\": {\"NG_scene\": {\"components\": "
        "{\"light_rectangle\": {\"texture\": {\"uri\": \"giga.png\"}}}}}}]}");
    test_path(path, sizeof path, "giga.gltf");
    assert_int_equal(ng_file_write(path, t.bytes.items, t.bytes.count), NG_OK);
    ng_array_finish(&t.bytes);
    expect_part_lost(path, "40000 x 30000 pixels, more than the limit of 16384 a side");
}

// One picture may not take all that the scene may; what it takes is known before it is decoded.
static void test_image_limit(void **state)
{
    NG_UNUSED(state);
    struct fixture f = begin();
    struct ng_gltf_scene scene;
    struct test_log log;
    const struct ng_gltf_params params = {.max_image_memory = 16};
    test_log_begin(&log);
    assert_int_equal(ng_gltf_load("tests/files/good/everything.gltf", f.world, f.assets, &params, &scene),
                     NG_ERROR_MEMORY);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "more than the 16 that one picture may have"));
    end(&f);
}

// The limit of memory counts everything that a file decodes to: up to its edge it is loaded, and below that
// the message says what is needed and what is left.
static ng_result load_within(uint64_t max_memory, struct test_log *log)
{
    struct fixture f = begin();
    struct ng_gltf_scene scene;
    test_log_begin(log);
    ng_result r =
        ng_gltf_load("tests/files/good/everything.gltf", f.world, f.assets,
                     &(struct ng_gltf_params){.max_memory = max_memory, .max_file_size = 1 << 20}, &scene);
    test_log_end(log);
    end(&f);
    return r;
}

static void test_memory_limit(void **state)
{
    NG_UNUSED(state);
    struct test_log log;
    uint64_t low = 1, high = 1 << 20; // too little, enough
    while (high - low > 1) {
        uint64_t middle = (low + high) / 2;
        ng_result r = load_within(middle, &log);
        assert_true(r == NG_OK || (r == NG_ERROR_MEMORY && log.errors == 1));
        *(r == NG_OK ? &high : &low) = middle;
    }
    assert_int_equal(load_within(low, &log), NG_ERROR_MEMORY);
    unsigned long long need = 0, left = 0, limit = 0;
    const char *at = strstr(log.text, " need");
    assert_non_null(at);
    assert_int_equal(sscanf(at + strcspn(at, "0123456789"),
                            "%llu bytes, more than the %llu that are left of the "
                            "scene's limit of %llu",
                            &need, &left, &limit),
                     3);
    assert_int_equal(need, left + 1);
    assert_int_equal(limit, low);
    assert_non_null(strstr(log.text, "--memory-limit"));
    struct fixture f = begin();
    struct ng_gltf_scene scene;
    test_log_begin(&log);
    assert_int_equal(ng_gltf_load("tests/files/good/triangle.gltf", f.world, f.assets,
                                  &(struct ng_gltf_params){.max_file_size = 64}, &scene),
                     NG_ERROR_MEMORY);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    end(&f);
}

// ---- what faults cost -------------------------------------------------------------------------------------

// A scene whose JSON has these members.
static struct ng_gltf_scene load_members(const char *members, struct fixture *f, struct test_log *log)
{
    char path[512], text[2048];
    struct ng_gltf_scene scene;
    snprintf(text, sizeof text, "{\"asset\": {\"version\": \"2.0\"}, %s}", members);
    test_path(path, sizeof path, "members.gltf");
    assert_int_equal(ng_file_write(path, text, strlen(text)), NG_OK);
    *f = begin();
    test_log_begin(log);
    ng_result r = ng_gltf_load(path, f->world, f->assets, NULL, &scene);
    test_log_end(log);
    if (r != NG_OK)
        fail_msg("%s: %s", members, log->text);
    return scene;
}

static void test_one_warning_for_each_kind(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    struct test_log log;
    struct ng_gltf_scene scene =
        load_members("\"nodes\": [{\"mesh\": 1}, {\"mesh\": 2, \"camera\": 7}, {\"mesh\": 3}]", &f, &log);
    assert_int_equal(log.warnings, 2);
    assert_non_null(
        strstr(log.text, "node 0: mesh 1 is not one of 0; the node has none (and 2 more of this kind)"));
    assert_non_null(strstr(log.text, "node 1: camera 7 is not one of 0; the node has none\n"));
    assert_false(ng_entity_is_null(scene.root));
    end(&f);
}

// Each of these has something wrong with its hierarchy; every node is there once.
static void test_hierarchies(void **state)
{
    NG_UNUSED(state);
    static const char *const texts[] = {
        // a cycle of two, and what hangs on it; a node of its own; two parents; a child twice
        "\"nodes\": [{}, {\"children\": [0, 2]}, {\"children\": [1]}]",
        "\"nodes\": [{\"children\": [0]}, {}, {}]",
        "\"nodes\": [{\"children\": [2]}, {\"children\": [2]}, {}]",
        "\"nodes\": [{\"children\": [1, 1]}, {\"children\": [2]}, {}]",
        // the scene lists a child alone, beside its parent, twice, out of range
        "\"scenes\": [{\"nodes\": [2]}], \"nodes\": [{\"children\": [1]}, {\"children\": [2]}, {}]",
        "\"scenes\": [{\"nodes\": [2, 0]}], \"nodes\": [{\"children\": [1]}, {\"children\": [2]}, {}]",
        "\"scenes\": [{\"nodes\": [0, 1, 0, 2, 3]}], \"nodes\": [{}, {}, {}]",
        "\"scene\": 4, \"nodes\": [{}, {}, {}]",
    };
    for (size_t i = 0; i < NG_COUNT(texts); i++) {
        struct fixture f;
        struct test_log log;
        struct ng_gltf_scene scene = load_members(texts[i], &f, &log);
        uint32_t nodes = 0;
        for (ng_entity e = scene.root; !ng_entity_is_null(e);
             e = ng_world_next_below(f.world, scene.root, e)) {
            const char *name = ng_world_get(f.world, e, NG_NAME);
            nodes += strncmp(name, "node ", 5) == 0;
        }
        assert_int_equal(nodes, 3);
        assert_true(log.warnings >= 1);
        end(&f);
    }
}

// What is above a listed child moves it, though it is not in the scene itself.
static void test_listed_child(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    struct test_log log;
    struct ng_gltf_scene scene = load_members(
        "\"scenes\": [{\"nodes\": [1]}], \"cameras\": [{\"type\": \"perspective\", \"perspective\": "
        "{\"yfov\": 1, \"znear\": 0.1}}], \"nodes\": [{\"children\": [1, 2], \"camera\": 0, \"translation\": "
        "[1, 2, 3]}, {\"name\": \"child\", \"camera\": 0}, {\"name\": \"sibling\"}]",
        &f, &log);
    ng_entity child = scene.camera, parent = ng_world_parent(f.world, child);
    assert_false(scene.camera_made);
    assert_string_equal(ng_world_get(f.world, child, NG_NAME), "child");
    assert_false(ng_world_has(f.world, parent, NG_CAMERA));
    const struct ng_transform *t = ng_world_get(f.world, parent, NG_TRANSFORM);
    assert_float_equal(t->translation[1], 2, 0);
    assert_true(ng_entity_is_null(ng_world_next_below(f.world, parent, child)));
    end(&f);
}

// Some writers put numbers where JSON has none. In a string they are text.
static void test_numbers_that_are_none(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    struct test_log log;
    static const char *const words[] = {"NaN", "-Infinity", "1e999", "-1e999", "null"};
    struct ng_gltf_scene scene =
        load_members("\"nodes\": [{\"name\": \"a, NaN \\\" 1e999\", \"translation\": [1, NaN, 2]}, "
                     "{\"translation\": [1e999, 0, 0]}, "
                     "{\"rotation\": [0, 0, -Infinity, 1]}, {\"translation\": [1, 2, 3]}]",
                     &f, &log);
    assert_int_equal(log.errors, 0);
    assert_non_null(strstr(log.text, "nodes[0].translation[1]: NaN where a number is needed"));
    ng_entity first = ng_world_next_below(f.world, scene.root, scene.root);
    assert_string_equal(ng_world_get(f.world, first, NG_NAME), "a, NaN \" 1e999");
    const struct ng_transform *t = ng_world_get(f.world, first, NG_TRANSFORM);
    assert_float_equal(t->translation[0], 0, 0);
    end(&f);
    for (size_t i = 0; i < NG_COUNT(words); i++) { // each is named as it stands in the file
        char members[128], message[128];
        snprintf(members, sizeof members, "\"extras\": [NaN, null], \"nodes\": [{\"scale\": [%s, 1, 1]}]",
                 words[i]);
        snprintf(message, sizeof message, ": nodes[0].scale[0]: %s where a number is needed; it is left out",
                 words[i]);
        load_members(members, &f, &log);
        if (log.warnings != 1 || !strstr(log.text, message))
            fail_msg("\"%s\" is not in %s", message, log.text);
        end(&f);
    }
}

// What is not followed is named once, though it is no fault; a material without a picture of it lacks
// nothing.
static void test_occlusion_is_named(void **state)
{
    NG_UNUSED(state);
    struct fixture f;
    struct test_log log;
    load_members(
        "\"images\": [{\"uri\": \"data:image/"
        "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+"
        "A8AAQUBAScY42YAAAAASUVORK5CYII=\"}], \"textures\": [{\"source\": 0}], "
        "\"materials\": [{}, {\"occlusionTexture\": {\"index\": 0}}, {\"occlusionTexture\": {\"index\": 0}}]",
        &f, &log);
    assert_int_equal(log.warnings, 1);
    assert_non_null(strstr(log.text,
                           "material 1: its occlusionTexture is not followed, since light is computed "
                           "(and 1 more of this kind)"));
    end(&f);
}

// Two images of the same bytes are one, and one that is sampled in another way is another.
static void test_equal_images(void **state)
{
    NG_UNUSED(state);
    static const char png[] = "data:image/"
                              "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+"
                              "A8AAQUBAScY42YAAAAASUVORK5CYII=";
    char members[1200];
    snprintf(members, sizeof members,
             "\"images\": [{\"uri\": \"%s\"}, {\"uri\": \"%s\"}], \"textures\": [{\"source\": 0}, "
             "{\"source\": 1}], "
             "\"materials\": [{\"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 0}}, "
             "\"emissiveTexture\": {\"index\": 1}, "
             "\"normalTexture\": {\"index\": 1}}]",
             png, png);
    struct fixture f;
    struct test_log log;
    struct ng_gltf_scene scene = load_members(members, &f, &log);
    assert_int_equal(log.warnings, 0);
    assert_int_equal(scene.image_count, 2);
    end(&f);
}

// ---- GLB --------------------------------------------------------------------------------------------------

struct glb {
    unsigned char *bytes;
    size_t size;
};

static void put_u32(unsigned char *at, size_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(value >> (8 * i));
}

// A text .gltf as GLB; its buffers stay data: URIs, so the binary chunk is there but unused.
static struct glb make_glb(const char *path)
{
    void *json;
    size_t size;
    assert_int_equal(ng_file_read(path, 0, &json, &size), NG_OK);
    size_t padded = (size + 3) / 4 * 4;
    struct glb g = {calloc(1, padded + 32), padded + 32};
    put_u32(g.bytes, 0x46546c67); // "glTF"
    put_u32(g.bytes + 4, 2);
    put_u32(g.bytes + 8, g.size);
    put_u32(g.bytes + 12, padded);
    put_u32(g.bytes + 16, 0x4e4f534a); // "JSON"
    memset(g.bytes + 20, ' ', padded);
    memcpy(g.bytes + 20, json, size);
    put_u32(g.bytes + 20 + padded, 4);
    put_u32(g.bytes + 24 + padded, 0x004e4942); // "BIN"
    free(json);
    return g;
}

static void refuse_glb(const struct glb *g, size_t size, const char *message)
{
    char path[512];
    test_path(path, sizeof path, "bad.glb");
    assert_int_equal(ng_file_write(path, g->bytes, size), NG_OK);
    expect_refused(path, message);
}

static void test_glb(void **state)
{
    NG_UNUSED(state);
    struct glb g = make_glb("tests/files/good/triangle.gltf");
    size_t json = g.size - 32;
    refuse_glb(&g, 12, "shorter than its header");
    refuse_glb(&g, g.size - 8, "truncated?");
    put_u32(g.bytes + 4, 1);
    refuse_glb(&g, g.size, "version 1");
    put_u32(g.bytes + 4, 2);
    put_u32(g.bytes + 12, g.size);
    refuse_glb(&g, g.size, "chunk 0 is not JSON or its length");
    put_u32(g.bytes + 12, json);
    put_u32(g.bytes + 20 + json, 8); // the chunk's own header counts too
    refuse_glb(&g, g.size, "GLB chunk 1 is 8 bytes long");
    put_u32(g.bytes + 20 + json, 4096);
    refuse_glb(&g, g.size, "GLB chunk 1 is");
    put_u32(g.bytes + 20 + json, 0xffffffff);
    refuse_glb(&g, g.size, "GLB chunk 1 is");
    free(g.bytes);
}

// Chunks that are whole are read, whatever length the header says of all; what follows them may be anything.
static void test_glb_length(void **state)
{
    NG_UNUSED(state);
    char path[512];
    unsigned char *data;
    size_t size;
    test_path(path, sizeof path, "length.glb");
    assert_int_equal(ng_file_read("content/unit/mirrored.glb", 0, (void **)&data, &size), NG_OK);
    data = realloc(data, size + 12);
    memset(data + size, 0xff, 12);
    const size_t after_json = 20 + (data[12] | (size_t)data[13] << 8),
                 lengths[] = {0, 12, 100, after_json, after_json + 50, size - 4, size + 4, 0xffffffff};
    for (size_t i = 0; i < 2 * NG_COUNT(lengths); i++) {
        size_t length = lengths[i / 2], trailing = i % 2 && length < size ? 12 : 0;
        put_u32(data + 8, length);
        assert_int_equal(ng_file_write(path, data, size + trailing), NG_OK);
        expect_part_lost(path, "GLB header says");
        expect_refused_by(path, "GLB header says", &strict);
        struct fixture f = begin();
        struct ng_gltf_scene scene;
        struct test_log log;
        test_log_begin(&log);
        assert_int_equal(ng_gltf_load(path, f.world, f.assets, NULL, &scene), NG_OK);
        test_log_end(&log);
        if (log.warnings != 1 || !scene.primitive_count)
            fail_msg("length %zu: %u primitives: %s", length, scene.primitive_count, log.text);
        end(&f);
    }
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refused_files),
        cmocka_unit_test(test_faulty_files),
        cmocka_unit_test(test_missing_file),
        cmocka_unit_test(test_deep_json),
        cmocka_unit_test(test_many_values),
        cmocka_unit_test(test_deep_hierarchy),
        cmocka_unit_test(test_many_entities),
        cmocka_unit_test(test_many_joints),
        cmocka_unit_test(test_gigapixel),
        cmocka_unit_test(test_many_buffers),
        cmocka_unit_test(test_links_lead_nowhere_else),
        cmocka_unit_test(test_later_version),
        cmocka_unit_test(test_memory_limit),
        cmocka_unit_test(test_image_limit),
        cmocka_unit_test(test_glb),
        cmocka_unit_test(test_glb_length),
        cmocka_unit_test(test_one_warning_for_each_kind),
        cmocka_unit_test(test_hierarchies),
        cmocka_unit_test(test_listed_child),
        cmocka_unit_test(test_occlusion_is_named),
        cmocka_unit_test(test_equal_images),
        cmocka_unit_test(test_numbers_that_are_none),
        cmocka_unit_test(test_cages),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// What is made of numbers that make no sense: the rest of the file is as it would be without them.
#include "gltf_maker.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/file.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/light_directional.h"
#include "components/light_spot.h"
#include "components/material.h"
#include "components/mesh.h"
#include "scene/world.h"

#include <math.h>

struct loaded {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
    struct test_log log;
};

static struct loaded load(const char *path)
{
    struct loaded l;
    assert_int_equal(ng_world_create(NULL, &l.world), NG_OK);
    assert_int_equal(ng_components_register(l.world), NG_OK);
    assert_int_equal(ng_assets_create(&l.assets), NG_OK);
    test_log_begin(&l.log);
    ng_result r = ng_gltf_load(path, l.world, l.assets, NULL, &l.scene);
    test_log_end(&l.log);
    if (r != NG_OK)
        fail_msg("%s", l.log.text);
    return l;
}

static struct loaded load_made(const struct gltf_maker *m, const char *rest)
{
    char path[512];
    gltf_write(m, "repair", rest, path, sizeof path);
    return load(path);
}

static void finish(struct loaded *l)
{
    ng_assets_destroy(&l->assets);
    ng_world_destroy(&l->world);
}

static void expect_warnings(const struct loaded *l, int count, const char *text)
{
    if (l->log.warnings != count || !strstr(l->log.text, text))
        fail_msg("%d warnings with \"%s\" were expected: %s", count, text, l->log.text);
}

// ---- vertices --------------------------------------------------------------------------------------------

// Two triangles of a square that looks along +Z, and what its vertices have besides.
static const float square[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
static const uint16_t both[] = {0, 1, 2, 0, 2, 3};
static const char one_mesh[] =
    "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [{\"attributes\": {%s}, "
    "\"indices\": %d}]}]";

static const struct ng_geometry *first_geometry(const struct loaded *l)
{
    return ng_assets_geometry(l->assets, ng_assets_next(l->assets, NG_ASSET_GEOMETRY, (ng_asset){0}));
}

static void test_directions_are_computed(void **state)
{
    NG_UNUSED(state);
    const float normals[4][3] = {{NAN, 0, 0}, {0, 0, 0}, {0, 0, 2}, {0, INFINITY, 0}};
    const float tangents[4][4] = {{NAN, 0, 0, 1}, {0, 0, 0, -1}, {3, 0, 0, 1}, {0, 1, 0, NAN}};
    const float uvs[4][2] = {{0, 0}, {NAN, 0}, {1, 1}, {0, -INFINITY}};
    struct gltf_maker m = {0};
    int positions = GLTF_PUT(&m, 5126, "VEC3", 4, square), normal = GLTF_PUT(&m, 5126, "VEC3", 4, normals);
    int tangent = GLTF_PUT(&m, 5126, "VEC4", 4, tangents), uv = GLTF_PUT(&m, 5126, "VEC2", 4, uvs);
    int indices = GLTF_PUT(&m, 5123, "SCALAR", 6, both);
    char attributes[256], rest[512];
    snprintf(attributes, sizeof attributes,
             "\"POSITION\": %d, \"NORMAL\": %d, \"TANGENT\": %d, \"TEXCOORD_0\": %d", positions, normal,
             tangent, uv);
    snprintf(rest, sizeof rest, one_mesh, attributes, indices);
    struct loaded l = load_made(&m, rest);
    expect_warnings(&l, 3,
                    "the NORMAL of vertex 0 has no direction; it is computed (and 2 more of this kind)");
    expect_warnings(&l, 3,
                    "the TANGENT of vertex 0 has no direction; it is computed (and 1 more of this kind)");
    expect_warnings(&l, 3, "the TEXCOORD of vertex 1 is not finite; it is 0, 0 (and 1 more of this kind)");
    const struct ng_geometry *g = first_geometry(&l);
    assert_int_equal(g->vertex_count, 4);
    for (size_t i = 0; i < 4; i++) {
        assert_float_equal(g->normals[i * 3 + 2], 1, 1e-6);
        const float *t = g->tangents + i * 4;
        assert_float_equal(t[0] * t[0] + t[1] * t[1], 1, 1e-5); // at right angles to the normal
        assert_float_equal(fabsf(t[3]), 1, 0);
        assert_true(isfinite(g->uvs[i * 2]) && isfinite(g->uvs[i * 2 + 1]));
    }
    assert_float_equal(g->tangents[8], 1, 1e-6);
    finish(&l);
}

// A vertex without a place costs its triangles, an index without a vertex its triangle; bounds are of the
// rest.
static void test_triangles_are_left_out(void **state)
{
    NG_UNUSED(state);
    const float nowhere[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {NAN, 5, INFINITY}};
    const uint16_t beyond[] = {0, 1, 2, 0, 2, 9};
    for (int i = 0; i < 2; i++) {
        struct gltf_maker m = {0};
        int positions = i ? GLTF_PUT(&m, 5126, "VEC3", 4, square) : GLTF_PUT(&m, 5126, "VEC3", 4, nowhere);
        int indices = i ? GLTF_PUT(&m, 5123, "SCALAR", 6, beyond) : GLTF_PUT(&m, 5123, "SCALAR", 6, both);
        char attributes[64], rest[512];
        snprintf(attributes, sizeof attributes, "\"POSITION\": %d", positions);
        snprintf(rest, sizeof rest, one_mesh, attributes, indices);
        struct loaded l = load_made(&m, rest);
        expect_warnings(&l, 1,
                        i ? "index 9 is not below the 4 vertices; the triangle is left out"
                          : "the POSITION of vertex 3 is not a finite number; its triangles are left out");
        const struct ng_geometry *g = first_geometry(&l);
        assert_int_equal(g->index_count, 3);
        assert_float_equal(g->bounds_max[0], 1, 0);
        assert_float_equal(g->bounds_max[1], 1, 0);
        assert_float_equal(g->bounds_max[2], 0, 0);
        finish(&l);
    }
}

// Puts whole numbers (or what should be some) as a type of glTF.
static int put_numbers(struct gltf_maker *m, int type, const char *shape, int count, const double *values)
{
    unsigned char bytes[64];
    size_t size = 0;
    for (int i = 0; i < count * (shape[0] == 'V' ? 4 : 1); i++) {
        const int8_t i8 = (int8_t)values[i];
        const int16_t i16 = (int16_t)values[i];
        const int32_t i32 = (int32_t)values[i];
        const float f32 = (float)values[i];
        const void *from = type == 5120   ? (const void *)&i8
                           : type == 5122 ? &i16
                           : type == 5124 ? &i32
                                          : (void *)&f32;
        size_t width = type == 5120 ? 1 : type == 5122 ? 2 : 4;
        memcpy(bytes + size, from, width);
        size += width;
    }
    return gltf_put(m, type, shape, count, bytes, size);
}

static const int odd_types[] = {5120, 5122, 5124, 5126};

// Indices of a type that the standard does not allow for them.
static void test_indices_of_any_type(void **state)
{
    NG_UNUSED(state);
    const double good[] = {0, 1, 2, 0, 2, 3},
                 bad[][6] = {{0, 1, 2, 0, 2, -1}, {0, 1, 2, 0, 2, 2.5}, {0, 1, 2, 0, 2, NAN}};
    for (size_t i = 0; i < NG_COUNT(odd_types); i++)
        for (size_t k = 0; k <= NG_COUNT(bad); k++) {
            struct gltf_maker m = {0};
            if (k > 1 && odd_types[i] != 5126)
                continue; // has no such numbers
            int positions = GLTF_PUT(&m, 5126, "VEC3", 4, square);
            int indices = put_numbers(&m, odd_types[i], "SCALAR", 6, k ? bad[k - 1] : good);
            char attributes[64], rest[512];
            snprintf(attributes, sizeof attributes, "\"POSITION\": %d", positions);
            snprintf(rest, sizeof rest, one_mesh, attributes, indices);
            struct loaded l = load_made(&m, rest);
            expect_warnings(&l, 1,
                            k ? "not a whole number from 0 (indices); the primitive is left out"
                              : "not of unsigned integers; they are read all the same");
            assert_int_equal(l.scene.triangle_count, k ? 0 : 2);
            for (size_t n = 0; !k && n < 6; n++) {
                const struct ng_geometry *g = first_geometry(&l);
                assert_memory_equal(g->positions + g->indices[n] * (size_t)3, square[both[n]], 12);
            }
            finish(&l);
        }
}

// The same of what a sparse accessor puts where.
static void test_sparse_indices_of_any_type(void **state)
{
    NG_UNUSED(state);
    const double places[] = {1, 3}, bad[] = {1, -3};
    const float values[2][3] = {{9, 0, 0}, {0, 9, 0}};
    for (size_t i = 0; i < 2 * NG_COUNT(odd_types); i++) {
        struct gltf_maker m = {0};
        int type = odd_types[i / 2];
        bool right = i % 2 == 0;
        int first = put_numbers(&m, type, "SCALAR", 2, right ? places : bad);
        int second = GLTF_PUT(&m, 5126, "VEC3", 2, values);
        char shape[256], attributes[64], rest[512];
        snprintf(
            shape, sizeof shape,
            "VEC3\", \"sparse\": {\"count\": 2, \"indices\": {\"bufferView\": %d, \"componentType\": %d}, "
            "\"values\": {\"bufferView\": %d}}, \"x\": \"",
            first, type, second);
        int positions = GLTF_PUT(&m, 5126, shape, 4, square), indices = GLTF_PUT(&m, 5123, "SCALAR", 6, both);
        snprintf(attributes, sizeof attributes, "\"POSITION\": %d", positions);
        snprintf(rest, sizeof rest, one_mesh, attributes, indices);
        struct loaded l = load_made(&m, rest);
        expect_warnings(
            &l, 1, right ? "sparse indices of component type" : "sparse index 1 is -3, not a whole number");
        assert_int_equal(l.scene.triangle_count, right ? 2 : 0);
        if (right)
            assert_float_equal(first_geometry(&l)->bounds_max[0], 9, 0);
        finish(&l);
    }
}

// One primitive that cannot be read costs itself, however often its mesh is used.
static void test_one_primitive_is_lost(void **state)
{
    NG_UNUSED(state);
    struct gltf_maker m = {0};
    int positions = GLTF_PUT(&m, 5126, "VEC3", 4, square), indices = GLTF_PUT(&m, 5123, "SCALAR", 6, both);
    char rest[512];
    snprintf(rest, sizeof rest,
             "\"nodes\": [{\"mesh\": 0}, {\"mesh\": 0}], \"meshes\": [{\"primitives\": ["
             "{\"attributes\": {\"POSITION\": 7}}, {\"attributes\": {\"POSITION\": %d}, \"indices\": %d}, "
             "{\"attributes\": {}}]}]",
             positions, indices);
    struct loaded l = load_made(&m, rest);
    expect_warnings(&l, 1,
                    "mesh 0, primitive 0: POSITION: accessor 7 is not one of 2; the primitive is left out\n");
    assert_int_equal(l.scene.primitive_count, 2);
    assert_int_equal(l.scene.triangle_count, 4);
    finish(&l);
}

// A primitive that uses few of the vertices that it shares with others keeps those, with all that they have.
static void test_shared_vertices(void **state)
{
    NG_UNUSED(state);
    float positions[64][3] = {{0}}, uvs[64][2] = {{0}};
    for (int i = 0; i < 64; i++) {
        positions[i][0] = (float)i;
        positions[i][1] = (float)(i * i);
        uvs[i][0] = (float)i / 64;
    }
    const uint16_t triangle[] = {40, 7, 20};
    struct gltf_maker m = {0};
    int position = GLTF_PUT(&m, 5126, "VEC3", 64, positions), uv = GLTF_PUT(&m, 5126, "VEC2", 64, uvs);
    int indices = GLTF_PUT(&m, 5123, "SCALAR", 3, triangle);
    char attributes[128], rest[512];
    snprintf(attributes, sizeof attributes, "\"POSITION\": %d, \"NORMAL\": %d, \"TEXCOORD_0\": %d", position,
             position, uv);
    snprintf(rest, sizeof rest, one_mesh, attributes, indices);
    struct loaded l = load_made(&m, rest);
    const struct ng_geometry *g = first_geometry(&l);
    assert_int_equal(g->vertex_count, 3);
    for (size_t i = 0; i < 3; i++) {
        assert_float_equal(g->positions[g->indices[i] * (size_t)3], triangle[i], 0);
        assert_float_equal(g->uvs[g->indices[i] * (size_t)2], (float)triangle[i] / 64, 0);
    }
    assert_float_equal(g->bounds_min[0], 7, 0);
    finish(&l);
}

// ---- key frames ------------------------------------------------------------------------------------------

// The clip of one channel that moves node 0 along x.
static struct loaded load_keys(const float *times, const float *x, int count, const char *interpolation)
{
    struct gltf_maker m = {0};
    float values[16][3] = {{0}};
    int rows = strcmp(interpolation, "CUBICSPLINE") == 0 ? count * 3 : count;
    for (int i = 0; i < rows; i++)
        values[i][0] = x[i];
    int input = gltf_put(&m, 5126, "SCALAR", count, times, (size_t)count * sizeof *times);
    int output = gltf_put(&m, 5126, "VEC3", rows, values, (size_t)rows * sizeof *values);
    char rest[512];
    snprintf(rest, sizeof rest,
             "\"nodes\": [{}], \"animations\": [{\"channels\": [{\"sampler\": 0, \"target\": {\"node\": 0, "
             "\"path\": "
             "\"translation\"}}, {\"sampler\": 0, \"target\": {\"path\": \"translation\"}}], \"samplers\": "
             "[{\"input\": %d, "
             "\"output\": %d, \"interpolation\": \"%s\"}]}]",
             input, output, interpolation);
    return load_made(&m, rest);
}

static const struct ng_clip *first_clip(const struct loaded *l)
{
    return ng_assets_clip(l->assets, ng_assets_next(l->assets, NG_ASSET_CLIP, (ng_asset){0}));
}

static void expect_keys(const struct loaded *l, const float *times, const float *x, uint32_t count)
{
    const struct ng_clip *clip = first_clip(l);
    assert_int_equal(clip->channel_count, 1); // one without a node is no channel
    const struct ng_channel *c = clip->channels;
    uint32_t width = c->interpolation == NG_INTERPOLATION_CUBIC ? 9 : 3;
    assert_int_equal(c->key_count, count);
    for (uint32_t i = 0; i < count; i++) {
        assert_float_equal(c->times[i], times[i], 1e-6);
        assert_float_equal(c->values[i * width], x[i], 0);
        assert_true(i == 0 || c->times[i] > c->times[i - 1]);
    }
    assert_float_equal(clip->duration, times[count - 1], 0);
}

static void test_times(void **state)
{
    NG_UNUSED(state);
    // Equal times: at the start the last counts, later the first until then and the last from then on.
    struct loaded l = load_keys((float[]){0, 0, 1, 1, 1, 2}, (float[]){5, 1, 2, 9, 3, 4}, 6, "LINEAR");
    expect_warnings(&l, 1, "times are not increasing at key 1");
    expect_keys(&l, (float[]){0, 1, 1, 2}, (float[]){1, 2, 3, 4}, 4);
    finish(&l);
    l = load_keys((float[]){2, 0, 1}, (float[]){3, 1, 2}, 3, "STEP");
    expect_warnings(&l, 1, "times are not increasing at key 1");
    expect_keys(&l, (float[]){0, 1, 2}, (float[]){1, 2, 3}, 3);
    finish(&l);
    l = load_keys((float[]){0, NAN, 1, INFINITY}, (float[]){1, 7, NAN, 8}, 4, "LINEAR");
    expect_warnings(
        &l, 1, "key 1 has what is no finite number, or a rotation of length 0; the key is left out (and 2");
    expect_keys(&l, (float[]){0}, (float[]){1}, 1);
    finish(&l);
    l = load_keys((float[]){-1, 1}, (float[]){1, 2}, 2, "LINEAR");
    expect_warnings(&l, 1, "the first time -1 is negative; it is played from 0");
    expect_keys(&l, (float[]){-1, 1}, (float[]){1, 2}, 2);
    finish(&l);
    l = load_keys((float[]){1, 0}, (float[]){4, 5, 6, 1, 2, 3}, 2, "CUBICSPLINE");
    expect_warnings(&l, 1, "times are not increasing at key 1");
    expect_keys(&l, (float[]){0, 1}, (float[]){1, 4}, 2);
    finish(&l);
}

static void test_no_key_is_left(void **state)
{
    NG_UNUSED(state);
    struct loaded l = load_keys((float[]){NAN, NAN}, (float[]){1, 2}, 2, "LINEAR");
    expect_warnings(&l, 2, "animation 0, channel 0: has no keys; the channel is left out");
    assert_int_equal(first_clip(&l)->channel_count, 0);
    finish(&l);
}

// ---- values ----------------------------------------------------------------------------------------------

static void test_values_are_moved(void **state)
{
    NG_UNUSED(state);
    const struct gltf_maker m = {0};
    struct loaded l = load_made(
        &m,
        "\"nodes\": [{\"extensions\": {\"KHR_lights_punctual\": {\"light\": 0}}}, {\"extensions\": "
        "{\"KHR_lights_punctual\": {\"light\": 1}}}, {\"rotation\": [0, 0, 0, 0], \"scale\": [0, 1, 1]}], "
        "\"extensions\": {\"KHR_lights_punctual\": {\"lights\": ["
        "{\"type\": \"spot\", \"color\": [1, -1, 1e300], \"intensity\": -3, \"spot\": {\"innerConeAngle\": "
        "0.4, "
        "\"outerConeAngle\": 0.4}}, {\"type\": \"directional\", \"color\": [1, 1], \"intensity\": 1e300}]}}, "
        "\"materials\": [{\"emissiveFactor\": [0, 4, 2], \"alphaCutoff\": -1, \"pbrMetallicRoughness\": "
        "{\"baseColorFactor\": [2, 0.5, -1, 7], \"metallicFactor\": -0.5, \"roughnessFactor\": 1.5}}]");
    struct ng_light_spot spot = {0};
    struct ng_light_directional sun = {0};
    struct ng_material material = {0};
    for (ng_entity e = l.scene.root; !ng_entity_is_null(e);
         e = ng_world_next_below(l.world, l.scene.root, e)) {
        if (ng_world_has(l.world, e, NG_LIGHT_SPOT))
            spot = *(const struct ng_light_spot *)ng_world_get(l.world, e, NG_LIGHT_SPOT);
        if (ng_world_has(l.world, e, NG_LIGHT_DIRECTIONAL))
            sun = *(const struct ng_light_directional *)ng_world_get(l.world, e, NG_LIGHT_DIRECTIONAL);
        if (ng_world_has(l.world, e, NG_MATERIAL))
            material = *(const struct ng_material *)ng_world_get(l.world, e, NG_MATERIAL);
    }
    assert_int_equal(l.log.errors, 0);
    assert_float_equal(spot.intensity, 0, 0);
    assert_float_equal(spot.color[1], 0, 0);
    assert_true(isfinite(spot.color[2]) && spot.color[2] > 1);
    assert_true(spot.inner_angle < spot.outer_angle && spot.inner_angle > 0.3999f);
    assert_float_equal(sun.color[1], 1, 0);
    assert_true(isfinite(sun.irradiance) && sun.irradiance > 1);
    assert_float_equal(material.base_color[0], 1, 0);
    assert_float_equal(material.base_color[2], 0, 0);
    assert_float_equal(material.alpha, 1, 0);
    assert_float_equal(material.metallic, 0, 0);
    assert_float_equal(material.roughness, 1, 0);
    assert_float_equal(material.emissive[1], 1, 0);
    assert_float_equal(material.emissive[2], 0.5, 0);
    assert_float_equal(material.emissive_strength, 4, 0);
    finish(&l);
}

// ---- the ways of writers ---------------------------------------------------------------------------------
// A triangle in base64: three positions, then indices 0, 1, 2 as 16 bits and joints as 32.
#define TRIANGLE64                                                                                           \
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"   \
    "AAAAAAAAAAAAAAAA"
#define DATA "data:application/octet-stream;base64," TRIANGLE64

static struct loaded load_triangle(const char *version, const char *uri, const char *index, const char *more)
{
    char path[512], text[4096];
    int n = snprintf(
        text, sizeof text,
        "{\"asset\": {\"version\": \"%s\"}, \"buffers\": [{\"byteLength\": 84, \"uri\": \"%s\"}], "
        "\"bufferViews\": "
        "[{\"buffer\": 0, \"byteLength\": 36}, {\"buffer\": 0, \"byteOffset\": 36, \"byteLength\": 6}], "
        "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"}, "
        "{\"bufferView\": 1, \"componentType\": 5123, \"count\": 3, \"type\": \"SCALAR\"%s}], \"meshes\": "
        "[{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"indices\": 1, \"material\": 0}]}], "
        "\"materials\": [{\"extensions\": {\"KHR_materials_unlit\": null}}], \"nodes\": [{\"mesh\": 0}, "
        "{\"camera\": 0}]%s}",
        version, uri, index, more);
    assert_true(n > 0 && (size_t)n < sizeof text);
    test_path(path, sizeof path, "written.gltf");
    gltf_write_file(path, text, (size_t)n);
    return load(path);
}

static void test_ways_of_writers(void **state)
{
    static const char camera[] = ", \"cameras\": [{\"perspective\": {\"yfov\": 0.5, \"znear\": 0.25}}]";
    static const struct {
        const char *version, *uri, *index, *warning;
    } cases[] = {
        {"2.0", DATA, "", NULL},
        {"2", DATA, "", "it is taken for 2.0"},
        {"2.0.1", DATA, "", "it is taken for 2.0"},
        {"2.0", "DATA:application/octet-stream;Base64," TRIANGLE64, "", NULL},
        {"2.0", "data:Application/Octet-Stream;base64," TRIANGLE64, "", NULL},
        {"2.0", "data:application/octet-stream;base64,\\r\\n " TRIANGLE64 "\\n", "", NULL},
        {"2.0", DATA, ", \"normalized\": true", NULL}, // indices are not fractions
        {"2.0", "sub\\\\triangle.bin", "", NULL},
        {"2.0", "sub%5Ctriangle.bin", "", NULL},
    };
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint16_t indices[3] = {0, 1, 2};
    unsigned char bytes[84] = {0};
    char folder[512];
    NG_UNUSED(state);
    memcpy(bytes, positions, 36);
    memcpy(bytes + 36, indices, 6);
    test_path(folder, sizeof folder, "sub");
    assert_int_equal(ng_file_make_directory(folder), NG_OK);
    test_path(folder, sizeof folder, "sub/triangle.bin");
    gltf_write_file(folder, bytes, sizeof bytes);
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        struct loaded l = load_triangle(cases[i].version, cases[i].uri, cases[i].index, camera);
        if (l.scene.triangle_count != 1)
            fail_msg("case %zu: %s", i, l.log.text);
        expect_warnings(&l, cases[i].warning ? 3 : 2, cases[i].warning ? cases[i].warning : "unlit");
        assert_non_null(strstr(l.log.text, "it is perspective, since it has that"));
        const struct ng_camera *c = ng_world_get(l.world, l.scene.camera, NG_CAMERA);
        assert_true(c->fov_y == 0.5f && c->near_plane == 0.25f);
        const struct ng_material *m = NULL;
        for (ng_entity e = l.scene.root; !m; e = ng_world_next_below(l.world, l.scene.root, e))
            m = ng_world_get(l.world, e, NG_MATERIAL);
        assert_false(m->unlit); // null is none
        finish(&l);
    }
    struct loaded l = load_triangle("2.0", "sub\\\\..\\\\..\\\\x.bin", "", camera);
    assert_non_null(strstr(l.log.text, "is not a file in the document's directory"));
    finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_directions_are_computed),
        cmocka_unit_test(test_triangles_are_left_out),
        cmocka_unit_test(test_shared_vertices),
        cmocka_unit_test(test_indices_of_any_type),
        cmocka_unit_test(test_sparse_indices_of_any_type),
        cmocka_unit_test(test_one_primitive_is_lost),
        cmocka_unit_test(test_times),
        cmocka_unit_test(test_no_key_is_left),
        cmocka_unit_test(test_values_are_moved),
        cmocka_unit_test(test_ways_of_writers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

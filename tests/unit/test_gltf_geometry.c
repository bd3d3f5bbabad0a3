// What vertices have in files: colours, second texture coordinates, quantized numbers, many joints; and
// copies of meshes.
#include "gltf_maker.h"

#include "anim/clip.h"
#include "asset/assets.h"
#include "asset/gltf.h"
#include "asset/gltf_save.h"
#include "base/file.h"
#include "components/animation.h"
#include "components/camera.h"
#include "components/components.h"
#include "components/material.h"
#include "components/mesh.h"
#include "components/morph.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>

enum { I8 = 5120, U8, I16, U16, U32 = 5125, F32 };

static const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const float normals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1};

struct loaded {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
    struct test_log log;
};

static ng_result load_with(struct loaded *l, const char *path, const struct ng_gltf_params *params)
{
    assert_int_equal(ng_world_create(NULL, &l->world), NG_OK);
    assert_int_equal(ng_components_register(l->world), NG_OK);
    assert_int_equal(ng_assets_create(&l->assets), NG_OK);
    test_log_begin(&l->log);
    ng_result r = ng_gltf_load(path, l->world, l->assets, params, &l->scene);
    test_log_end(&l->log);
    return r;
}

static ng_result load(struct loaded *l, const char *path)
{
    return load_with(l, path, NULL);
}

static void finish(struct loaded *l)
{
    ng_assets_destroy(&l->assets);
    ng_world_destroy(&l->world);
}

static const struct ng_geometry *first_geometry(const struct loaded *l)
{
    const struct ng_geometry *g =
        ng_assets_geometry(l->assets, ng_assets_next(l->assets, NG_ASSET_GEOMETRY, (ng_asset){0}));
    assert_non_null(g);
    return g;
}

// One primitive with these attributes beside POSITION and NORMAL.
static void load_attributes(struct loaded *l, struct gltf_maker *m, const char *attributes, const char *more)
{
    char rest[2048], path[512];
    int positions = GLTF_PUT(m, F32, "VEC3", 3, corners), normal = GLTF_PUT(m, F32, "VEC3", 3, normals);
    snprintf(rest, sizeof rest,
             "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [{\"attributes\": "
             "{\"POSITION\": %d, \"NORMAL\": %d%s}%s}]}]",
             positions, normal, attributes, more);
    gltf_write(m, "attributes", rest, path, sizeof path);
    assert_int_equal(load(l, path), NG_OK);
    assert_int_equal(l->log.errors, 0);
}

static void colors_are(const char *type, int component_type, const void *data, size_t size,
                       const uint16_t expected[4])
{
    struct gltf_maker m = {0};
    struct loaded l;
    char attributes[64];
    snprintf(attributes, sizeof attributes, ", \"COLOR_0\": %d",
             gltf_put(&m, component_type, type, 3, data, size));
    load_attributes(&l, &m, attributes, "");
    assert_int_equal(l.log.warnings, 0);
    const struct ng_geometry *g = first_geometry(&l);
    assert_non_null(g->colors);
    assert_memory_equal(g->colors + 4, expected, 8); // the second vertex
    finish(&l);
}

static void test_colors_of_every_type(void **state)
{
    NG_UNUSED(state);
    const char *const vec3 = "VEC3\", \"normalized\": true, \"name\": \"",
                      *const vec4 = "VEC4\", \"normalized\": true, \"name\": \"";
    const float f3[9] = {0, 0, 0, 0.5f, 1, 2}, f4[12] = {0, 0, 0, 0, 1, 0, -1, 0.25f};
    const uint8_t b4[12] = {0, 0, 0, 0, 255, 0, 51, 102};
    const uint16_t s3[9] = {0, 0, 0, 65535, 7, 300}, s4[12] = {0, 0, 0, 0, 1, 2, 3, 65535};
    colors_are("VEC3", F32, f3, sizeof f3, (const uint16_t[]){32768, 65535, 65535, 65535});
    colors_are("VEC4", F32, f4, sizeof f4, (const uint16_t[]){65535, 0, 0, 16384});
    colors_are(vec4, U8, b4, sizeof b4, (const uint16_t[]){65535, 0, 51 * 257, 102 * 257});
    colors_are(vec3, U16, s3, sizeof s3, (const uint16_t[]){65535, 7, 300, 65535});
    colors_are(vec4, U16, s4, sizeof s4, (const uint16_t[]){1, 2, 3, 65535});
    const uint8_t padded[12] = {0, 0, 0, 0, 9, 8, 7, 0}; // bytes of three stand four apart
    struct gltf_maker m = {0};
    struct loaded l;
    gltf_put_view(&m, padded, sizeof padded, ", \"byteStride\": 4");
    gltf_maker_append(m.accessors, sizeof m.accessors,
                      "{\"bufferView\": 0, \"componentType\": 5121, \"count\": 3, \"type\": \"VEC3\", "
                      "\"normalized\": true}");
    m.accessor_count++;
    load_attributes(&l, &m, ", \"COLOR_0\": 0", "");
    assert_memory_equal(first_geometry(&l)->colors + 4,
                        ((const uint16_t[]){9 * 257, 8 * 257, 7 * 257, 65535}), 8);
    finish(&l);
}

// What a mesh does not have costs nothing.
static void test_meshes_without_do_not_pay(void **state)
{
    NG_UNUSED(state);
    struct gltf_maker m = {0};
    struct loaded l;
    load_attributes(&l, &m, "", "");
    const struct ng_geometry *g = first_geometry(&l);
    assert_true(!g->colors && !g->uvs1);
    finish(&l);
}

// Without normals each triangle gets vertices of its own, which keep what they had.
static void test_split_vertices_keep_their_attributes(void **state)
{
    NG_UNUSED(state);
    static const float colors[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, uvs[] = {0, 0, 1, 0, 0, 1};
    static const uint16_t order[] = {2, 0, 1, 0, 1, 2};
    struct gltf_maker m = {0};
    struct loaded l;
    char path[512];
    GLTF_PUT(&m, F32, "VEC3", 3, corners);
    GLTF_PUT(&m, F32, "VEC3", 3, colors);
    GLTF_PUT(&m, F32, "VEC2", 3, uvs);
    GLTF_PUT(&m, U16, "SCALAR", 6, order);
    gltf_write(&m, "split",
               "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [{\"attributes\": "
               "{\"POSITION\": 0, \"COLOR_0\": 1, \"TEXCOORD_1\": 2}, \"indices\": 3}]}]",
               path, sizeof path);
    assert_int_equal(load(&l, path), NG_OK);
    const struct ng_geometry *g = first_geometry(&l);
    assert_int_equal(g->vertex_count, 6);
    for (size_t i = 0; i < 6; i++) {
        assert_int_equal(g->colors[i * 4 + order[i]], 65535);
        assert_true(g->uvs1[i * 2] == uvs[order[i] * 2] && g->uvs1[i * 2 + 1] == uvs[order[i] * 2 + 1]);
    }
    finish(&l);
}

// Where the normal map uses the second set, tangents follow that one, and the same triangles under another
// material are another geometry.
static void test_tangents_follow_the_normal_map(void **state)
{
    NG_UNUSED(state);
    static const float along_x[] = {0, 0, 1, 0, 0, 1}, along_y[] = {0, 0, 0, 1, 1, 0};
    struct gltf_maker m = {0};
    struct loaded l;
    char path[512];
    GLTF_PUT(&m, F32, "VEC3", 3, corners);
    GLTF_PUT(&m, F32, "VEC3", 3, normals);
    GLTF_PUT(&m, F32, "VEC2", 3, along_x);
    GLTF_PUT(&m, F32, "VEC2", 3, along_y);
#define PRIMITIVE(material)                                                                                  \
    "{\"attributes\": {\"POSITION\": 0, \"NORMAL\": 1, \"TEXCOORD_0\": 2, \"TEXCOORD_1\": 3}, "              \
    "\"material\": " #material "}"
    gltf_write(&m, "tangents",
               "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [" PRIMITIVE(0) ", " PRIMITIVE(
                   1) "]}], \"materials\": [{\"name\": \"plain\"}, {\"name\": \"bumpy\", "
                      "\"normalTexture\": {\"index\": 0, \"texCoord\": 1}}], "
                      "\"textures\": [{\"source\": 0}], \"images\": [{\"uri\": "
                      "\"data:image/"
                      "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhg"
                      "GAWjR9awAAAABJRU5ErkJggg==\"}]",
               path, sizeof path);
    assert_int_equal(load(&l, path), NG_OK);
    ng_asset first = ng_assets_next(l.assets, NG_ASSET_GEOMETRY, (ng_asset){0});
    const struct ng_geometry *plain = ng_assets_geometry(l.assets, first);
    const struct ng_geometry *bumpy =
        ng_assets_geometry(l.assets, ng_assets_next(l.assets, NG_ASSET_GEOMETRY, first));
    assert_non_null(bumpy);
    assert_true(plain->tangents[0] == 1 && plain->tangents[1] == 0);
    assert_true(bumpy->tangents[0] == 0 && bumpy->tangents[1] == 1);
    uint32_t seen = 0;
    for (ng_entity e = l.scene.root; !ng_entity_is_null(e);
         e = ng_world_next_below(l.world, l.scene.root, e)) {
        const struct ng_material *material = ng_world_get(l.world, e, NG_MATERIAL);
        seen += material && material->normal_uv_set == 1 && material->base_color_uv_set == 0;
    }
    assert_int_equal(seen, 1);
    finish(&l);
}

static const struct ng_geometry *load_quantized(struct loaded *l, int type, bool normalized, const void *data,
                                                size_t size)
{
    static const int8_t up[12] = {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0};
    char element[64], view[64], path[512], accessor[512];
    struct gltf_maker m = {0};
    snprintf(view, sizeof view, ", \"byteStride\": %zu", size / 3);
    snprintf(element, sizeof element, "%s", normalized ? ", \"normalized\": true" : "");
    gltf_put_view(&m, data, size, view);
    gltf_put_view(&m, up, sizeof up, ", \"byteStride\": 4");
    snprintf(
        accessor, sizeof accessor,
        "{\"bufferView\": 0, \"componentType\": %d, \"count\": 3, \"type\": \"VEC3\"%s}, {\"bufferView\": 1, "
        "\"componentType\": 5120, \"count\": 3, \"type\": \"VEC3\", \"normalized\": true}, "
        "{\"bufferView\": 0, \"componentType\": %d, \"count\": 3, \"type\": \"VEC2\"%s}",
        type, element, type, element);
    gltf_maker_append(m.accessors, sizeof m.accessors, accessor);
    gltf_write(&m, "quantized",
               "\"extensionsRequired\": [\"KHR_mesh_quantization\"], \"extensionsUsed\": "
               "[\"KHR_mesh_quantization\"], "
               "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [{\"attributes\": "
               "{\"POSITION\": 0, \"NORMAL\": 1, \"TEXCOORD_0\": 2, \"TEXCOORD_1\": 2}}]}]",
               path, sizeof path);
    assert_int_equal(load(l, path), NG_OK);
    assert_int_equal(l->log.warnings + l->log.errors, 0);
    return first_geometry(l);
}

static void test_quantized_vertices(void **state)
{
    NG_UNUSED(state);
    static const int8_t i8[12] = {0, 0, 0, 0, 127, -127, 0, 0, 0, 5};
    static const uint8_t u8[12] = {0, 0, 0, 0, 255, 51, 0, 0, 0, 5};
    static const int16_t i16[12] = {0, 0, 0, 0, 32767, -32767, 0, 0, 0, 5};
    static const uint16_t u16[12] = {0, 0, 0, 0, 65535, 13107, 0, 0, 0, 5};
    const struct {
        int type;
        const void *data;
        size_t size;
        float whole[2], parts[2]; // x and y of the second vertex
    } cases[] = {{I8, i8, sizeof i8, {127, -127}, {1, -1}},
                 {U8, u8, sizeof u8, {255, 51}, {1, 0.2f}},
                 {I16, i16, sizeof i16, {32767, -32767}, {1, -1}},
                 {U16, u16, sizeof u16, {65535, 13107}, {1, 0.2f}}};
    for (size_t i = 0; i < NG_COUNT(cases); i++)
        for (int normalized = 0; normalized < 2; normalized++) {
            struct loaded l;
            const float *expected = normalized ? cases[i].parts : cases[i].whole;
            const struct ng_geometry *g =
                load_quantized(&l, cases[i].type, normalized, cases[i].data, cases[i].size);
            assert_float_equal(g->positions[3], expected[0], 1e-6);
            assert_float_equal(g->positions[4], expected[1], 1e-6);
            assert_float_equal(g->uvs[2], expected[0], 1e-6);
            assert_float_equal(g->uvs1[3], expected[1], 1e-6);
            assert_float_equal(g->normals[2], 1, 0);
            finish(&l);
        }
}

// ---- influences ------------------------------------------------------------------------------------------
static void load_influences(struct loaded *l, const float weights[2][12], const uint8_t joints[2][12])
{
    struct gltf_maker m = {0};
    char path[512];
    GLTF_PUT(&m, F32, "VEC3", 3, corners);
    GLTF_PUT(&m, F32, "VEC3", 3, normals);
    for (int set = 0; set < 2; set++) {
        gltf_put(&m, F32, "VEC4", 3, weights[set], 48);
        gltf_put(&m, U8, "VEC4", 3, joints[set], 12);
    }
    gltf_write(
        &m, "influences",
        "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, "
        "\"NORMAL\": 1, \"WEIGHTS_0\": 2, \"JOINTS_0\": 3, \"WEIGHTS_1\": 4, \"JOINTS_1\": 5}}]}]",
        path, sizeof path);
    assert_int_equal(load(l, path), NG_OK);
    assert_int_equal(l->log.warnings + l->log.errors, 0);
}

// How much a joint moves a vertex.
static float influence(const struct ng_geometry *g, size_t vertex, size_t joint)
{
    float sum = 0;
    for (size_t k = vertex * 4; k < vertex * 4 + 4; k++) {
        sum += g->joints[k] == joint ? g->weights[k] : 0;
        sum += g->joints1 && g->joints1[k] == joint ? g->weights1[k] : 0;
    }
    return sum;
}

static void test_all_eight_influences_count(void **state)
{
    NG_UNUSED(state);
    // The first vertex has five joints, the second two of which one is listed six times, the third one alone.
    static const float weights[2][12] = {{0.1f, 0.05f, 0.2f, 0.15f, 0.1f, 0.1f, 0.1f, 0.1f, 0, 0, 0, 0},
                                         {0.5f, 0, 0, 0, 0.1f, 0.1f, 0.4f, 0, 0, 1, 0, 0}};
    static const uint8_t joints[2][12] = {{1, 2, 3, 4, 7, 7, 7, 7, 0, 0, 0, 0},
                                          {5, 9, 9, 9, 7, 7, 8, 0, 0, 6, 0, 0}};
    static const float expected[3][10] = {
        {0, 0.1f, 0.05f, 0.2f, 0.15f, 0.5f}, {0, 0, 0, 0, 0, 0, 0, 0.6f, 0.4f}, {0, 0, 0, 0, 0, 0, 1}};
    struct loaded l;
    load_influences(&l, weights, joints);
    const struct ng_geometry *g = first_geometry(&l);
    assert_true(g->joints1 && g->weights1);
    for (size_t vertex = 0; vertex < 3; vertex++)
        for (size_t joint = 0; joint < 10; joint++)
            assert_float_equal(influence(g, vertex, joint), expected[vertex][joint], 1e-6);
    finish(&l);
}

static void test_eight_influences_are_saved(void **state)
{
    NG_UNUSED(state);
    static const float weights[2][12] = {{0.1f, 0.05f, 0.2f, 0.15f, 0.3f, 0.3f, 0.3f, 0.1f, 1, 0, 0, 0},
                                         {0.5f, 0, 0, 0, 0.1f, 0.7f, 0.4f, 0.3f, 0, 1, 0, 0}};
    static const uint8_t joints[2][12] = {{1, 2, 3, 4, 7, 6, 5, 4, 0, 0, 0, 0},
                                          {5, 9, 9, 9, 0, 1, 2, 3, 0, 6}};
    struct loaded l, again;
    char path[512];
    load_influences(&l, weights, joints);
    test_path(path, sizeof path, "eight.glb");
    const struct ng_gltf_save_params params = {l.world, l.assets, l.scene.root, NULL};
    assert_int_equal(ng_gltf_save(path, &params), NG_OK);
    assert_int_equal(load(&again, path), NG_OK);
    const struct ng_geometry *g = first_geometry(&l), *h = first_geometry(&again);
    assert_true(h->joints1 && h->vertex_count == g->vertex_count);
    assert_memory_equal(h->weights, g->weights, g->vertex_count * 16);
    assert_memory_equal(h->weights1, g->weights1, g->vertex_count * 16);
    assert_memory_equal(h->joints1, g->joints1, g->vertex_count * 8);
    finish(&l);
    finish(&again);
}

// A second set costs time each frame: it is there only where a vertex has more than four joints.
static void test_few_influences_are_one_set(void **state)
{
    NG_UNUSED(state);
    static const float weights[2][12] = {{0.25f, 0, 0.25f, 0, 0, 0, 0, 0, 1, 0, 0, 0},
                                         {0.25f, 0.25f, 0, 0, 1}};
    static const uint8_t joints[2][12] = {{1, 9, 3, 9}, {4, 1, 8, 8, 2}};
    struct loaded l;
    load_influences(&l, weights, joints);
    const struct ng_geometry *g = first_geometry(&l);
    assert_true(!g->joints1 && !g->weights1);
    assert_float_equal(influence(g, 0, 1), 0.5f, 1e-6);
    assert_float_equal(influence(g, 0, 4), 0.25f, 1e-6);
    assert_float_equal(influence(g, 1, 2), 1, 1e-6);
    finish(&l);
}

// ---- copies ----------------------------------------------------------------------------------------------
static uint32_t count_meshes(const struct loaded *l, ng_entity below)
{
    uint32_t count = 0;
    for (ng_entity e = below; !ng_entity_is_null(e); e = ng_world_next_below(l->world, below, e))
        count += ng_world_has(l->world, e, NG_MESH);
    return count;
}

#define INSTANCED(attributes, primitives)                                                                    \
    "\"extensionsUsed\": [\"EXT_mesh_gpu_instancing\"], "                                                    \
    "\"extensionsRequired\": [\"EXT_mesh_gpu_instancing\"], \"nodes\": [{\"mesh\": 0, \"extensions\": "      \
    "{\"EXT_mesh_gpu_instancing\": {\"attributes\": {" attributes "}}}}], "                                  \
    "\"meshes\": [{\"primitives\": [" primitives "]}]"

static void load_copies(struct loaded *l, const char *rest)
{
    static const float places[] = {1, 2, 3, 4, 5, 6}, sizes[] = {1, 1, 1, 2, 3, 4};
    static const int16_t turns[] = {0, 0, 0, 32767, 0, 32767, 0, 0};
    struct gltf_maker m = {0};
    char path[512];
    GLTF_PUT(&m, F32, "VEC3", 3, corners);
    GLTF_PUT(&m, F32, "VEC3", 3, normals);
    GLTF_PUT(&m, F32, "VEC3", 2, places);
    GLTF_PUT(&m, I16, "VEC4\", \"normalized\": true, \"name\": \"", 2, turns);
    GLTF_PUT(&m, F32, "VEC3", 2, sizes);
    gltf_write(&m, "copies", rest, path, sizeof path);
    assert_int_equal(load(l, path), NG_OK);
}

static void test_copies_of_a_mesh(void **state)
{
    NG_UNUSED(state);
#define BOTH "\"TRANSLATION\": 2, \"ROTATION\": 3, \"SCALE\": 4, \"_ID\": 3"
#define P    "{\"attributes\": {\"POSITION\": 0, \"NORMAL\": 1}}"
    struct loaded l;
    load_copies(&l, INSTANCED(BOTH, P));
    ng_entity node = ng_world_first_child(l.world, l.scene.root);
    assert_int_equal(count_meshes(&l, node), 2);
    assert_false(ng_world_has(l.world, node, NG_MESH));
    ng_entity last = {0};
    for (ng_entity e = node; !ng_entity_is_null(e); e = ng_world_next_below(l.world, node, e)) {
        const struct ng_transform *t = ng_world_get(l.world, e, NG_TRANSFORM);
        last = t && t->translation[0] == 4 ? e : last;
    }
    const struct ng_transform *t = ng_world_get(l.world, last, NG_TRANSFORM);
    assert_true(t->translation[2] == 6 && t->rotation[1] == 1 && t->scale[2] == 4);
    finish(&l);
    load_copies(&l, INSTANCED(BOTH, P ", " P));
    assert_int_equal(count_meshes(&l, l.scene.root), 4);
    finish(&l);
}

// What is wrong costs the copies, with one warning; the mesh is there.
static void test_copies_that_cannot_be(void **state)
{
    NG_UNUSED(state);
    static const char *const wrong[] = {INSTANCED("\"TRANSLATION\": 0, \"SCALE\": 4", P), // 3 and 2
                                        INSTANCED("\"TRANSLATION\": 99", P), INSTANCED("\"ROTATION\": 2", P),
                                        INSTANCED("\"_ID\": 2", P)};
    for (size_t i = 0; i < NG_COUNT(wrong); i++) {
        struct loaded l;
        load_copies(&l, wrong[i]);
        assert_int_equal(count_meshes(&l, l.scene.root), 1);
        assert_int_equal(l.log.warnings, 1);
        assert_int_equal(l.log.errors, 0);
        finish(&l);
    }
}

// ---- morph targets ---------------------------------------------------------------------------------------
// A triangle with five targets: lift vertex i mod 3 by (i + 1) / 2; the second is a sparse accessor without a
// view.
static void put_targets(struct gltf_maker *m, bool with_normals, char *primitive, size_t room)
{
    static const uint8_t vertex = 1;
    static const float lift[3] = {0, 0, 1};
    int target[5], positions = GLTF_PUT(m, F32, "VEC3", 3, corners),
                   normal = GLTF_PUT(m, F32, "VEC3", 3, normals);
    for (int i = 0; i < 5; i++) {
        float deltas[9] = {0};
        deltas[i % 3 * 3 + 2] = (float)(i + 1) / 2;
        target[i] = i == 1 ? m->accessor_count : GLTF_PUT(m, F32, "VEC3", 3, deltas);
        if (i != 1)
            continue;
        char sparse[256];
        int at = gltf_put_view(m, &vertex, 1, ""), values = gltf_put_view(m, lift, sizeof lift, "");
        snprintf(sparse, sizeof sparse,
                 "{\"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\", \"sparse\": {\"count\": 1, "
                 "\"indices\": "
                 "{\"bufferView\": %d, \"componentType\": 5121}, \"values\": {\"bufferView\": %d}}}",
                 at, values);
        gltf_maker_append(m->accessors, sizeof m->accessors, sparse);
        m->accessor_count++;
    }
    char attributes[128];
    snprintf(attributes, sizeof attributes,
             with_normals ? "\"POSITION\": %d, \"NORMAL\": %d" : "\"POSITION\": %d", positions, normal);
    snprintf(
        primitive, room,
        "{\"attributes\": {%s}, \"targets\": [{\"POSITION\": %d}, {\"POSITION\": %d}, {\"POSITION\": %d}, "
        "{\"POSITION\": %d}, {\"POSITION\": %d}]}",
        attributes, target[0], target[1], target[2], target[3], target[4]);
}

static void test_morph_targets(void **state)
{
    NG_UNUSED(state);
    for (int with_normals = 0; with_normals < 2; with_normals++) {
        struct gltf_maker m = {0};
        struct loaded l;
        char primitive[1024], rest[2048], path[512];
        put_targets(&m, with_normals, primitive, sizeof primitive);
        snprintf(rest, sizeof rest,
                 "\"nodes\": [{\"mesh\": 0, \"name\": \"own\", \"weights\": [0, 0.25]}, {\"mesh\": 0}], "
                 "\"meshes\": "
                 "[{\"weights\": [1, 2, 3, 4, 1e9, 7, 7], \"primitives\": [%s]}]",
                 primitive);
        gltf_write(&m, "morph", rest, path, sizeof path);
        assert_int_equal(load(&l, path), NG_OK);
        assert_int_equal(l.log.warnings + l.log.errors, 0);
        const struct ng_geometry *g = first_geometry(&l);
        assert_int_equal(g->target_count, 5);
        // A flat triangle turns as one: each target has all three vertices, with normals.
        assert_int_equal(g->delta_count, with_normals ? 5 : 15);
        assert_true(with_normals ? !g->delta_normals : g->delta_normals != NULL);
        uint32_t second = with_normals ? 1 : 4;
        assert_int_equal(g->delta_vertices[second], 1);
        assert_float_equal(g->delta_positions[second * 3 + 2], 1, 0);
        if (g->delta_normals) { // the edge to vertex 1 rises by 45 degrees
            assert_float_equal(g->normals[0] + g->delta_normals[second * 3], -sqrtf(0.5f), 1e-6);
            assert_float_equal(g->normals[2] + g->delta_normals[second * 3 + 2], sqrtf(0.5f), 1e-6);
        }
        ng_entity own = ng_world_first_child(l.world, l.scene.root);
        for (ng_entity e = own; !ng_entity_is_null(e); e = ng_world_next_sibling(l.world, e)) {
            const struct ng_morph *morph = ng_world_get(l.world, e, NG_MORPH);
            const char *name = ng_world_get(l.world, e, NG_NAME);
            if (!morph)
                continue;
            bool is_own = strcmp(name, "own") == 0;
            const float weight_1 = is_own ? 0.25f : 2,
                        weight_4 = is_own ? 0 : 1e6f; // moved into the field's range
            assert_float_equal(morph->weights[1], weight_1, 0);
            assert_float_equal(morph->weights[4], weight_4, 0);
            assert_float_equal(morph->weights[5], 0, 0); // of no target
        }
        finish(&l);
    }
}

// Three keys of five weights, each weight its number + 10 * key; tangents are ten times that.
static void load_driven(struct loaded *l, const char *interpolation, bool cubic)
{
    static const float times[] = {0, 1, 2};
    struct gltf_maker m = {0};
    float values[45];
    char primitive[1024], rest[4096], path[512];
    put_targets(&m, true, primitive, sizeof primitive);
    int parts = cubic ? 3 : 1, input = GLTF_PUT(&m, F32, "SCALAR", 3, times);
    for (int key = 0, n = 0; key < 3; key++)
        for (int part = 0; part < parts; part++)
            for (int i = 0; i < 5; i++)
                values[n++] = (float)(i + 10 * key) * (cubic && part != 1 ? 10.0f : 1.0f);
    int output = gltf_put(&m, F32, "SCALAR", 15 * parts, values, (size_t)(15 * parts) * sizeof *values);
    snprintf(rest, sizeof rest,
             "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"primitives\": [%s, %s]}], \"animations\": "
             "[{\"channels\": "
             "[{\"sampler\": 0, \"target\": {\"node\": 0, \"path\": \"weights\"}}], \"samplers\": "
             "[{\"input\": %d, "
             "\"output\": %d, \"interpolation\": \"%s\"}]}]",
             primitive, primitive, input, output, interpolation);
    gltf_write(&m, "driven", rest, path, sizeof path);
    assert_int_equal(load(l, path), NG_OK);
    assert_int_equal(l->log.warnings + l->log.errors, 0);
}

// Each primitive of the node has a channel for each four weights.
static void check_driven(const struct loaded *l, int interpolation)
{
    bool cubic = interpolation == 2;
    const struct ng_clip *clip =
        ng_assets_clip(l->assets, ng_assets_next(l->assets, NG_ASSET_CLIP, (ng_asset){0}));
    assert_int_equal(clip->channel_count, 4);
    for (uint32_t c = 0; c < 4; c++) {
        const struct ng_channel *channel = &clip->channels[c];
        assert_int_equal(channel->interpolation, interpolation);
        assert_int_equal(channel->component, NG_MORPH);
        assert_int_equal(channel->width, 4);
        assert_int_equal(channel->field_offset, c % 2 * 16);
        assert_true(ng_world_has(l->world, channel->target, NG_MORPH));
        for (size_t key = 0; key < 3; key++)
            for (size_t i = 0; i < 4; i++) {
                size_t target = c % 2 * 4 + i;
                float expected = target < 5 ? (float)(target + 10 * key) : 0;
                const float *row = channel->values + key * (cubic ? 12 : 4);
                assert_float_equal(row[(cubic ? 4 : 0) + i], expected, 0);
                if (cubic)
                    assert_true(row[i] == expected * 10 && row[8 + i] == expected * 10);
            }
    }
    assert_false(ng_entity_same(clip->channels[0].target, clip->channels[2].target));
}

static const char *const interpolations[] = {"STEP", "LINEAR", "CUBICSPLINE"};

static void test_driven_weights(void **state)
{
    NG_UNUSED(state);
    for (int i = 0; i < 3; i++) {
        struct loaded l;
        load_driven(&l, interpolations[i], i == 2);
        check_driven(&l, i);
        finish(&l);
    }
}

// A clip that was edited is written as the standard has it: one channel of the node, of all its weights.
static void test_driven_weights_saved(void **state)
{
    NG_UNUSED(state);
    for (int i = 0; i < 3; i++) {
        struct loaded l;
        char path[512], out[512];
        void *text;
        size_t size;
        load_driven(&l, interpolations[i], i == 2);
        finish(&l);
        test_path(path, sizeof path, "driven.gltf");
        test_path(out, sizeof out, "saved.gltf");
        assert_int_equal(load_with(&l, path, &(struct ng_gltf_params){.keep = true}), NG_OK);
        ng_asset id = ng_assets_next(l.assets, NG_ASSET_CLIP, (ng_asset){0});
        struct ng_clip *clip = ng_assets_edit_clip(l.assets, id);
        for (uint32_t c = 0; c < clip->channel_count; c++)
            clip->channels[c].times[2] = 2.5f;
        assert_int_equal(ng_assets_changed(l.assets, id), NG_OK);
        const struct ng_gltf_save_params params = {l.world, l.assets, l.scene.root, l.scene.origin};
        test_log_begin(&l.log);
        assert_int_equal(ng_gltf_save(out, &params), NG_OK);
        test_log_end(&l.log);
        assert_int_equal(l.log.warnings, 0);
        ng_gltf_origin_destroy(&l.scene.origin);
        finish(&l);
        assert_int_equal(load(&l, out), NG_OK);
        check_driven(&l, i);
        id = ng_assets_next(l.assets, NG_ASSET_CLIP, (ng_asset){0});
        assert_float_equal(ng_assets_clip(l.assets, id)->duration, 2.5f, 0);
        finish(&l);
        assert_int_equal(ng_file_read(out, 0, &text, &size), NG_OK);
        assert_null(strstr(text, "weights_0")); // as NG_scene has it
        assert_non_null(strstr(text, "\"weights\""));
        free(text);
    }
}

// A target that is wrong costs the targets, not the mesh.
static void test_targets_that_cannot_be(void **state)
{
    NG_UNUSED(state);
    static const char *const wrong[] = {"{\"POSITION\": 99}", "{\"POSITION\": 2}", "{\"NORMAL\": 2}"};
    for (size_t i = 0; i < NG_COUNT(wrong); i++) {
        static const float two[6] = {0};
        struct gltf_maker m = {0};
        struct loaded l;
        char rest[1024], path[512];
        GLTF_PUT(&m, F32, "VEC3", 3, corners);
        GLTF_PUT(&m, F32, "VEC3", 3, normals);
        GLTF_PUT(&m, F32, "VEC3", 2, two);
        snprintf(
            rest, sizeof rest,
            "\"nodes\": [{\"mesh\": 0}], \"meshes\": [{\"weights\": [1], \"primitives\": [{\"attributes\": "
            "{\"POSITION\": 0, \"NORMAL\": 1}, \"targets\": [%s]}]}]",
            wrong[i]);
        gltf_write(&m, "wrong", rest, path, sizeof path);
        assert_int_equal(load(&l, path), NG_OK);
        assert_int_equal(l.log.warnings, 1);
        assert_int_equal(l.log.errors, 0);
        assert_int_equal(first_geometry(&l)->target_count, 0);
        finish(&l);
    }
}

// ---- cameras ---------------------------------------------------------------------------------------------
static void test_orthographic_cameras(void **state)
{
    NG_UNUSED(state);
    static const struct {
        const char *members;
        float height, near_plane;
        int warnings;
    } cases[] = {
        {"\"xmag\": 2, \"ymag\": 1.5, \"znear\": 0.25, \"zfar\": 9", 3, 0.25f, 0},
        {"\"xmag\": 2, \"ymag\": 1.5, \"znear\": 0, \"zfar\": 9", 3, 1e-5f, 0}, // where it stands
        {"\"xmag\": -2, \"ymag\": -1.5, \"znear\": 1, \"zfar\": 9", 3, 1, 0},   // allowed, not recommended
        {"\"xmag\": 1, \"ymag\": 1e30, \"znear\": 1, \"zfar\": 9", 1e6f, 1, 0},
        {"\"xmag\": 1, \"ymag\": 0, \"znear\": 1, \"zfar\": 9", 2, 1, 1}};
    for (size_t i = 0; i < NG_COUNT(cases); i++) {
        struct gltf_maker m = {0};
        struct loaded l;
        char rest[1024], path[512];
        GLTF_PUT(&m, F32, "VEC3", 3, corners);
        snprintf(rest, sizeof rest,
                 "\"nodes\": [{\"camera\": 0}], \"cameras\": [{\"type\": \"orthographic\", \"orthographic\": "
                 "{%s}}]",
                 cases[i].members);
        gltf_write(&m, "parallel", rest, path, sizeof path);
        assert_int_equal(load(&l, path), NG_OK);
        assert_false(l.scene.camera_made);
        const struct ng_camera *camera = ng_world_get(l.world, l.scene.camera, NG_CAMERA);
        assert_int_equal(camera->projection, NG_PROJECTION_ORTHOGRAPHIC);
        assert_float_equal(camera->height, cases[i].height, 0);
        assert_float_equal(camera->near_plane, cases[i].near_plane, 0);
        assert_int_equal(l.log.warnings, cases[i].warnings);
        finish(&l);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_colors_of_every_type),
        cmocka_unit_test(test_meshes_without_do_not_pay),
        cmocka_unit_test(test_split_vertices_keep_their_attributes),
        cmocka_unit_test(test_tangents_follow_the_normal_map),
        cmocka_unit_test(test_quantized_vertices),
        cmocka_unit_test(test_all_eight_influences_count),
        cmocka_unit_test(test_few_influences_are_one_set),
        cmocka_unit_test(test_eight_influences_are_saved),
        cmocka_unit_test(test_copies_of_a_mesh),
        cmocka_unit_test(test_copies_that_cannot_be),
        cmocka_unit_test(test_morph_targets),
        cmocka_unit_test(test_driven_weights),
        cmocka_unit_test(test_driven_weights_saved),
        cmocka_unit_test(test_targets_that_cannot_be),
        cmocka_unit_test(test_orthographic_cameras),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// Compressed geometry, made by the libraries' own encoders: Draco and meshoptimizer. Whole, and damaged.
#include "draco_maker.h"
#include "gltf_maker.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "base/file.h"
#include "base/rng.h"
#include "components/components.h"
#include "scene/world.h"

#include <math.h>
#include <meshoptimizer.h>

enum { U8 = 5121, U16 = 5123, U32 = 5125, F32 = 5126 };
enum { SIDE = 9, VERTICES = SIDE * SIDE, INDICES = (SIDE - 1) * (SIDE - 1) * 6 };

// A hilly square.
static float positions[VERTICES][3];
static uint8_t colors[VERTICES][4];
static uint32_t indices[INDICES];

static int make_square(void **state)
{
    NG_UNUSED(state);
    for (uint32_t i = 0; i < VERTICES; i++) {
        const uint32_t column = i % SIDE, row = i / SIDE;
        float x = (float)column, z = (float)row;
        const float p[3] = {x, sinf(x + z), z};
        memcpy(positions[i], p, sizeof p);
        const uint8_t c[4] = {(uint8_t)(i * 3), (uint8_t)(255 - i), (uint8_t)(i % SIDE * 20), 255};
        memcpy(colors[i], c, sizeof c);
    }
    for (uint32_t z = 0, n = 0; z + 1 < SIDE; z++)
        for (uint32_t x = 0; x + 1 < SIDE; x++, n += 6) {
            uint32_t v = z * SIDE + x;
            const uint32_t quad[6] = {v, v + SIDE, v + 1, v + 1, v + SIDE, v + SIDE + 1};
            memcpy(indices + n, quad, sizeof quad);
        }
    return 0;
}

struct loaded {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene scene;
    struct test_log log;
    const struct ng_geometry *g; // or null
};

static ng_result load(struct loaded *l, const char *path)
{
    assert_int_equal(ng_world_create(NULL, &l->world), NG_OK);
    assert_int_equal(ng_components_register(l->world), NG_OK);
    assert_int_equal(ng_assets_create(&l->assets), NG_OK);
    test_log_begin(&l->log);
    ng_result r = ng_gltf_load(path, l->world, l->assets, NULL, &l->scene);
    test_log_end(&l->log);
    l->g = ng_assets_geometry(l->assets, ng_assets_next(l->assets, NG_ASSET_GEOMETRY, (ng_asset){0}));
    return r;
}

static void finish(struct loaded *l)
{
    ng_assets_destroy(&l->assets);
    ng_world_destroy(&l->world);
}

// Each triangle of the square is there, with its colours, wherever its vertices are.
static void assert_is_square(const struct loaded *l, double precision)
{
    assert_int_equal(l->log.warnings + l->log.errors, 0);
    const struct ng_geometry *g = l->g;
    assert_non_null(g);
    assert_int_equal(g->index_count, INDICES);
    bool seen[VERTICES] = {false};
    for (size_t i = 0; i < g->index_count; i++) {
        const float *p = g->positions + g->indices[i] * (size_t)3;
        size_t vertex = (size_t)lroundf(p[2]) * SIDE + (size_t)lroundf(p[0]);
        assert_true(vertex < VERTICES);
        seen[vertex] = true;
        for (size_t k = 0; k < 3; k++)
            assert_float_equal(p[k], positions[vertex][k], precision);
        for (size_t k = 0; k < 4; k++)
            assert_int_equal(g->colors[g->indices[i] * (size_t)4 + k], colors[vertex][k] * 257);
    }
    for (size_t i = 0; i < VERTICES; i++)
        assert_true(seen[i]);
}

// ---- Draco -----------------------------------------------------------------------------------------------

static void write_draco(const unsigned char *data, size_t size, const char *members, char *path, size_t room)
{
    struct gltf_maker m = {0};
    char rest[2048], accessors[512];
    int view = gltf_put_view(&m, data, size, "");
    snprintf(accessors, sizeof accessors,
             "{\"componentType\": 5126, \"count\": %d, \"type\": \"VEC3\"}, {\"componentType\": 5121, "
             "\"count\": %d, "
             "\"type\": \"VEC4\", \"normalized\": true}, {\"componentType\": 5123, \"count\": %d, \"type\": "
             "\"SCALAR\"}",
             VERTICES, VERTICES, INDICES);
    gltf_maker_append(m.accessors, sizeof m.accessors, accessors);
    snprintf(
        rest, sizeof rest,
        "\"extensionsUsed\": [\"KHR_draco_mesh_compression\"], "
        "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"nodes\": [{\"mesh\": 0}], \"meshes\": "
        "[{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"COLOR_0\": 1}, \"indices\": 2, "
        "\"extensions\": "
        "{\"KHR_draco_mesh_compression\": {\"bufferView\": %d, %s}}}]}]",
        view, members);
    gltf_write(&m, "draco", rest, path, room);
}

#define USUAL "\"attributes\": {\"POSITION\": 0, \"COLOR_0\": 1}"

#define NO_VIEW "\"bufferView\": 9, \"attributes\": {\"POSITION\": 0, \"COLOR_0\": 1}"

static size_t make_draco(bool edgebreaker, bool metadata, unsigned char *out, size_t room)
{
    const struct draco_source source = {VERTICES, INDICES,     positions[0], colors[0],
                                        indices,  edgebreaker, metadata};
    size_t size = draco_make(&source, out, room);
    assert_true(size > 0);
    return size;
}

static void test_draco(void **state)
{
    NG_UNUSED(state);
    for (int kind = 0; kind < 4; kind++) {
        static unsigned char data[16384];
        struct loaded l;
        char path[512];
        bool edgebreaker = kind & 1;
        size_t size = make_draco(edgebreaker, kind & 2, data, sizeof data);
        write_draco(data, size, USUAL, path, sizeof path);
        assert_int_equal(load(&l, path), NG_OK);
        assert_is_square(&l, edgebreaker ? 1e-3 : 0);
        finish(&l);
    }
}

// What the primitive says of the compressed mesh and what this has are two things.
static void test_draco_that_does_not_fit(void **state)
{
    NG_UNUSED(state);
    static const char *const wrong[] = {"\"attributes\": {\"POSITION\": 1, \"COLOR_0\": 0}",
                                        "\"attributes\": {\"POSITION\": 7, \"COLOR_0\": 1}",
                                        "\"attributes\": {\"POSITION\": 0, \"NORMAL\": 1}",
                                        "\"attributes\": {\"POSITION\": -1}",
                                        "\"attributes\": 3",
                                        "\"attributes\": {\"POSITION\": \"x\"}",
                                        NO_VIEW};
    static unsigned char data[16384];
    size_t size = make_draco(false, false, data, sizeof data);
    for (size_t i = 0; i < NG_COUNT(wrong); i++) {
        struct loaded l;
        char path[512];
        write_draco(data, size, wrong[i], path, sizeof path);
        (void)!load(&l, path); // the file, or its one primitive
        assert_null(l.g);
        assert_int_equal(l.log.warnings + l.log.errors, 1);
        finish(&l);
    }
}

// ---- meshoptimizer ---------------------------------------------------------------------------------------

struct coded {
    unsigned char data[16384];
    size_t size;
};

static void encode_all(struct coded out[3])
{
    meshopt_encodeVertexVersion(0);
    meshopt_encodeIndexVersion(1);
    out[0].size = meshopt_encodeVertexBuffer(out[0].data, sizeof out[0].data, positions, VERTICES, 12);
    out[1].size = meshopt_encodeVertexBuffer(out[1].data, sizeof out[1].data, colors, VERTICES, 4);
    out[2].size = meshopt_encodeIndexBuffer(out[2].data, sizeof out[2].data, indices, INDICES);
    for (int i = 0; i < 3; i++)
        assert_true(out[i].size > 0);
}

// `mode` of the indices; `first`: members of the first view's extension that are other than usual.
static void write_meshopt(const struct coded in[3], const char *name, const char *mode, const char *first,
                          char *path, size_t room)
{
    static const char usual[] = "\"count\": 81, \"byteStride\": 12, \"mode\": \"ATTRIBUTES\"";
    struct gltf_maker m = {0};
    char rest[2048], views[2048];
    int at[3];
    for (int i = 0; i < 3; i++) {
        at[i] = (int)m.size;
        memcpy(m.bytes + m.size, in[i].data, in[i].size);
        m.size += (in[i].size + 3) & ~(size_t)3;
    }
#define VIEW                                                                                                 \
    "{\"buffer\": 1, \"byteOffset\": 0, \"byteLength\": %d, \"extensions\": {\"%s\": {\"buffer\": 0, "       \
    "\"byteOffset\": %d, \"byteLength\": %zu, "
    snprintf(views, sizeof views,
             VIEW "%s}}}, " VIEW "\"count\": 81, \"byteStride\": 4, \"mode\": \"ATTRIBUTES\"}}}, " VIEW
                  "\"count\": %d, \"byteStride\": 2, \"mode\": \"%s\"}}}",
             VERTICES * 12, name, at[0], in[0].size, first ? first : usual, VERTICES * 4, name, at[1],
             in[1].size, INDICES * 2, name, at[2], in[2].size, INDICES, mode);
    gltf_maker_append(m.views, sizeof m.views, views);
    gltf_maker_append(m.accessors, sizeof m.accessors,
                      "{\"bufferView\": 0, \"componentType\": 5126, \"count\": 81, \"type\": \"VEC3\"}, "
                      "{\"bufferView\": 1, \"componentType\": 5121, \"count\": 81, \"type\": \"VEC4\", "
                      "\"normalized\": true}, "
                      "{\"bufferView\": 2, \"componentType\": 5123, \"count\": 384, \"type\": \"SCALAR\"}");
    snprintf(rest, sizeof rest,
             "\"extensionsUsed\": [\"%s\"], \"extensionsRequired\": [\"%s\"], \"nodes\": [{\"mesh\": 0}], "
             "\"meshes\": "
             "[{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"COLOR_0\": 1}, \"indices\": 2}]}]",
             name, name);
    gltf_write(&m, "meshopt", rest, path, room);
}

// The buffer that views name is a fallback: it has a length and no bytes.
static void add_fallback(const char *path)
{
    static char text[65536];
    void *data;
    size_t size;
    assert_int_equal(ng_file_read(path, sizeof text, &data, &size), NG_OK);
    const char *end = strstr(data, "}], \"bufferViews\"");
    assert_non_null(end);
    size_t head = (size_t)(end - (const char *)data) + 1;
    int n = snprintf(text, sizeof text,
                     "%.*s, {\"byteLength\": 4096, \"extensions\": {\"EXT_meshopt_compression\": "
                     "{\"fallback\": true}}}%.*s",
                     (int)head, (const char *)data, (int)(size - head), (const char *)data + head);
    assert_true(n > 0 && (size_t)n < sizeof text);
    gltf_write_file(path, text, (size_t)n);
    free(data);
}

static void test_meshopt(void **state)
{
    NG_UNUSED(state);
    static struct coded coded[3];
    for (int kind = 0; kind < 3; kind++) {
        struct loaded l;
        char path[512];
        encode_all(coded);
        if (kind == 1)
            coded[2].size =
                meshopt_encodeIndexSequence(coded[2].data, sizeof coded[2].data, indices, INDICES);
        write_meshopt(coded, kind == 2 ? "KHR_meshopt_compression" : "EXT_meshopt_compression",
                      kind == 1 ? "INDICES" : "TRIANGLES", NULL, path, sizeof path);
        add_fallback(path);
        assert_int_equal(load(&l, path), NG_OK);
        assert_is_square(&l, 0);
        finish(&l);
    }
}

// Filters turn what was decoded into the numbers that accessors have.
static void test_meshopt_filters(void **state)
{
    NG_UNUSED(state);
    static struct coded coded[3];
    static uint32_t exponential[VERTICES][3];
    struct loaded l;
    char path[512];
    encode_all(coded);
    meshopt_encodeFilterExp(exponential, VERTICES, 12, 20, positions[0]);
    coded[0].size =
        meshopt_encodeVertexBuffer(coded[0].data, sizeof coded[0].data, exponential, VERTICES, 12);
    write_meshopt(coded, "EXT_meshopt_compression", "TRIANGLES",
                  "\"count\": 81, \"byteStride\": 12, \"mode\": \"ATTRIBUTES\", \"filter\": \"EXPONENTIAL\"",
                  path, sizeof path);
    add_fallback(path);
    assert_int_equal(load(&l, path), NG_OK);
    assert_is_square(&l, 1e-4);
    finish(&l);
}

static void test_meshopt_that_does_not_fit(void **state)
{
    NG_UNUSED(state);
    static const char *const wrong[] = {
        "\"count\": 81, \"byteStride\": 12, \"mode\": \"NEITHER\"",
        "\"count\": 81, \"byteStride\": 13, \"mode\": \"ATTRIBUTES\"",
        "\"count\": 81, \"byteStride\": 1024, \"mode\": \"ATTRIBUTES\"",
        "\"count\": 81, \"byteStride\": 0, \"mode\": \"ATTRIBUTES\"",
        "\"count\": 4000000000, \"byteStride\": 256, \"mode\": \"ATTRIBUTES\"",
        "\"count\": 1e30, \"byteStride\": 12, \"mode\": \"ATTRIBUTES\"",
        "\"count\": -81, \"byteStride\": 12, \"mode\": \"ATTRIBUTES\"",
        "\"count\": 80, \"byteStride\": 12, \"mode\": \"ATTRIBUTES\"", // too few for the accessor
        "\"count\": 81, \"byteStride\": 12, \"mode\": \"TRIANGLES\"",
        "\"count\": 82, \"byteStride\": 4, \"mode\": \"TRIANGLES\"",
        "\"count\": 81, \"byteStride\": 12, \"mode\": \"ATTRIBUTES\", \"filter\": \"OCTAHEDRAL\"",
        "\"count\": 81, \"byteStride\": 12, \"mode\": \"ATTRIBUTES\", \"filter\": \"SHARPEN\"",
    };
    static struct coded coded[3];
    encode_all(coded);
    for (size_t i = 0; i < NG_COUNT(wrong); i++) {
        struct loaded l;
        char path[512];
        write_meshopt(coded, "EXT_meshopt_compression", "TRIANGLES", wrong[i], path, sizeof path);
        add_fallback(path);
        (void)!load(&l, path);
        assert_null(l.g);
        assert_true(l.log.warnings + l.log.errors >= 1);
        finish(&l);
    }
}

// ---- damage ----------------------------------------------------------------------------------------------
// Whatever the bytes are, there is a mesh with vertices that exist, or none.
static void load_damaged(const char *path)
{
    struct loaded l;
    (void)!load(&l, path);
    for (size_t i = 0; l.g && i < l.g->index_count; i++)
        assert_true(l.g->indices[i] < l.g->vertex_count);
    finish(&l);
}

static void damage(unsigned char *data, size_t *size, struct ng_rng *rng)
{
    if (ng_rng_below(rng, 4) == 0)
        *size = 1 + ng_rng_below(rng, (uint32_t)*size - 1);
    for (uint32_t i = 0, n = 1 + ng_rng_below(rng, 4); i < n; i++)
        data[ng_rng_below(rng, (uint32_t)*size)] = (unsigned char)ng_rng_below(rng, 256);
}

static void test_damaged_bytes(void **state)
{
    NG_UNUSED(state);
    static unsigned char whole[2][16384], data[16384];
    static struct coded coded[3], broken[3];
    struct ng_rng rng = ng_rng_make(7, 0);
    char path[512];
    size_t sizes[2];

    encode_all(coded);
    for (int kind = 0; kind < 2; kind++)
        sizes[kind] = make_draco(kind, false, whole[kind], sizeof whole[kind]);
    for (int round = 0; round < 150; round++) {
        size_t size = sizes[round % 2];
        memcpy(data, whole[round % 2], size);
        damage(data, &size, &rng);
        write_draco(data, size, USUAL, path, sizeof path);
        load_damaged(path);
        memcpy(broken, coded, sizeof broken);
        damage(broken[round % 3].data, &broken[round % 3].size, &rng);
        write_meshopt(broken, "EXT_meshopt_compression", "TRIANGLES", NULL, path, sizeof path);
        add_fallback(path);
        load_damaged(path);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_draco),
        cmocka_unit_test(test_draco_that_does_not_fit),
        cmocka_unit_test(test_meshopt),
        cmocka_unit_test(test_meshopt_filters),
        cmocka_unit_test(test_meshopt_that_does_not_fit),
        cmocka_unit_test(test_damaged_bytes),
    };
    return cmocka_run_group_tests(tests, make_square, NULL);
}

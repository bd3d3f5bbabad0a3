// The files of a data set: tensors, manifest, and the lookup in depth maps; no device is needed.
#include "test.h"

#include "base/file.h"
#include "base/hash.h"
#include "lightformer/clues/captured.h"
#include "lightformer/dataset/manifest.h"
#include "lightformer/tensors/json_reader.h"
#include "lightformer/tensors/tensors.h"

#include <math.h>

#define OK(call) assert_int_equal((call), NG_OK)

// ---- tensors ---------------------------------------------------------------------------------------------

static void fill_tensors(struct lf_tensors *t)
{
    const uint64_t shape[] = {2, 3}, none[] = {0, 7};
    *t = (struct lf_tensors){0};
    uint8_t *bytes = lf_tensors_add(t, "7/mask", LF_U8, 1, (const uint64_t[]){5});
    float *floats = lf_tensors_add(t, "7/values", LF_F32, 2, shape);
    uint16_t *halfs = lf_tensors_add(t, "7/\"half\\s\"", LF_F16, 1, shape + 1);
    assert_true(bytes && floats && halfs && lf_tensors_add(t, "7/empty", LF_I32, 2, none));
    for (int i = 0; i < 6; i++)
        floats[i] = (float)i + 0.5f;
    for (int i = 0; i < 5; i++)
        bytes[i] = (uint8_t)(10 * i);
    for (int i = 0; i < 3; i++)
        halfs[i] = (uint16_t)(1000 * i);
    OK(lf_tensors_note(t, "scene", "a \"quoted\" name"));
}

static void what_is_written_is_read(void **state)
{
    NG_UNUSED(state);
    struct lf_tensors out, in;
    char path[512];
    test_path(path, sizeof path, "round.safetensors");
    fill_tensors(&out);
    OK(lf_tensors_write(&out, path));
    OK(lf_tensors_read(path, &in));
    assert_true(in.hash == out.hash && in.hash);
    assert_int_equal(in.list.count, 4);
    assert_string_equal(lf_tensors_noted(&in, "scene"), "a \"quoted\" name");
    assert_null(lf_tensors_noted(&in, "hash"));
    for (size_t i = 0; i < 4; i++) {
        const struct lf_tensor *a = &out.list.items[i], *b = lf_tensors_find(&in, a->name);
        assert_true(b && a->dtype == b->dtype && a->rank == b->rank && a->size == b->size);
        assert_memory_equal(a->shape, b->shape, a->rank * sizeof *a->shape);
        assert_memory_equal(a->data, b->data, a->size);
        assert_int_equal((uintptr_t)b->data % lf_dtype_size(b->dtype), 0);
    }
    lf_tensors_finish(&in);
    lf_tensors_finish(&out);
}

// Every byte matters, and every length but the right one is refused.
static void damage_is_found(void **state)
{
    NG_UNUSED(state);
    struct lf_tensors t;
    struct test_log log;
    char path[512];
    void *data;
    size_t size;
    test_path(path, sizeof path, "damage.safetensors");
    fill_tensors(&t);
    OK(lf_tensors_write(&t, path));
    lf_tensors_finish(&t);
    OK(ng_file_read(path, 0, &data, &size));
    unsigned char *bytes = data;
    for (size_t i = 0; i < size; i += 3) {
        bytes[i] ^= 4;
        OK(ng_file_write(path, bytes, size));
        test_log_begin(&log);
        assert_int_equal(lf_tensors_read(path, &t), NG_ERROR_FORMAT);
        test_log_end(&log);
        assert_int_equal(log.errors, 1);
        assert_null(t.file);
        bytes[i] ^= 4;
    }
    for (size_t n = 0; n < size; n += 7) {
        OK(ng_file_write(path, bytes, n));
        test_log_begin(&log);
        assert_int_equal(lf_tensors_read(path, &t), NG_ERROR_FORMAT);
        test_log_end(&log);
        assert_int_equal(log.errors, 1);
    }
    free(data);
}

// A file whose checksum is right may still be made by an enemy.
static void headers_are_not_trusted(void **state)
{
    NG_UNUSED(state);
    static const struct {
        const char *find, *put;
    } wrong[] = {
        {"\"F32\"", "\"F64\""},     // a type that we do not have
        {"[2,3]", "[3,3]"},         // larger than its data
        {"[2,3]", "[2,3"},          // not JSON
        {",24]", ",28]"},           // reaches into the next
        {"[0,24]", "[4,28]"},       // a gap
        {"\"shape\"", "\"shapo\""}, // a member that is not of the format
        {"7/mask", "7/empty"},      // twice the same name
        {"[5]", "[9]"},             // past the end
    };
    struct lf_tensors t;
    char path[512];
    void *data;
    size_t size;
    test_path(path, sizeof path, "enemy.safetensors");
    fill_tensors(&t);
    OK(lf_tensors_write(&t, path));
    lf_tensors_finish(&t);
    OK(ng_file_read(path, 0, &data, &size));
    for (size_t i = 0; i < NG_COUNT(wrong); i++) {
        unsigned char *copy = malloc(size + 1), *at = NULL;
        struct test_log log;
        size_t n = strlen(wrong[i].find), m = strlen(wrong[i].put), digits = 8 + 25;
        assert_non_null(copy);
        memcpy(copy, data, size + 1);
        for (size_t k = 8; k + n < size && !at; k++)
            if (memcmp(copy + k, wrong[i].find, n) == 0)
                at = copy + k;
        assert_non_null(at);
        // Keep the header's length: what follows in the header moves over the padding.
        uint64_t header = 0;
        for (int b = 0; b < 8; b++)
            header |= (uint64_t)copy[b] << (8 * b);
        memmove(at + m, at + n, (size_t)(copy + 8 + header - (at + (m > n ? m : n))));
        memcpy(at, wrong[i].put, m);
        OK(ng_file_write(path, copy, size));
        test_log_begin(&log);
        assert_int_equal(lf_tensors_read(path, &t), NG_ERROR_FORMAT); // the checksum
        test_log_end(&log);
        // With the checksum that it should have, as the reader computes it.
        memset(copy + digits, '0', 16);
        char hash[17];
        snprintf(hash, sizeof hash, "%016llx", (unsigned long long)ng_hash_bytes(0, copy, size));
        memcpy(copy + digits, hash, 16);
        OK(ng_file_write(path, copy, size));
        test_log_begin(&log);
        ng_result result = lf_tensors_read(path, &t);
        test_log_end(&log);
        if (result != NG_ERROR_FORMAT || !strstr(log.text, "header"))
            fail_msg("%s for %s: %d, %s", wrong[i].put, wrong[i].find, result, log.text);
        free(copy);
    }
    free(data);
}

static void too_much_is_refused(void **state)
{
    NG_UNUSED(state);
    struct lf_tensors t = {0};
    struct test_log log;
    test_log_begin(&log);
    assert_null(lf_tensors_add(&t, "a", LF_F32, 3, (const uint64_t[]){1u << 31, 1u << 31, 4}));
    assert_null(lf_tensors_add(&t, "a", LF_F32, 1, (const uint64_t[]){(1u << 29) + 1}));
    test_log_end(&log);
    assert_int_equal(log.errors, 2);
    lf_tensors_finish(&t);
}

static void json_that_is_refused(void **state)
{
    NG_UNUSED(state);
    static const char *const texts[] = {
        "",
        "{",
        "}",
        "{\"a\"}",
        "{\"a\":}",
        "{\"a\":1,}",
        "{,}",
        "{\"a\":1 \"b\":2}",
        "{\"a\":1}x",
        "{\"a\":\"\\u0041\"}",
        "{\"a\":\"\n\"}",
        "{\"a\":99999999999999999}",
        "{\"a\":-1}",
        "{\"a\":[1,2}",
        "[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]",
        "{\"a\":\"b",
    };
    for (size_t i = 0; i < NG_COUNT(texts); i++) {
        struct lf_json j = lf_json_begin(texts[i], strlen(texts[i]));
        lf_json_skip(&j);
        if (lf_json_end(&j))
            fail_msg("%s was taken", texts[i]);
    }
    static const char good[] = " { \"a\" : [ ] , \"b\" : { } , \"c\" : [ 1 , \"x\\n\" ] } ";
    struct lf_json j = lf_json_begin(good, sizeof good - 1);
    assert_true(lf_json_skip(&j) && lf_json_end(&j));
}

// ---- manifest --------------------------------------------------------------------------------------------

static void shards_are_kept_in_order(void **state)
{
    NG_UNUSED(state);
    struct lf_manifest m = {0}, again;
    char directory[512];
    test_path(directory, sizeof directory, "manifest");
    OK(ng_file_make_directory(directory));
    for (int i = 0; i < LF_SETTING_COUNT; i++) {
        snprintf(m.settings.items[i].key, sizeof m.settings.items[i].key, "key%d", i);
        snprintf(m.settings.items[i].value, sizeof m.settings.items[i].value, "value %d", i);
    }
    OK(lf_manifest_put(&m, &(struct lf_shard){.first_seed = 32, .samples = 16, .hash = 3}));
    OK(lf_manifest_put(&m, &(struct lf_shard){.first_seed = 0, .samples = 16, .hash = 1}));
    OK(lf_manifest_put(&m, &(struct lf_shard){.first_seed = 16, .samples = 5, .hash = 2}));
    OK(lf_manifest_put(&m, &(struct lf_shard){.first_seed = 16, .samples = 16, .hash = UINT64_MAX}));
    OK(lf_manifest_write(directory, &m));
    OK(lf_manifest_read(directory, &again));
    assert_int_equal(again.shards.count, 3);
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(again.shards.items[i].first_seed, 16 * i);
        assert_int_equal(again.shards.items[i].samples, 16);
        assert_true(again.shards.items[i].hash == m.shards.items[i].hash);
    }
    assert_null(lf_settings_difference(&m.settings, &again.settings));
    strcpy(again.settings.items[3].value, "other");
    assert_ptr_equal(lf_settings_difference(&m.settings, &again.settings), &m.settings.items[3]);
    lf_manifest_finish(&again);
    lf_manifest_finish(&m);
}

static void broken_manifests_are_refused(void **state)
{
    NG_UNUSED(state);
    static const char *const texts[] = {"", "{}", "[]", "{\"settings\": {}, \"shards\": []}",
                                        "{\"shards\": [{\"first_seed\": 0, \"samples\": 0}]}"};
    char directory[512], path[600];
    struct lf_manifest m;
    test_path(directory, sizeof directory, "broken");
    OK(ng_file_make_directory(directory));
    snprintf(path, sizeof path, "%s/manifest.json", directory);
    remove(path);
    assert_int_equal(lf_manifest_read(directory, &m), NG_ERROR_NOT_FOUND);
    for (size_t i = 0; i < NG_COUNT(texts); i++) {
        struct test_log log;
        OK(ng_file_write(path, texts[i], strlen(texts[i])));
        test_log_begin(&log);
        assert_int_equal(lf_manifest_read(directory, &m), NG_ERROR_FORMAT);
        test_log_end(&log);
        assert_int_equal(log.errors, 1);
    }
}

// ---- lookups ---------------------------------------------------------------------------------------------
// A wall at distance 4 along an axis of the light and a square in front of it at 1.5, half a metre wide,
// which throws a shadow of 0.25 / 1.5 * 4 = 0.667 metres half width onto the wall.
#define FACE 256u
#define NEAR 0.01f

static float *new_map(uint32_t layers)
{
    float *depth = calloc((size_t)layers * FACE * FACE, sizeof *depth);
    assert_non_null(depth);
    return depth;
}

static void paint_perspective(float *layer)
{
    for (uint32_t y = 0; y < FACE; y++)
        for (uint32_t x = 0; x < FACE; x++) {
            float a = ((float)x + 0.5f) / FACE * 2 - 1, b = ((float)y + 0.5f) / FACE * 2 - 1;
            bool square = fabsf(a) * 1.5f < 0.25f && fabsf(b) * 1.5f < 0.25f;
            layer[y * FACE + x] = NEAR / (square ? 1.5f : 4.0f);
        }
}

static void a_square_before_a_wall(void **state)
{
    NG_UNUSED(state);
    float *depth = new_map(2);
    // Looks along world -Z from (1, 2, 3): layer 1 of the face +look, and layer 0 of -right (world -X), which
    // sees a wall at 4 with a square as well.
    struct ng_light_data light = {.proxy = {1, 2, 3},
                                  .look = {0, 0, -1},
                                  .right = {1, 0, 0},
                                  .up = {0, 1, 0},
                                  .tangent = 1,
                                  .depth_range = NEAR};
    light.layers = 2u | 1u << 16;
    paint_perspective(depth);
    paint_perspective(depth + (size_t)FACE * FACE);
    const struct lf_depth_map map = {&light, depth, 2, FACE};
    for (int i = -19; i <= 19; i++)
        for (int k = -19; k <= 19; k++) {
            float x = 0.1f * (float)i, y = 0.1f * (float)k; // on the wall
            bool edge = fabsf(fmaxf(fabsf(x), fabsf(y)) - 2.0f / 3) < 0.04f;
            bool shadowed = fmaxf(fabsf(x), fabsf(y)) < 2.0f / 3;
            struct lf_shadow_distance s = lf_shadow_lookup(&map, (const float[]){1 + x, 2 + y, 3 - 4});
            struct lf_shadow_distance side = lf_shadow_lookup(&map, (const float[]){1 - 4, 2 + y, 3 + x});
            float length = sqrtf(16 + x * x + y * y), expected = shadowed ? length * 1.5f / 4 : length;
            assert_true(fabsf(s.receiver - length) < 1e-5f && fabsf(side.receiver - length) < 1e-5f);
            if (edge)
                continue;
            assert_true(fabsf(s.occluder - expected) < 0.02f); // a texel is 4 / 128 m wide at the wall
            assert_true(fabsf(side.occluder - expected) < 0.02f);
        }
    // The square itself is lit: d = d_f.
    struct lf_shadow_distance lit = lf_shadow_lookup(&map, (const float[]){1.1f, 2.05f, 1.5f});
    assert_true(fabsf(lit.receiver - lit.occluder) < 0.01f);
    // A face that is not there, and what the map does not reach.
    struct lf_shadow_distance behind = lf_shadow_lookup(&map, (const float[]){1, 2, 9});
    assert_true(behind.receiver == 6 && behind.occluder == 6);
    light.tangent = 0.5f;
    light.layers = 2;
    struct lf_shadow_distance outside = lf_shadow_lookup(&map, (const float[]){1 + 3, 2, 3 - 4});
    assert_true(outside.occluder == outside.receiver && outside.receiver == 5);
    free(depth);
}

// Which way is up in a picture: the texel to the right and up of the middle is seen by points to the right
// and up.
static void faces_are_the_right_way_round(void **state)
{
    NG_UNUSED(state);
    float *depth = new_map(1);
    struct ng_light_data light = {
        .look = {0, 0, -1}, .right = {1, 0, 0}, .up = {0, 1, 0}, .tangent = 1, .depth_range = NEAR};
    const struct lf_depth_map map = {&light, depth, 1, FACE};
    // An occluder at 1 in the upper right quarter of the picture.
    for (uint32_t y = 0; y < FACE; y++)
        for (uint32_t x = 0; x < FACE; x++)
            depth[y * FACE + x] = NEAR / (x >= FACE / 2 && y < FACE / 2 ? 1.0f : 10.0f);
    const float axes[3][3] = {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}}; // look, right, up in the world
    for (int face = 0; face < 6; face++) {
        int k = face % 3;
        float side = face < 3 ? 1.0f : -1.0f, p[3];
        light.layers = 1u << (4 * face);
        for (int c = 0; c < 3; c++) // axis k + 1 is to the right (turned on opposite faces), k + 2 up
            p[c] = 4 * side * axes[k][c] + side * axes[(k + 1) % 3][c] + axes[(k + 2) % 3][c];
        assert_true(lf_shadow_lookup(&map, p).occluder < 1.5f);
        for (int c = 0; c < 3; c++)
            p[c] = 4 * side * axes[k][c] - side * axes[(k + 1) % 3][c] + axes[(k + 2) % 3][c];
        assert_true(lf_shadow_lookup(&map, p).occluder > 4);
        for (int c = 0; c < 3; c++)
            p[c] = 4 * side * axes[k][c] + side * axes[(k + 1) % 3][c] - axes[(k + 2) % 3][c];
        assert_true(lf_shadow_lookup(&map, p).occluder > 4);
    }
    free(depth);
}

// The sun, straight down: a slab of depth 10 that begins 5 above the ground, a square of 1 metre hovering
// at 2.
static void parallel_light(void **state)
{
    NG_UNUSED(state);
    float *depth = new_map(2);
    struct ng_light_data light = {.proxy = {0, 5, 0},
                                  .look = {0, -1, 0},
                                  .right = {1, 0, 0},
                                  .up = {0, 0, -1},
                                  .depth_range = 10,
                                  .window_count = 2};
    memcpy(light.windows[0], (const float[]){0, 0, 2, 0}, sizeof light.windows[0]);
    memcpy(light.windows[1], (const float[]){0, 0, 8, 0}, sizeof light.windows[1]);
    for (uint32_t w = 0; w < 2; w++)
        for (uint32_t y = 0; y < FACE; y++)
            for (uint32_t x = 0; x < FACE; x++) {
                float a = (((float)x + 0.5f) / FACE * 2 - 1) * light.windows[w][2],
                      b = (((float)y + 0.5f) / FACE * 2 - 1) * light.windows[w][2];
                bool square = fabsf(a) < 0.5f && fabsf(b - 1) < 0.5f; // picture down is world +z
                depth[(w * FACE + y) * FACE + x] = 1 - (square ? 3.0f : 5.0f) / 10;
            }
    const struct lf_depth_map map = {&light, depth, 2, FACE};
    struct lf_shadow_distance under = lf_shadow_lookup(&map, (const float[]){0.2f, 0, 1.2f});
    assert_true(fabsf(under.receiver - 5) < 1e-5f && fabsf(under.occluder - 3) < 1e-5f);
    struct lf_shadow_distance open = lf_shadow_lookup(&map, (const float[]){0.2f, 0, -1.2f});
    assert_true(fabsf(open.receiver - 5) < 1e-5f && fabsf(open.occluder - 5) < 1e-5f);
    struct lf_shadow_distance far =
        lf_shadow_lookup(&map, (const float[]){5, 0, 5}); // in the second window alone
    assert_true(fabsf(far.occluder - 5) < 1e-5f);
    struct lf_shadow_distance outside = lf_shadow_lookup(&map, (const float[]){9, 1, 0});
    assert_true(outside.occluder == outside.receiver && fabsf(outside.receiver - 4) < 1e-5f);
    free(depth);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_written_is_read),       cmocka_unit_test(damage_is_found),
        cmocka_unit_test(headers_are_not_trusted),       cmocka_unit_test(too_much_is_refused),
        cmocka_unit_test(json_that_is_refused),          cmocka_unit_test(shards_are_kept_in_order),
        cmocka_unit_test(broken_manifests_are_refused),  cmocka_unit_test(a_square_before_a_wall),
        cmocka_unit_test(faces_are_the_right_way_round), cmocka_unit_test(parallel_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

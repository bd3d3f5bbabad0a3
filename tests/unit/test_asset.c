#include "test.h"

#include "asset/assets.h"
#include "asset/geometry.h"
#include "asset/hdr.h"
#include "asset/image.h"
#include "asset/jpeg.h"
#include "asset/png.h"
#include "base/file.h"

#include <math.h>

// ---- the store -------------------------------------------------------------------------------------------

static ng_asset add_image(struct ng_assets *a, uint32_t width)
{
    struct ng_image image = {
        .width = width, .height = 1, .levels = 1, .pixels = calloc(width, 4), .size = width * 4};
    ng_asset id;
    assert_int_equal(ng_assets_take_image(a, "image", &image, &id), NG_OK);
    assert_null(image.pixels); // moved
    return id;
}

static void test_store(void **state)
{
    NG_UNUSED(state);
    struct ng_assets *a;
    assert_int_equal(ng_assets_create(&a), NG_OK);
    ng_asset x = add_image(a, 1), y = add_image(a, 2), z = add_image(a, 3), clip, next = {0};
    const struct ng_image *kept = ng_assets_image(a, z);
    struct ng_clip empty = {.duration = 5};
    assert_int_equal(ng_assets_take_clip(a, NULL, &empty, &clip), NG_OK);
    for (int i = 0; i < 100; i++)
        add_image(a, 4);
    assert_ptr_equal(ng_assets_image(a, z), kept); // pointers survive growth
    assert_null(ng_assets_image(a, clip));         // another kind
    assert_float_equal(ng_assets_clip(a, clip)->duration, 5, 0);
    assert_string_equal(ng_assets_name(a, clip), "");
    assert_int_equal(ng_assets_memory(a), (1 + 2 + 3 + 400) * 4);
    assert_true(ng_assets_remove(a, y));
    assert_false(ng_assets_remove(a, y));
    assert_null(ng_assets_image(a, y));
    assert_null(ng_assets_name(a, y));
    next = ng_assets_next(a, NG_ASSET_IMAGE, next);
    assert_int_equal(next.id, x.id);
    next = ng_assets_next(a, NG_ASSET_IMAGE, next);
    assert_int_equal(next.id, z.id);
    assert_int_equal(ng_assets_next(a, NG_ASSET_CLIP, clip).id, 0);
    assert_int_equal(ng_assets_next(a, NG_ASSET_IMAGE, y).id, 0); // stale
    ng_asset again = add_image(a, 9);                             // takes y's slot
    assert_int_not_equal(again.id, y.id);
    assert_null(ng_assets_image(a, y));
    ng_assets_destroy(&a);
    ng_assets_destroy(&a);
}

// ---- geometry --------------------------------------------------------------------------------------------

static void *copy(const void *from, size_t size)
{
    void *to = malloc(size);
    assert_non_null(to);
    return memcpy(to, from, size);
}

// Two triangles that share an edge and stand at a right angle.
static struct ng_geometry make_fold(void)
{
    static const float positions[] = {0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1};
    static const uint32_t indices[] = {0, 2, 1, 0, 1, 3};
    struct ng_geometry g = {.vertex_count = 4, .index_count = 6};
    g.positions = copy(positions, sizeof positions);
    g.indices = copy(indices, sizeof indices);
    return g;
}

static void test_flat_normals(void **state)
{
    NG_UNUSED(state);
    struct ng_geometry g = make_fold();
    assert_int_equal(ng_geometry_complete(&g), NG_OK);
    assert_int_equal(g.vertex_count, 6);
    for (uint32_t i = 0; i < 6; i++) {
        assert_float_equal(g.normals[i * 3 + 2], i < 3, 1e-6);
        assert_float_equal(g.normals[i * 3], i >= 3, 1e-6);
        const float *t = g.tangents + i * 4, *n = g.normals + i * 3;
        assert_float_equal(t[0] * t[0] + t[1] * t[1] + t[2] * t[2], 1, 1e-5);
        assert_float_equal(t[0] * n[0] + t[1] * n[1] + t[2] * n[2], 0, 1e-6);
    }
    assert_float_equal(g.bounds_max[2], 1, 0);
    assert_int_equal(ng_geometry_size(&g), 6 * (12 + 12 + 16 + 8) + 6 * 4);
    ng_geometry_finish(&g);
}

static void test_degenerate_triangle(void **state)
{
    NG_UNUSED(state);
    struct ng_geometry g = make_fold();
    g.indices[4] = g.indices[3];
    assert_int_equal(ng_geometry_complete(&g), NG_OK);
    for (uint32_t i = 0; i < g.vertex_count * 4; i++)
        assert_true(isfinite(g.tangents[i]));
    ng_geometry_finish(&g);
}

// Green of a normal map is up (glTF 2.0, 3.9.3): on a picture that hangs upright, the bitangent points to its
// top, although v grows downwards; and also where u runs backwards.
static void test_tangents(void **state)
{
    NG_UNUSED(state);
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t indices[] = {0, 1, 2};
    for (int backwards = 0; backwards < 2; backwards++) {
        const float left = (float)backwards, right = 1 - left, uvs[] = {left, 1, right, 1, left, 0};
        struct ng_geometry g = {.vertex_count = 3, .index_count = 3};
        g.positions = copy(positions, sizeof positions);
        g.indices = copy(indices, sizeof indices);
        g.uvs = copy(uvs, sizeof uvs);
        assert_int_equal(ng_geometry_complete(&g), NG_OK);
        for (uint32_t i = 0; i < 3; i++) {
            const float *t = g.tangents + i * 4;
            assert_float_equal(t[0], right - left, 1e-6);
            assert_float_equal(t[3] * t[0], 1, 1e-6); // the bitangent's y: n is +Z
        }
        ng_geometry_finish(&g);
    }
}

// ---- pictures --------------------------------------------------------------------------------------------

static void *read_back(const char *path, size_t *size)
{
    void *data;
    assert_int_equal(ng_file_read(path, 0, &data, size), NG_OK);
    return data;
}

static void test_png(void **state)
{
    NG_UNUSED(state);
    char path[512];
    unsigned char pixels[5 * 3 * 3];
    for (size_t i = 0; i < sizeof pixels; i++)
        pixels[i] = (unsigned char)(i * 5);
    const struct ng_png_text texts[] = {{"Command", "render chess"}, {"Title", "Schach \xe2\x99\x9e"}};
    const struct ng_png_params params = {5, 3, 3, pixels, texts, 2};
    test_path(path, sizeof path, "a.png");
    assert_int_equal(ng_png_write(path, &params), NG_OK);
    size_t size;
    void *data = read_back(path, &size);
    struct ng_image image;
    assert_int_equal(ng_image_decode("a", data, size, &(struct ng_image_params){.no_mips = true}, &image),
                     NG_OK);
    assert_int_equal(image.width, 5);
    assert_int_equal(image.levels, 1);
    for (size_t i = 0; i < 15; i++) {
        assert_memory_equal((unsigned char *)image.pixels + i * 4, pixels + i * 3, 3);
        assert_int_equal(((unsigned char *)image.pixels)[i * 4 + 3], 255);
    }
    char *command = ng_png_text(data, size, "Command"), *title = ng_png_text(data, size, "Title");
    assert_string_equal(command, "render chess");
    assert_string_equal(title, "Schach \xe2\x99\x9e");
    assert_null(ng_png_text(data, size, "Date"));
    free(command);
    free(title);
    ng_image_finish(&image);
    free(data);
}

// Black and white mix to half the light, which is not half the sRGB value.
static void test_mips_in_linear_light(void **state)
{
    NG_UNUSED(state);
    unsigned char pixels[] = {0, 0, 0, 255, 255, 255, 255, 255};
    struct ng_image image = {.width = 2, .height = 1, .levels = 1, .format = NG_PIXEL_RGBA8_SRGB, .size = 8};
    image.pixels = malloc(8);
    memcpy(image.pixels, pixels, 8);
    assert_int_equal(ng_image_make_mips(&image), NG_OK);
    assert_int_equal(image.levels, 2);
    const unsigned char *mean = ng_image_level(&image, 1, NULL, NULL);
    assert_int_equal(mean[0], 188);
    assert_int_equal(mean[3], 255);
    ng_image_finish(&image);
}

// The mean of an image with odd sides survives all levels.
static void test_mips_of_odd_sizes(void **state)
{
    NG_UNUSED(state);
    enum { W = 7, H = 5 };
    struct ng_image image = {
        .width = W, .height = H, .levels = 1, .format = NG_PIXEL_RGBA32F, .size = W * H * 16};
    float *p = image.pixels = malloc(image.size), mean = 0;
    for (int i = 0; i < W * H * 4; i++) {
        p[i] = (float)(i * i % 17);
        mean += i % 4 == 0 ? p[i] / (W * H) : 0;
    }
    assert_int_equal(ng_image_make_mips(&image), NG_OK);
    uint32_t w, h;
    assert_int_equal(image.levels, 3);
    const float *last = ng_image_level(&image, 2, &w, &h);
    assert_int_equal(w * h, 1);
    assert_float_equal(last[0], mean, 1e-4);
    ng_image_finish(&image);
}

static const char hdr_header[] = "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n";

static ng_result decode_hdr(const char *size, const void *pixels, size_t bytes, struct ng_image *out)
{
    unsigned char file[512];
    size_t n = (size_t)snprintf((char *)file, sizeof file, "%s%s\n", hdr_header, size);
    memcpy(file + n, pixels, bytes);
    return ng_image_decode("sky.hdr", file, n + bytes, &(struct ng_image_params){.no_mips = true}, out);
}

static void test_hdr(void **state)
{
    NG_UNUSED(state);
    struct ng_image image;
    // Flat, with an old run: 1 1 1 n repeats the last pixel n times.
    static const unsigned char flat[] = {128, 64, 0, 129, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0};
    assert_int_equal(decode_hdr("-Y 2 +X 2", flat, sizeof flat, &image), NG_OK);
    const float *p = image.pixels;
    assert_float_equal(p[0], 0.5, 1e-6); // 128 * 2^(129 - 136) / 2
    assert_float_equal(p[1], 0.25, 1e-6);
    assert_float_equal(p[4], 0.5, 1e-6);
    assert_float_equal(p[8], 0, 0);
    ng_image_finish(&image);
    // New runs: each component in turn; a run of 8, then literals.
    static const unsigned char runs[] = {2, 2, 0, 8, 136, 128, 8, 1, 2, 3, 4, 5, 6, 7, 8, 136, 0, 136, 129};
    assert_int_equal(decode_hdr("-Y 1 +X 8", runs, sizeof runs, &image), NG_OK);
    p = image.pixels;
    assert_float_equal(p[7 * 4], 0.5, 1e-6);
    assert_float_equal(p[7 * 4 + 1], 8.0 / 256, 1e-6);
    ng_image_finish(&image);
}

static void expect_refused(const char *size, const void *pixels, size_t bytes, const char *message)
{
    struct ng_image image;
    struct test_log log;
    test_log_begin(&log);
    assert_int_not_equal(decode_hdr(size, pixels, bytes, &image), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    if (!strstr(log.text, message))
        fail_msg("\"%s\" is not in \"%s\"", message, log.text);
}

static void test_bad_hdr(void **state)
{
    NG_UNUSED(state);
    static const unsigned char over[] = {2, 2, 0, 8, 137, 1}, repeat[] = {1, 1, 1, 200};
    expect_refused("-Y 1 +X 8", over, sizeof over, "scan line");
    expect_refused("-Y 1 +X 8", over, 4, "scan line");
    expect_refused("-Y 1 +X 2", repeat, 4, "scan line");
    expect_refused("-Y 1 +X 2", repeat, 0, "scan line");
    expect_refused("+X 2 -Y 1", repeat, 4, "size is not of the form");
    expect_refused("-Y 99999 +X 99999", repeat, 4, "99999 x 99999 pixels");
    expect_refused("-Y 0 +X 4", repeat, 4, "0 pixels");
}

// Two blocks, light grey and dark grey.
static void test_jpeg(void **state)
{
    NG_UNUSED(state);
    size_t size;
    void *data = read_back("tests/files/good/grey.jpg", &size);
    struct ng_image image;
    struct test_log log;
    assert_int_equal(ng_image_decode("grey", data, size, &(struct ng_image_params){.srgb = true}, &image),
                     NG_OK);
    assert_int_equal(image.width, 16);
    assert_int_equal(image.height, 8);
    assert_int_equal(image.levels, 5);
    const unsigned char *p = image.pixels;
    assert_in_range(p[0], 198, 202);
    assert_in_range(p[15 * 4 + 2], 48, 52);
    assert_int_equal(p[3], 255);
    ng_image_finish(&image);
    test_log_begin(&log);
    for (size_t n = 0; n < size - 2; n++)
        assert_int_not_equal(ng_jpeg_decode("cut", data, n, &(struct ng_image_params){0}, &image), NG_OK);
    ng_result r = ng_jpeg_decode("grey", data, size, &(struct ng_image_params){.max_side = 8}, &image);
    test_log_end(&log);
    assert_int_equal(r, NG_ERROR_UNSUPPORTED);
    free(data);
}

// Flipped bits in each format: an error or a picture, never more.
static void test_damage(void **state)
{
    NG_UNUSED(state);
    static const char *const files[] = {"tests/files/good/grey.jpg", "tests/files/good/interlaced.png"};
    struct test_log log;
    test_log_begin(&log);
    for (size_t f = 0; f < NG_COUNT(files); f++) {
        size_t size;
        unsigned char *data = read_back(files[f], &size);
        for (size_t i = 0; i < size * 8; i++) {
            struct ng_image image;
            data[i / 8] ^= (unsigned char)(1u << (i % 8));
            if (ng_image_decode("flipped", data, size, &(struct ng_image_params){.max_side = 64}, &image) ==
                NG_OK)
                ng_image_finish(&image);
            data[i / 8] ^= (unsigned char)(1u << (i % 8));
        }
        free(data);
    }
    test_log_end(&log);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_store),
        cmocka_unit_test(test_flat_normals),
        cmocka_unit_test(test_degenerate_triangle),
        cmocka_unit_test(test_tangents),
        cmocka_unit_test(test_png),
        cmocka_unit_test(test_mips_in_linear_light),
        cmocka_unit_test(test_mips_of_odd_sizes),
        cmocka_unit_test(test_hdr),
        cmocka_unit_test(test_bad_hdr),
        cmocka_unit_test(test_jpeg),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

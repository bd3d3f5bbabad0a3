#include "test.h"

#include "asset/exr.h"
#include "asset/image.h"
#include "asset/png.h"
#include "base/file.h"
#include "base/rng.h"

#include <math.h>

enum { WIDTH = 37, HEIGHT = 41 }; // odd sizes: the last chunk is partial

// Five channels over one interleaved and two planar arrays.
static void write_picture(const char *path)
{
    static float rgb[WIDTH * HEIGHT * 3], depth[WIDTH * HEIGHT];
    static uint32_t id[WIDTH * HEIGHT];
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        rgb[i * 3] = (float)i * 0.25f;
        rgb[i * 3 + 1] = 1e6f; // over the largest half
        rgb[i * 3 + 2] = -0.5f;
        depth[i] = 1.0f / (float)(i + 3);
        id[i] = 4000000000u - (uint32_t)i;
    }
    const struct ng_exr_channel channels[] = {
        {"R", NG_EXR_HALF, rgb, 3},        {"G", NG_EXR_HALF, rgb + 1, 3},
        {"B", NG_EXR_FLOAT, rgb + 2, 3},   {"depth.Z", NG_EXR_FLOAT, depth, 0},
        {"entity.id", NG_EXR_UINT, id, 0},
    };
    const struct ng_exr_text texts[] = {{"command", "render chess"}, {"scene", "0123"}};
    const struct ng_exr_params params = {WIDTH, HEIGHT, channels, NG_COUNT(channels), texts, NG_COUNT(texts)};
    assert_int_equal(ng_exr_write(path, &params), NG_OK);
}

static void test_round_trip(void **state)
{
    NG_UNUSED(state);
    char path[512];
    test_path(path, sizeof path, "layers.exr");
    write_picture(path);
    struct ng_exr exr;
    assert_int_equal(ng_exr_read(path, NULL, &exr), NG_OK);
    assert_int_equal(exr.width, WIDTH);
    assert_int_equal(exr.height, HEIGHT);
    assert_int_equal(exr.plane_count, 5);
    const float *r = ng_exr_plane(&exr, "R")->pixels, *g = ng_exr_plane(&exr, "G")->pixels;
    const float *z = ng_exr_plane(&exr, "depth.Z")->pixels;
    const uint32_t *id = ng_exr_plane(&exr, "entity.id")->pixels;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_float_equal(r[i], (float)i * 0.25f, (float)i * 0.25f / 1024);
        assert_true(g[i] == 65504.0f);
        assert_true(z[i] == 1.0f / (float)(i + 3));
        assert_true(id[i] == 4000000000u - (uint32_t)i);
    }
    assert_string_equal(ng_exr_text(&exr, "command"), "render chess");
    assert_null(ng_exr_text(&exr, "date"));
    assert_null(ng_exr_plane(&exr, "A"));
    ng_exr_finish(&exr);
}

static void test_same_bytes(void **state)
{
    NG_UNUSED(state);
    char a[512], b[512];
    void *x, *y;
    size_t n, m;
    test_path(a, sizeof a, "a.exr");
    test_path(b, sizeof b, "b.exr");
    write_picture(a);
    write_picture(b);
    assert_int_equal(ng_file_read(a, 0, &x, &n), NG_OK);
    assert_int_equal(ng_file_read(b, 0, &y, &m), NG_OK);
    assert_int_equal(n, m);
    assert_memory_equal(x, y, n);
    free(x);
    free(y);
}

// Lines of noise that a compressor makes about as long as they are: a byte shorter, equal, or longer.
static void test_what_compression_makes_no_shorter(void **state)
{
    NG_UNUSED(state);
    struct ng_rng rng = ng_rng_make(1, 0);
    for (uint32_t n = 0; n < 2000; n++) {
        uint32_t noise[64], width = 24 + n % 8;
        for (uint32_t i = 0; i < width; i++)
            noise[i] = ng_rng_u32(&rng) & (i < 4 + n % 9 ? 0xffu : 0xffffffffu);
        const struct ng_exr_channel channel = {"id", NG_EXR_UINT, noise, 0};
        const struct ng_exr_params params = {
            .width = width, .height = 1, .channels = &channel, .channel_count = 1};
        struct ng_exr exr;
        void *data;
        size_t size;
        assert_int_equal(ng_exr_encode("noise", &params, &data, &size), NG_OK);
        assert_int_equal(ng_exr_decode("noise", data, size, NULL, &exr), NG_OK);
        assert_memory_equal(ng_exr_plane(&exr, "id")->pixels, noise, width * sizeof *noise);
        ng_exr_finish(&exr);
        free(data);
    }
}

static void test_full_disk(void **state)
{
    NG_UNUSED(state);
    struct test_log log;
    float pixel = 1;
    const struct ng_exr_channel channel = {"Y", NG_EXR_FLOAT, &pixel, 0};
    const struct ng_exr_params params = {.width = 1, .height = 1, .channels = &channel, .channel_count = 1};
    test_log_begin(&log);
    assert_int_not_equal(ng_exr_write("/proc/no/such/place.exr", &params), NG_OK);
    test_log_end(&log);
    assert_int_equal(log.errors, 1);
    assert_non_null(strstr(log.text, "/proc/no/such/place.exr"));
}

static void put(unsigned char **at, const void *data, size_t size)
{
    memcpy(*at, data, size);
    *at += size;
}

static void put_attribute(unsigned char **at, const char *name, const char *type, const void *data,
                          int32_t size)
{
    put(at, name, strlen(name) + 1);
    put(at, type, strlen(type) + 1);
    put(at, &size, 4);
    put(at, data, (size_t)size);
}

// A header by hand, so that compressions and sizes can be had that the writer does not make.
static size_t make_header(unsigned char *out, unsigned char compression, int32_t width, int32_t height)
{
    unsigned char *at = out;
    const unsigned char channel[] = {'Y', 0, 2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0};
    const int32_t window[4] = {0, 0, width - 1, height - 1};
    const float one = 1, zero[2] = {0, 0};
    const unsigned char order = 0, end = 0;
    put(&at, "\x76\x2f\x31\x01\x02\0\0\0", 8);
    put_attribute(&at, "channels", "chlist", channel, sizeof channel);
    put_attribute(&at, "compression", "compression", &compression, 1);
    put_attribute(&at, "dataWindow", "box2i", window, 16);
    put_attribute(&at, "displayWindow", "box2i", window, 16);
    put_attribute(&at, "lineOrder", "lineOrder", &order, 1);
    put_attribute(&at, "pixelAspectRatio", "float", &one, 4);
    put_attribute(&at, "screenWindowCenter", "v2f", zero, 8);
    put_attribute(&at, "screenWindowWidth", "float", &one, 4);
    put(&at, &end, 1);
    return (size_t)(at - out);
}

static void expect_refused(const void *data, size_t size, const char *message)
{
    struct test_log log;
    struct ng_exr exr;
    test_log_begin(&log);
    ng_result r = ng_exr_decode("bad.exr", data, size, NULL, &exr);
    test_log_end(&log);
    assert_int_not_equal(r, NG_OK);
    assert_int_equal(log.errors, 1);
    if (!strstr(log.text, message))
        fail_msg("\"%s\" is not in \"%s\"", message, log.text);
    assert_null(exr.planes);
}

static void test_refused(void **state)
{
    NG_UNUSED(state);
    unsigned char data[8192] = {0};
    size_t header = make_header(data, 8, 4, 4);
    expect_refused(data, header + 1024, "DWAA");
    make_header(data, 9, 4, 4);
    expect_refused(data, header + 1024, "DWAB");
    make_header(data, 3, 100000, 10000);
    expect_refused(data, sizeof data, "100000 x 10000 pixels");
    make_header(data, 0, 4, 4); // the table of chunks points nowhere
    expect_refused(data, header + 4 * 8, "OpenEXR");
    expect_refused(data, header / 2, "OpenEXR");
    expect_refused("\x76\x2f\x31\x01", 4, "OpenEXR");
}

// Every truncation, and many flips, of a good file: an error or a picture, never more.
static void test_damage(void **state)
{
    NG_UNUSED(state);
    char path[512];
    void *data;
    size_t size;
    struct test_log log;
    struct ng_exr exr;
    test_path(path, sizeof path, "damage.exr");
    write_picture(path);
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    test_log_begin(&log);
    for (size_t n = 0; n < size; n += 13)
        assert_int_not_equal(ng_exr_decode("cut", data, n, NULL, &exr), NG_OK);
    unsigned char *bytes = data;
    for (uint32_t i = 0; i < 3000; i++) {
        size_t at = i < 1000 ? i : (i * 2654435761u);
        at %= size ? size : 1;
        unsigned char old = bytes[at];
        bytes[at] = (unsigned char)(old ^ (1u << (i % 8)));
        if (ng_exr_decode("flipped", data, size,
                          &(struct ng_exr_limits){.max_side = 4096, .max_memory = 1 << 24}, &exr) == NG_OK)
            ng_exr_finish(&exr);
        bytes[at] = old;
    }
    test_log_end(&log);
    free(data);
}

static void test_as_image(void **state)
{
    NG_UNUSED(state);
    char path[512];
    test_path(path, sizeof path, "image.exr");
    write_picture(path);
    struct ng_image image;
    void *data;
    size_t size;
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    assert_int_equal(ng_image_decode(path, data, size,
                                     &(struct ng_image_params){.sampling.wrap_u = NG_WRAP_REPEAT}, &image),
                     NG_OK);
    free(data);
    assert_int_equal(image.format, NG_PIXEL_RGBA32F);
    assert_int_equal(image.levels, 6);
    const float *p = image.pixels;
    assert_float_equal(p[4], 0.25, 1e-6);
    assert_float_equal(p[6], -0.5, 1e-6);
    assert_float_equal(p[7], 1, 0);
    ng_image_finish(&image);
}

// Puts an attribute into a header; chunks move by as much.
static unsigned char *insert(const unsigned char *from, size_t size, const void *attribute, size_t length)
{
    unsigned char *out = malloc(size + length);
    uint64_t offset = 0;
    size_t table = 8;
    assert_non_null(out);
    memcpy(out, from, 8); // magic number and version
    memcpy(out + 8, attribute, length);
    memcpy(out + 8 + length, from + 8, size - 8);
    for (;; table++) { // which is where the first offset points behind the last
        assert_true(table + 8 < size);
        memcpy(&offset, from + table, 8);
        if (offset > table && offset < size && (offset - table) % 8 == 0 && offset - table <= 4096)
            break;
    }
    for (size_t at = table; at < table + (offset - table); at += 8) {
        uint64_t chunk;
        memcpy(&chunk, from + at, 8);
        chunk += length;
        memcpy(out + length + at, &chunk, 8);
    }
    return out;
}

static void *find_bytes(unsigned char *data, size_t size, const char *what, size_t length)
{
    for (size_t i = 0; i + length <= size; i++)
        if (memcmp(data + i, what, length) == 0)
            return data + i;
    fail_msg("%s is not there", what);
    return NULL;
}

// The picture is the display window; its colours are Rec. 709 once it is read.
static void test_window_and_colors(void **state)
{
    NG_UNUSED(state);
    char path[512];
    test_path(path, sizeof path, "window.exr");
    write_picture(path);
    struct ng_image image, moved;
    void *data;
    size_t size;
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    assert_int_equal(ng_image_decode(path, data, size, &(struct ng_image_params){.no_mips = true}, &image),
                     NG_OK);
    static const char key[] = "displayWindow\0box2i\0";
    unsigned char *window = find_bytes(data, size, key, sizeof key - 1);
    const int32_t box[4] = {-1, 1, 3, 4}; // 5 x 4 pixels, one of them left of the data
    memcpy(window + sizeof key - 1 + 4, box, sizeof box);
    assert_int_equal(ng_image_decode(path, data, size, &(struct ng_image_params){.no_mips = true}, &moved),
                     NG_OK);
    assert_int_equal(moved.width, 5);
    assert_int_equal(moved.height, 4);
    const float *p = image.pixels, *q = moved.pixels;
    assert_float_equal(q[0], 0, 0);
    for (size_t c = 0; c < 4; c++)
        assert_float_equal(q[4 * 2 + c], p[4 * (image.width + 1) + c], 0);
    ng_image_finish(&moved);

    // The primaries of Rec. 2020: its red is beyond Rec. 709, white stays white.
    const int32_t value_size = 32;
    const float rec2020[8] = {0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
    unsigned char bytes[30 + 4 + 32];
    memcpy(bytes, "chromaticities\0chromaticities", 30);
    memcpy(bytes + 30, &value_size, 4);
    memcpy(bytes + 34, rec2020, 32);
    unsigned char *other = insert(data, size, bytes, sizeof bytes);
    const int32_t whole[4] = {0, 0, (int32_t)image.width - 1, (int32_t)image.height - 1};
    window = find_bytes(other, size, key, sizeof key - 1);
    memcpy(window + sizeof key - 1 + 4, whole, sizeof whole);
    assert_int_equal(
        ng_image_decode(path, other, size + sizeof bytes, &(struct ng_image_params){.no_mips = true}, &moved),
        NG_OK);
    q = moved.pixels;
    const float *rgb = p + 4, most = 1e-3f * (fabsf(rgb[0]) + fabsf(rgb[1]) + fabsf(rgb[2]));
    assert_float_equal(q[4], 1.6605f * rgb[0] - 0.5876f * rgb[1] - 0.0728f * rgb[2], most);
    assert_float_equal(q[5], -0.1246f * rgb[0] + 1.1329f * rgb[1] - 0.0083f * rgb[2], most);
    ng_image_finish(&moved);
    ng_image_finish(&image);
    free(other);
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_same_bytes),
        cmocka_unit_test(test_what_compression_makes_no_shorter),
        cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_damage),
        cmocka_unit_test(test_as_image),
        cmocka_unit_test(test_window_and_colors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

// Makes small glTF files of numbers that a test has, in its scratch directory: accessors are put one by one,
// the JSON around them is the test's own.
#ifndef NG_TESTS_UNIT_GLTF_MAKER_H
#define NG_TESTS_UNIT_GLTF_MAKER_H

#include "test.h"

struct gltf_maker {
    char accessors[8192], views[8192];
    unsigned char bytes[65536];
    size_t size;
    int accessor_count, view_count;
};

static inline void gltf_maker_append(char *text, size_t room, const char *item)
{
    size_t n = strlen(text);
    assert_true((size_t)snprintf(text + n, room - n, "%s%s", n ? ", " : "", item) < room - n);
}

// A buffer view of these bytes; `more`: other members, each after a comma.
static inline int gltf_put_view(struct gltf_maker *m, const void *data, size_t size, const char *more)
{
    char view[512];
    assert_true(m->size + size + 4 <= sizeof m->bytes);
    snprintf(view, sizeof view, "{\"buffer\": 0, \"byteOffset\": %zu, \"byteLength\": %zu%s}", m->size, size,
             more);
    gltf_maker_append(m->views, sizeof m->views, view);
    memcpy(m->bytes + m->size, data, size);
    m->size += (size + 3) & ~(size_t)3;
    return m->view_count++;
}

// An accessor of `count` elements. `type` is glTF's, such as "VEC3", with more members behind it, as in
// "VEC3\", \"normalized\": true, \"x\": \"".
static inline int gltf_put(struct gltf_maker *m, int component_type, const char *type, int count,
                           const void *data, size_t size)
{
    char accessor[512];
    snprintf(accessor, sizeof accessor,
             "{\"bufferView\": %d, \"componentType\": %d, \"count\": %d, \"type\": \"%s\"}",
             gltf_put_view(m, data, size, ""), component_type, count, type);
    gltf_maker_append(m->accessors, sizeof m->accessors, accessor);
    return m->accessor_count++;
}
#define GLTF_PUT(m, component_type, type, count, ...)                                                        \
    gltf_put(m, component_type, type, count, __VA_ARGS__, sizeof(__VA_ARGS__))

// Not kept on a disk that fails: some tests write thousands.
static inline void gltf_write_file(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

// Writes NAME.gltf and NAME.bin. `rest`: the document's other members.
static inline void gltf_write(const struct gltf_maker *m, const char *name, const char *rest, char *path,
                              size_t room)
{
    static char text[65536];
    char file[256], bytes[512];
    snprintf(file, sizeof file, "%s.bin", name);
    test_path(bytes, sizeof bytes, file);
    gltf_write_file(bytes, m->bytes, m->size);
    int n =
        snprintf(text, sizeof text,
                 "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"%s\", \"byteLength\": %zu}], "
                 "\"bufferViews\": [%s], \"accessors\": [%s], %s}",
                 file, m->size, m->views, m->accessors, rest);
    assert_true(n > 0 && (size_t)n < sizeof text);
    snprintf(file, sizeof file, "%s.gltf", name);
    test_path(path, room, file);
    gltf_write_file(path, text, (size_t)n);
}

#endif

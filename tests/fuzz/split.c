#include "split.h"

#include "asset/gltf_internal.h"
#include "base/file.h"

static bool is_picture(const unsigned char *data, size_t size)
{
    return size > 12 && (memcmp(data, "\x89PNG", 4) == 0 || memcmp(data, "\xff\xd8", 2) == 0 ||
                         memcmp(data, "RIFF", 4) == 0);
}

static void append(struct bytes *b, const void *data, size_t size)
{
    bytes_splice(b, b->data.count, 0, data, size);
}

// Takes the first data: URI from `*at` on out of the text, which ends with a zero; false if there is none.
static bool take_uri(struct bytes *json, size_t *at, unsigned char **data, size_t *size)
{
    static const char key[] = "\"uri\": \"", put[] = "\"extras\": 0";
    struct gltf_faults faults = {.path = "a file to split"};
    char *text = (char *)json->data.items, *found = strstr(text + *at, key);
    while (found && !ng_gltf_is_data_uri(found + sizeof key - 1))
        found = strstr(found + 1, key);
    char *end = found ? strchr(found + sizeof key - 1, '"') : NULL;
    if (!end)
        return false;
    *end = 0;
    assert_int_equal(ng_gltf_data_uri(&faults, "a URI", found + sizeof key - 1, 1 << 20, data, size), NG_OK);
    ng_gltf_faults_finish(&faults);
    *at = (size_t)(found - text);
    bytes_splice(json, *at, (size_t)(end - found) + 1, put, sizeof put - 1);
    return true;
}

void split_read(const char *path, struct split *out)
{
    unsigned char *data;
    size_t size, at = 0;
    *out = (struct split){.json = bytes_read(path)};
    append(&out->json, "", 1);
    while (take_uri(&out->json, &at, &data, &size)) {
        struct bytes picture = {0};
        if (is_picture(data, size)) {
            append(&picture, data, size);
            assert_true(ng_array_push(&out->pictures, picture));
        } else if (!out->buffer.data.count) {
            append(&out->buffer, data, size);
        }
        free(data);
    }
    out->json.data.count--;
}

void split_finish(struct split *s)
{
    for (size_t i = 0; i < s->pictures.count; i++)
        ng_array_finish(&s->pictures.items[i].data);
    ng_array_finish(&s->pictures);
    ng_array_finish(&s->json.data);
    ng_array_finish(&s->buffer.data);
}

static void append_word(struct bytes *b, size_t value)
{
    unsigned char word[4] = {(unsigned char)value, (unsigned char)(value >> 8), (unsigned char)(value >> 16),
                             (unsigned char)(value >> 24)};
    append(b, word, sizeof word);
}

void split_write_glb(const struct split *split, const char *path)
{
    struct bytes glb = {0};
    size_t json = (split->json.data.count + 3) / 4 * 4, buffer = split->buffer.data.count;
    append_word(&glb, 0x46546c67);
    append_word(&glb, 2);
    append_word(&glb, 28 + json + buffer);
    append_word(&glb, json);
    append_word(&glb, 0x4e4f534a);
    append(&glb, split->json.data.items, split->json.data.count);
    append(&glb, "   ", json - split->json.data.count);
    append_word(&glb, buffer);
    append_word(&glb, 0x004e4942);
    append(&glb, split->buffer.data.items, buffer);
    assert_int_equal(ng_file_write(path, glb.data.items, glb.data.count), NG_OK);
    ng_array_finish(&glb.data);
}

// From a document and its data to files: one .glb, or a .gltf with what it names beside it.
//
// No file beside is ever replaced, since the old document may name it until the new one has taken its place.
#define _POSIX_C_SOURCE 200809L // strdup
#include "asset/gltf_save_internal.h"
#include "base/file.h"
#include "base/log.h"

#include <cjson/cJSON.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The bytes of one of the document's buffers; null: it has none of its own (an extension's).
struct content {
    const unsigned char *data;
    size_t size;
};

static const cJSON *get(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

static const char *text_of(const cJSON *object, const char *key)
{
    const cJSON *value = get(object, key);
    return cJSON_IsString(value) ? value->valuestring : NULL;
}

static bool is_data_uri(const char *uri)
{
    return uri && strncmp(uri, "data:", 5) == 0;
}

static const char *const out_of_memory = "saving";

// ---- buffers ---------------------------------------------------------------------------------------------

// A buffer that has no bytes: an extension says what is in it.
static bool is_virtual(const cJSON *buffer)
{
    return get(get(buffer, "extensions"), "EXT_meshopt_compression");
}

void ng_gltf_save_choose_buffer(struct gltf_saver *s)
{
    size_t count = s->w.lists[NG_GLTF_BUFFERS].count;
    const cJSON *first = ng_gltf_at(&s->w, NG_GLTF_BUFFERS, 0);
    bool usable = first && !is_virtual(first) && s->origin && s->origin->doc->buffer_count;
    s->w.buffer = usable ? 0 : (int)count;
    s->w.data_offset = usable ? (s->origin->doc->buffers[0].size + 3) / 4 * 4 : 0;
}

// Memory that lives until the save ends.
static void *own(struct gltf_saver *s, size_t size)
{
    void *data = malloc(size + 1);
    if (data && ng_array_push(&s->owned, data))
        return data;
    free(data);
    return NULL;
}

// What is in each buffer now: that of the origin, with what was added.
static ng_result find_contents(struct gltf_saver *s, struct content **out)
{
    struct ng_gltf_writer *w = &s->w;
    if (w->data.count && (size_t)w->buffer == w->lists[NG_GLTF_BUFFERS].count) {
        cJSON *buffer;
        ng_gltf_append(w, NG_GLTF_BUFFERS, &buffer);
    }
    size_t count = w->lists[NG_GLTF_BUFFERS].count;
    struct content *contents = own(s, (count + 1) * sizeof *contents);
    if (!contents || w->failed)
        return ng_out_of_memory(out_of_memory);
    memset(contents, 0, (count + 1) * sizeof *contents);
    for (size_t i = 0; i < count && s->origin && i < s->origin->doc->buffer_count; i++)
        contents[i] = (struct content){s->origin->doc->buffers[i].data, s->origin->doc->buffers[i].size};
    *out = contents;
    if (!w->data.count) // then nothing was released, either
        return NG_OK;
    struct content *c = &contents[w->buffer];
    c->data = ng_gltf_save_compact(s, c->data, &c->size);
    unsigned char *all = own(s, w->data_offset + w->data.count);
    if (!all)
        return ng_out_of_memory(out_of_memory);
    memset(all, 0, w->data_offset);
    if (c->size)
        memcpy(all, c->data, c->size);
    memcpy(all + w->data_offset, w->data.items, w->data.count);
    *c = (struct content){all, w->data_offset + w->data.count};
    ng_gltf_json_number(w, ng_gltf_at(w, NG_GLTF_BUFFERS, w->buffer), "byteLength", (double)c->size);
    return NG_OK;
}

static ng_result embed_buffer(struct gltf_saver *s, cJSON *buffer, const struct content *c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    static const char head[] = "data:application/octet-stream;base64,";
    char *uri = malloc(sizeof head + (c->size + 2) / 3 * 4);
    if (!uri)
        return ng_out_of_memory(out_of_memory);
    memcpy(uri, head, sizeof head);
    char *p = uri + sizeof head - 1;
    for (size_t i = 0; i < c->size; i += 3) {
        size_t left = c->size - i;
        uint32_t v = (uint32_t)c->data[i] << 16 | (left > 1 ? (uint32_t)c->data[i + 1] << 8 : 0) |
                     (left > 2 ? c->data[i + 2] : 0u);
        *p++ = digits[v >> 18];
        *p++ = digits[v >> 12 & 63];
        *p++ = left > 1 ? digits[v >> 6 & 63] : '=';
        *p++ = left > 2 ? digits[v & 63] : '=';
    }
    *p = 0;
    ng_gltf_json_text(&s->w, buffer, "uri", uri);
    free(uri);
    return s->w.failed ? ng_out_of_memory(out_of_memory) : NG_OK;
}

// ---- files beside ----------------------------------------------------------------------------------------

static bool holds(const char *path, const void *data, size_t size)
{
    void *found = NULL;
    size_t found_size = 0;
    bool same = ng_file_read(path, 0, &found, &found_size) == NG_OK && found_size == size &&
                (size == 0 || memcmp(found, data, size) == 0);
    free(found);
    return same;
}

enum fit { FREE, SAME, TAKEN };

// Whether a name beside the document can be had for these bytes.
static enum fit try_name(const struct gltf_saver *s, const char *path, const void *data, size_t size)
{
    for (size_t i = 0; i < s->beside.count; i++)
        if (ng_file_same(s->beside.items[i].path, path))
            return s->beside.items[i].size == size && memcmp(s->beside.items[i].data, data, size) == 0
                       ? SAME
                       : TAKEN;
    if (ng_file_same(path, s->path))
        return TAKEN;
    if (!ng_file_exists(path))
        return FREE;
    return holds(path, data, size) ? SAME : TAKEN;
}

// "sky.hdr" -> "sky.1.hdr"; a percent-encoded name stays one.
static void number_name(const char *uri, unsigned number, char *out, size_t size)
{
    const char *extension = ng_path_extension(uri);
    int stem = (int)(extension[0] ? extension - 1 - uri : (ptrdiff_t)strlen(uri));
    if (number)
        snprintf(out, size, "%.*s.%u%s", stem, uri, number, uri + stem);
    else
        snprintf(out, size, "%s", uri);
}

// Has a file be written beside the document, or finds it there. `uri` becomes the name that it has.
static ng_result put_beside(struct gltf_saver *s, char uri[4096], const void *data, size_t size)
{
    char name[4096], path[4096];
    const char *why;
    for (unsigned number = 0; number < 10000; number++) {
        number_name(uri, number, name, sizeof name);
        if (!ng_gltf_uri_path(s->path, name, path, sizeof path, &why)) {
            ng_log_error("%s: \"%.60s\" %s", s->path, name, why);
            return NG_ERROR_IO;
        }
        enum fit fit = try_name(s, path, data, size);
        if (fit == TAKEN)
            continue;
        memcpy(uri, name, sizeof name);
        struct gltf_beside file = {.path = strdup(path), .data = data, .size = size};
        if (fit == SAME)
            free(file.path);
        else if (!file.path || !ng_array_push(&s->beside, file))
            return free(file.path), ng_out_of_memory(s->path);
        return NG_OK;
    }
    ng_log_error("%s: there is no free name for \"%.60s\" beside it", s->path, uri);
    return NG_ERROR_IO;
}

// The same for what a string member of the document names.
static ng_result put_named(struct gltf_saver *s, cJSON *object, const char *old, const void *data,
                           size_t size)
{
    char uri[4096];
    snprintf(uri, sizeof uri, "%s", old);
    NG_TRY(put_beside(s, uri, data, size));
    if (strcmp(uri, old) != 0)
        ng_gltf_json_text(&s->w, object, "uri", uri);
    return s->w.failed ? ng_out_of_memory(s->path) : NG_OK;
}

// A name for a file that belongs to the document: its own, with another ending, percent-encoded.
static void own_name(const struct gltf_saver *s, const char *ending, char *out, size_t size)
{
    const char *name = ng_path_name(s->path), *extension = ng_path_extension(s->path);
    size_t n = 0, stem = (size_t)(extension - 1 - name);
    for (size_t i = 0; i < stem && n + 8 < size; i++) {
        unsigned char c = (unsigned char)name[i];
        bool plain =
            (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || strchr("-._~", c);
        n += (size_t)snprintf(out + n, size - n, plain ? "%c" : "%%%02X", c);
    }
    snprintf(out + n, size - n, "%s", ending);
}

void ng_gltf_save_beside(struct gltf_saver *s, cJSON *object, const char *ending, const void *data,
                         size_t size)
{
    char name[4096];
    own_name(s, ending, name, sizeof name);
    if (put_beside(s, name, data, size) == NG_OK)
        ng_gltf_json_text(&s->w, object, "uri", name);
    else
        s->w.failed = true;
}

static ng_result place_buffer(struct gltf_saver *s, cJSON *buffer, const struct content *c)
{
    const char *uri = text_of(buffer, "uri");
    if (is_data_uri(uri))
        return s->w.data.count && buffer == ng_gltf_at(&s->w, NG_GLTF_BUFFERS, s->w.buffer)
                   ? embed_buffer(s, buffer, c)
                   : NG_OK;
    if (!c->data || is_virtual(buffer))
        return NG_OK;
    if (uri)
        return put_named(s, buffer, uri, c->data, c->size);
    ng_gltf_save_beside(s, buffer, ".bin", c->data, c->size);
    return s->w.failed ? ng_out_of_memory(s->path) : NG_OK;
}

// Pictures that the document names go with it. `object` may be anything with a "uri".
static ng_result place_picture(struct gltf_saver *s, cJSON *object)
{
    const char *uri = text_of(object, "uri");
    const struct gltf_kept_picture *picture = ng_gltf_kept_picture(s->origin, uri);
    return picture ? put_named(s, object, uri, picture->data, picture->size) : NG_OK;
}

static ng_result place_pictures(struct gltf_saver *s, cJSON *value, bool ours)
{
    cJSON *item;
    if (ours && cJSON_IsObject(value))
        NG_TRY(place_picture(s, value));
    cJSON_ArrayForEach(item, value)
    {
        NG_TRY(place_pictures(s, item, ours || (item->string && strcmp(item->string, "NG_scene") == 0)));
    }
    return NG_OK;
}

// Everything that stays outside of the document. `buffer`: the first one that does.
static ng_result place_all(struct gltf_saver *s, const struct content *contents, size_t buffer)
{
    for (; buffer < s->w.lists[NG_GLTF_BUFFERS].count; buffer++)
        NG_TRY(place_buffer(s, s->w.lists[NG_GLTF_BUFFERS].items[buffer], &contents[buffer]));
    for (size_t i = 0; i < s->w.lists[NG_GLTF_IMAGES].count; i++)
        NG_TRY(place_picture(s, s->w.lists[NG_GLTF_IMAGES].items[i]));
    return place_pictures(s, s->w.root, false);
}

// ---- packing into a GLB ----------------------------------------------------------------------------------

static const char *picture_type(const struct gltf_kept_picture *p)
{
    const unsigned char *d = p->data;
    if (p->size >= 8 && memcmp(d, "\x89PNG\r\n\x1a\n", 8) == 0)
        return "image/png";
    if (p->size >= 3 && memcmp(d, "\xff\xd8\xff", 3) == 0)
        return "image/jpeg";
    if (p->size >= 12 && memcmp(d, "RIFF", 4) == 0 && memcmp(d + 8, "WEBP", 4) == 0)
        return "image/webp";
    return p->size >= 12 && memcmp(d, "\xabKTX 20\xbb", 8) == 0 ? "image/ktx2" : NULL;
}

// Pictures become buffer views; those of kinds that glTF does not know stay files.
static void pack_images(struct gltf_saver *s)
{
    for (size_t i = 0; i < s->w.lists[NG_GLTF_IMAGES].count; i++) {
        cJSON *image = s->w.lists[NG_GLTF_IMAGES].items[i];
        const struct gltf_kept_picture *picture = ng_gltf_kept_picture(s->origin, text_of(image, "uri"));
        const char *type = picture ? picture_type(picture) : NULL;
        if (!type)
            continue;
        if (!text_of(image, "name"))
            ng_gltf_json_text(&s->w, image, "name", ng_path_name(picture->uri));
        cJSON_DeleteItemFromObjectCaseSensitive(image, "uri");
        ng_gltf_json_text(&s->w, image, "mimeType", type);
        ng_gltf_json_number(&s->w, image, "bufferView",
                            ng_gltf_add_view(&s->w, picture->data, picture->size, NG_GLTF_NO_TARGET));
    }
}

static bool may_merge(const struct gltf_saver *s)
{
    for (size_t i = 0; i < s->w.lists[NG_GLTF_BUFFERS].count; i++) {
        const cJSON *buffer = s->w.lists[NG_GLTF_BUFFERS].items[i];
        if (is_virtual(buffer) || (i > 0 && (get(buffer, "extensions") || get(buffer, "extras"))))
            return false;
    }
    return true;
}

static void move_view(struct gltf_saver *s, cJSON *view, const size_t *offsets, size_t count)
{
    const cJSON *buffer = get(view, "buffer"), *offset = get(view, "byteOffset");
    if (!cJSON_IsNumber(buffer) || buffer->valuedouble < 0 || buffer->valuedouble >= (double)count)
        return;
    size_t base = offsets[(size_t)buffer->valuedouble];
    if (base)
        ng_gltf_json_number(&s->w, view, "byteOffset",
                            (double)base + (cJSON_IsNumber(offset) ? offset->valuedouble : 0));
    ng_gltf_json_number(&s->w, view, "buffer", 0);
}

// All buffers, one after the other, in the first.
static ng_result merge(struct gltf_saver *s, struct content *contents)
{
    size_t count = s->w.lists[NG_GLTF_BUFFERS].count, size = 0;
    size_t *offsets = own(s, (count + 1) * sizeof *offsets);
    for (size_t i = 0; offsets && i < count; i++) {
        offsets[i] = size;
        size += (contents[i].size + 3) / 4 * 4;
    }
    unsigned char *all = offsets ? own(s, size) : NULL;
    if (!all)
        return ng_out_of_memory(out_of_memory);
    memset(all, 0, size);
    for (size_t i = 0; i < count; i++)
        if (contents[i].size)
            memcpy(all + offsets[i], contents[i].data, contents[i].size);
    contents[0] = (struct content){all, count == 1 ? contents[0].size : size};
    for (size_t i = 0; count > 1 && i < s->w.lists[NG_GLTF_VIEWS].count; i++) {
        cJSON *view = s->w.lists[NG_GLTF_VIEWS].items[i];
        move_view(s, view, offsets, count);
        cJSON *packed = cJSON_GetObjectItemCaseSensitive(get(view, "extensions"), "EXT_meshopt_compression");
        if (packed)
            move_view(s, packed, offsets, count);
    }
    cJSON *list = cJSON_GetObjectItemCaseSensitive(s->w.root, "buffers");
    while (s->w.lists[NG_GLTF_BUFFERS].count > 1)
        cJSON_Delete(cJSON_DetachItemViaPointer(
            list, s->w.lists[NG_GLTF_BUFFERS].items[--s->w.lists[NG_GLTF_BUFFERS].count]));
    return NG_OK;
}

// Into one file: `*out` is the chunk of data.
static ng_result pack(struct gltf_saver *s, struct content *out)
{
    struct content *contents;
    *out = (struct content){0};
    pack_images(s);
    NG_TRY(find_contents(s, &contents));
    cJSON *first = ng_gltf_at(&s->w, NG_GLTF_BUFFERS, 0);
    bool packed = first && !is_virtual(first) && contents[0].size;
    if (first && may_merge(s)) {
        NG_TRY(merge(s, contents));
        packed = contents[0].size;
    }
    for (size_t i = packed; i < s->w.lists[NG_GLTF_BUFFERS].count; i++) {
        const char *uri = text_of(s->w.lists[NG_GLTF_BUFFERS].items[i], "uri");
        if (contents[i].data && !is_data_uri(uri))
            NG_TRY(embed_buffer(s, s->w.lists[NG_GLTF_BUFFERS].items[i], &contents[i]));
    }
    if (packed) {
        cJSON_DeleteItemFromObjectCaseSensitive(first, "uri");
        ng_gltf_json_number(&s->w, first, "byteLength", (double)contents[0].size);
        *out = contents[0];
    }
    return place_pictures(s, s->w.root, false);
}

// ---- the document ----------------------------------------------------------------------------------------

static bool is_binary(const struct ng_gltf_origin *o)
{
    return o->doc->json_offset > 3;
}

// Chunks of the old file that nobody knows.
static bool put_other_chunks(const struct gltf_saver *s, struct ng_gltf_bytes *out)
{
    if (!s->origin || !is_binary(s->origin))
        return true;
    const unsigned char *file = s->origin->doc->files.items[0];
    size_t size = s->origin->doc->file_size, at = s->origin->doc->json_offset + s->origin->doc->json_size;
    for (unsigned index = 1; at + 8 <= size; index++) {
        uint32_t length, type;
        memcpy(&length, file + at, 4);
        memcpy(&type, file + at + 4, 4);
        if (length > size - at - 8)
            return true;
        if ((index > 1 || type != NG_GLTF_CHUNK_BIN) && !ng_gltf_put_chunk(out, type, file + at + 8, length))
            return false;
        at += 8 + (size_t)length;
    }
    return true;
}

// How cJSON would not print a number such that it is read as this one again; false if it would. A whole
// number beyond 32 bits is a real one where glTF has it, and integers have no -0.
static bool needs_text(double v, char *text, size_t size)
{
    snprintf(text, size, "%.1f", v);
    if (v == floor(v) && fabs(v) < 1e15)
        return (v == 0 && signbit(v)) || fabs(v) > UINT32_MAX;
    snprintf(text, size, "%1.15g", v);
    if (strtod(text, NULL) == v)
        return false;
    snprintf(text, size, "%.17g", v);
    return true;
}

static bool mark_numbers(cJSON *value)
{
    cJSON *item;
    char text[40];
    cJSON_ArrayForEach(item, value)
    {
        if (!mark_numbers(item))
            return false;
        if (!cJSON_IsNumber(item) || !needs_text(item->valuedouble, text, sizeof text))
            continue;
        item->valuestring = cJSON_malloc(strlen(text) + 1);
        if (!item->valuestring)
            return false;
        memcpy(item->valuestring, text, strlen(text) + 1);
        item->type = cJSON_Raw;
    }
    return true;
}

static bool print_binary(const struct gltf_saver *s, const struct content *data, struct ng_gltf_bytes *out)
{
    char *json = cJSON_PrintUnformatted(s->w.root);
    bool ok = json && ng_gltf_put_header(out) &&
              ng_gltf_put_chunk(out, NG_GLTF_CHUNK_JSON, json, strlen(json)) &&
              (!data->size || ng_gltf_put_chunk(out, NG_GLTF_CHUNK_BIN, data->data, data->size)) &&
              put_other_chunks(s, out);
    cJSON_free(json);
    if (ok)
        ng_gltf_put_length(out);
    return ok;
}

static bool print_text(const struct gltf_saver *s, struct ng_gltf_bytes *out)
{
    char *json = cJSON_Print(s->w.root);
    bool ok = json && ng_gltf_bytes_append(out, json, strlen(json)) && ng_gltf_bytes_append(out, "\n", 1);
    cJSON_free(json);
    return ok;
}

// `*written`: how many there are now, one that failed included.
static ng_result write_beside(const struct gltf_saver *s, size_t *written)
{
    for (*written = 0; *written < s->beside.count;) {
        struct gltf_beside *f = &s->beside.items[*written];
        char *slash = strrchr(f->path, '/');
        if (slash && slash != f->path) {
            *slash = 0;
            NG_TRY(ng_file_make_directory(f->path));
            *slash = '/';
        }
        ++*written;
        NG_TRY(ng_file_write(f->path, f->data, f->size));
    }
    return NG_OK;
}

// What nothing names: on a full disk it would be in the way of the next try.
static void remove_beside(const struct gltf_saver *s, size_t written)
{
    for (size_t i = 0; i < written; i++)
        (void)remove(s->beside.items[i].path);
}

// The document's bytes, with all that it has outside of it placed. Unchanged they are those of the origin.
static ng_result make_document(struct gltf_saver *s, struct ng_gltf_bytes *out)
{
    bool same_kind = s->origin && is_binary(s->origin) == s->binary;
    struct content data = {0}, *contents;
    if (same_kind || !s->binary) {
        NG_TRY(find_contents(s, &contents));
        bool packed = s->binary && contents[0].data && !text_of(ng_gltf_at(&s->w, NG_GLTF_BUFFERS, 0), "uri");
        NG_TRY(place_all(s, contents, packed ? 1 : 0));
        data = packed ? contents[0] : data;
    } else {
        NG_TRY(pack(s, &data));
    }
    bool ok;
    if (same_kind && !s->w.data.count && ng_gltf_json_same(s->w.root, s->origin->json))
        ok = ng_gltf_bytes_append(out, s->origin->doc->files.items[0], s->origin->doc->file_size);
    else
        ok = !s->w.failed && mark_numbers(s->w.root) &&
             (s->binary ? print_binary(s, &data, out) : print_text(s, out));
    return ok ? NG_OK : ng_out_of_memory(s->path);
}

ng_result ng_gltf_save_write(struct gltf_saver *s)
{
    struct ng_gltf_bytes document = {0};
    NG_TRY(ng_file_check_writable(s->path));
    ng_result r = make_document(s, &document);
    size_t beside = 0;
    if (r == NG_OK)
        r = write_beside(s, &beside);
    if (r == NG_OK)
        r = ng_file_write(s->path, document.items, document.count);
    // It may have failed with the document in its place already.
    if (r != NG_OK && !(ng_file_exists(s->path) && holds(s->path, document.items, document.count)))
        remove_beside(s, beside);
    ng_array_finish(&document);
    return r;
}

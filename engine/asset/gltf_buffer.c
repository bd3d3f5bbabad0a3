// The bytes of a document: the chunks of a GLB, and buffers from there, from files and from data: URIs.
#include "asset/gltf_internal.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- GLB -------------------------------------------------------------------------------------------------
#define GLB_MAGIC 0x46546c67u // "glTF"
#define GLB_JSON  0x4e4f534au
#define GLB_BIN   0x004e4942u

static uint32_t u32_at(const unsigned char *data, size_t at)
{
    return (uint32_t)data[at] | (uint32_t)data[at + 1] << 8 | (uint32_t)data[at + 2] << 16 |
           (uint32_t)data[at + 3] << 24;
}

static ng_result check_header(struct gltf_faults *f, const unsigned char *data, size_t size)
{
    if (size < 20) {
        ng_log_error("%s: GLB of %zu bytes is shorter than its header", f->path, size);
        return NG_ERROR_FORMAT;
    }
    if (u32_at(data, 4) != 2) {
        ng_log_error("%s: is binary glTF of version %u, only version 2 is supported", f->path,
                     u32_at(data, 4));
        return NG_ERROR_UNSUPPORTED;
    }
    return NG_OK;
}

// Against where the chunks end. A length that is wrong costs nothing, if nothing is cut.
static ng_result check_length_of_all(struct gltf_faults *f, const unsigned char *data, size_t end,
                                     size_t size)
{
    uint32_t said = u32_at(data, 8);
    if (said > size && end + 4 <= size) { // a part of a chunk's header
        ng_log_error("%s: GLB header says %u bytes, the file has %zu (truncated?)", f->path, said, size);
        return NG_ERROR_FORMAT;
    }
    return said == size ? NG_OK
                        : ng_gltf_fault(f, "its chunks say what is in it",
                                        "GLB header says %u bytes, the file has %zu", said, size);
}

// Where the chunk after one that ends here begins. Some writers pad a chunk and do not say so.
static size_t next_chunk(const unsigned char *data, size_t end, size_t size)
{
    size_t aligned = (end + 3) / 4 * 4;
    bool padded = size >= 8 && aligned <= size - 8 && u32_at(data, aligned + 4) == GLB_BIN;
    bool plain = size >= 8 && end <= size - 8 && u32_at(data, end + 4) == GLB_BIN;
    return padded && !plain ? aligned : end;
}

// The chunks after the JSON: the first BIN is the one, what is unknown is skipped (glTF 2.0, 4.4.3). What
// follows the length that the header says may be no chunk at all.
static ng_result find_bytes(struct gltf_faults *f, const unsigned char *data, size_t begin, size_t size,
                            struct gltf_container *out)
{
    for (unsigned chunk = 1; begin <= size && size - begin >= 8; chunk++) {
        uint32_t length = u32_at(data, begin);
        if (begin >= u32_at(data, 8) && (length > size - begin - 8 || u32_at(data, begin + 4) != GLB_BIN))
            break;
        if (length > size - begin - 8) {
            ng_log_error("%s: GLB chunk %u is %u bytes long, which run past the file (truncated?)", f->path,
                         chunk, length);
            return NG_ERROR_FORMAT;
        }
        if (u32_at(data, begin + 4) == GLB_BIN && !out->bytes) {
            out->bytes = data + begin + 8;
            out->byte_count = length;
        }
        begin = next_chunk(data, begin + 8 + length, size);
    }
    return check_length_of_all(f, data, begin, size);
}

ng_result ng_gltf_open(struct gltf_faults *f, const unsigned char *data, size_t size,
                       struct gltf_container *out)
{
    *out = (struct gltf_container){.json = (const char *)data, .json_size = size};
    if (size < 4 || u32_at(data, 0) != GLB_MAGIC)
        return NG_OK;
    NG_TRY(check_header(f, data, size));
    uint32_t length = u32_at(data, 12);
    if (u32_at(data, 16) != GLB_JSON || length > size - 20) {
        ng_log_error("%s: GLB chunk 0 is not JSON or its length of %u runs past the file", f->path, length);
        return NG_ERROR_FORMAT;
    }
    *out = (struct gltf_container){.json = (const char *)data + 20, .json_size = length};
    return find_bytes(f, data, next_chunk(data, 20 + (size_t)length, size), size, out);
}

// ---- data: URIs ------------------------------------------------------------------------------------------
// Of either alphabet (RFC 4648: 4, and 5 for URLs).
static int base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    c = c == '-' ? '+' : c == '_' ? '/' : c;
    const char *at = c ? strchr(digits, c) : NULL;
    return at ? (int)(at - digits) : -1;
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

// Returns how many bytes; stops at the padding or at what is no digit, where `*end` then points. Lines may be
// broken.
static size_t decode_base64(const char *text, unsigned char *out, const char **end)
{
    uint32_t bits = 0;
    unsigned held = 0; // bits
    size_t n = 0;
    for (;; text++) {
        if (is_space(*text))
            continue;
        int digit = base64_digit(*text);
        if (digit < 0)
            break;
        bits = bits << 6 | (uint32_t)digit;
        held += 6;
        if (held < 8)
            continue;
        held -= 8;
        out[n++] = (unsigned char)(bits >> held);
    }
    while (*text == '=' || is_space(*text))
        text++;
    *end = text;
    return n;
}

// Whether a text begins with this one, which is in lower case.
static bool begins(const char *text, const char *lower)
{
    for (; *lower; text++, lower++)
        if ((*text >= 'A' && *text <= 'Z' ? *text - 'A' + 'a' : *text) != *lower)
            return false;
    return true;
}

bool ng_gltf_is_data_uri(const char *uri)
{
    return begins(uri, "data:");
}

// Of the standard, and of its extensions. The bytes are taken for what they are, whatever the type says.
static bool is_usual_type(const char *type, size_t size)
{
    static const char *const types[] = {"application/octet-stream", "application/gltf-buffer", "image/png",
                                        "image/jpeg", "image/webp"};
    for (size_t i = 0; i < NG_COUNT(types); i++)
        if (size == strlen(types[i]) && begins(type, types[i]))
            return true;
    return false;
}

ng_result ng_gltf_data_uri(struct gltf_faults *f, const char *what, const char *uri, uint64_t limit,
                           unsigned char **data, size_t *size)
{
    *data = NULL;
    const char *comma = strchr(uri, ','), *type = uri + 5, *end;
    if (!comma || comma - uri < 12 || !begins(comma - 7, ";base64")) {
        ng_log_error("%s: %s: \"%.60s\" is a data: URI of another kind than base64", f->path, what, uri);
        return NG_ERROR_FORMAT;
    }
    int type_size = (int)strcspn(type, ";,");
    if (!is_usual_type(type, (size_t)type_size))
        NG_TRY(ng_gltf_fault(f, "its bytes are read", "%s: \"%.*s\" is not a type that the standard has",
                             what, type_size < 40 ? type_size : 40, type));
    size_t length = strlen(comma + 1);
    if (length / 4 * 3 > limit) {
        ng_log_error("%s: %s: a data: URI of %zu bytes, more than the %llu that are left" NG_GLTF_RAISE,
                     f->path, what, length / 4 * 3, (unsigned long long)limit);
        return NG_ERROR_MEMORY;
    }
    *data = malloc(length / 4 * 3 + 3);
    if (!*data)
        return ng_out_of_memory(f->path);
    *size = decode_base64(comma + 1, *data, &end);
    if (!*end)
        return NG_OK;
    free(*data);
    *data = NULL;
    ng_log_error("%s: %s: its data: URI is damaged at byte %zu: no base64", f->path, what,
                 (size_t)(end - uri));
    return NG_ERROR_FORMAT;
}

// ---- buffers ---------------------------------------------------------------------------------------------
struct reader {
    struct gltf_faults *faults;
    const struct ng_gltf_params *params;
    const struct gltf_container *container;
    struct gltf_document *doc;
    uint64_t left; // bytes that all buffers together may still have
};

// A file of the document's directory or below.
static ng_result read_file(struct reader *r, const char *what, const char *uri, void **data, size_t *size)
{
    char path[4096], name[8192];
    const char *why;
    if (!ng_gltf_uri_path(r->faults->path, uri, path, sizeof path, &why)) {
        ng_log_error("%s: %s: \"%.60s\" %s", r->faults->path, what, uri, why);
        return NG_ERROR_FORMAT;
    }
    if (r->params->file)
        r->params->file(r->params->user, path);
    if (r->left == 0) {
        ng_log_error("%s: %s: the limit of bytes of all buffers is used up" NG_GLTF_RAISE, r->faults->path,
                     what);
        return NG_ERROR_MEMORY;
    }
    snprintf(name, sizeof name, "%.3500s: %s: %.500s", r->faults->path, what, path);
    NG_TRY(ng_file_read_named(name, path, r->left, NG_GLTF_RAISE, data, size));
    r->doc->hash = ng_hash_bytes(r->doc->hash, *data, *size);
    return NG_OK;
}

static ng_result read_uri(struct reader *r, const char *what, const char *uri, struct gltf_buffer *out)
{
    void *data = NULL;
    unsigned char *bytes = NULL;
    if (ng_gltf_is_data_uri(uri)) {
        NG_TRY(ng_gltf_data_uri(r->faults, what, uri, r->left, &bytes, &out->size));
        data = bytes;
    } else {
        NG_TRY(read_file(r, what, uri, &data, &out->size));
    }
    if (!ng_array_push(&r->doc->files, data)) {
        free(data);
        return ng_out_of_memory(r->faults->path);
    }
    out->data = data;
    r->doc->bytes += out->size;
    r->left -= out->size < r->left ? out->size : r->left;
    return NG_OK;
}

// Where it has neither, an extension may say what it holds; who looks for bytes finds none.
static ng_result read_buffer(struct reader *r, uint32_t index, const struct gltf_value *v,
                             struct gltf_buffer *out)
{
    char what[32];
    snprintf(what, sizeof what, "buffer %u", index);
    const char *uri = ng_gltf_text(v, "uri", NULL);
    if (uri)
        return read_uri(r, what, uri, out);
    if (index == 0 && r->container->bytes)
        *out = (struct gltf_buffer){r->container->bytes, r->container->byte_count, false};
    return NG_OK;
}

// A buffer may be longer than its byteLength (glTF 2.0, 3.6.1.1); what is beyond is there nevertheless.
static ng_result check_length(struct reader *r, uint32_t index, const struct gltf_value *v,
                              const struct gltf_buffer *b)
{
    double length = ng_gltf_number(v, "byteLength", 0);
    if (!b->data || (double)b->size >= length)
        return NG_OK;
    return ng_gltf_fault(r->faults, "what lies in the rest is lost",
                         "buffer %u: has %zu bytes of the %.0f of its byteLength", index, b->size, length);
}

ng_result ng_gltf_buffers(struct gltf_faults *faults, const struct ng_gltf_params *params,
                          const struct gltf_container *container, struct gltf_document *doc)
{
    const struct gltf_value *list = ng_gltf_array(doc->root, "buffers");
    struct reader r = {faults, params, container, doc, params->max_file_size};
    uint32_t count = list ? list->count : 0;
    struct gltf_buffer *buffers = ng_arena_array(&doc->arena, count, sizeof *buffers);
    if (!buffers)
        return ng_out_of_memory(faults->path);
    for (uint32_t i = 0; i < count; i++) {
        struct gltf_part part;
        ng_gltf_part_begin(&part, "what lies in it is lost");
        NG_TRY(ng_gltf_part_end(faults, &part, read_buffer(&r, i, &list->items[i], &buffers[i])));
        buffers[i].lost = part.lost;
        NG_TRY(check_length(&r, i, &list->items[i], &buffers[i]));
    }
    doc->buffers = buffers;
    doc->buffer_count = count;
    return NG_OK;
}

// ---- paths -----------------------------------------------------------------------------------------------
static bool file_path(const char *document, const char *name, char *out, size_t size, const char **why)
{
    *why = "is not a file in the document's directory or below";
    if (name[0] == 0 || name[0] == '/' || (name[0] && name[1] == ':') || strstr(name, "://"))
        return false;
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (part[0] == '.' && part[1] == '.' && (part[2] == '/' || part[2] == 0))
            return false;
    }
    *why = "the path is too long";
    if (!ng_path_beside(document, name, out, size))
        return false;
    *why = "is a link that leads out of the document's directory";
    return ng_file_is_below(out, document);
}

static int hex_digit(char c)
{
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    const char *at = c ? strchr(digits, c) : NULL;
    return at ? (int)(at - digits) % 16 : -1;
}

bool ng_gltf_uri_path(const char *document, const char *uri, char *out, size_t size, const char **why)
{
    char name[4096];
    size_t n = 0;
    for (const char *p = uri; *p && n + 1 < sizeof name; p++) {
        int high = *p == '%' ? hex_digit(p[1]) : -1, low = high >= 0 ? hex_digit(p[2]) : -1;
        name[n++] = low >= 0 ? (char)(high * 16 + low) : *p;
        p += low >= 0 ? 2 : 0;
    }
    name[n] = 0;
    *why = "holds the character %00";
    if (strlen(name) != n)
        return false;
    for (char *p = name; *p; p++) // folders as Windows writes them
        *p = *p == '\\' ? '/' : *p;
    return file_path(document, name, out, size, why);
}

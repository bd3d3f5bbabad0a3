// A GLB that grows: the text of each list of the document, and the bytes of one buffer, each accessor with a
// view of its own.
#include "asset/obj_internal.h"
#include "base/log.h"
#include "base/printable.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ng_obj_glb_finish(struct obj_glb *glb)
{
    for (int i = 0; i < OBJ_LIST_COUNT; i++)
        ng_array_finish(&glb->lists[i].text);
    ng_array_finish(&glb->bytes);
}

static void append(struct obj_text *t, bool *failed, const void *data, size_t size)
{
    if (*failed || size == 0)
        return;
    *failed = !ng_array_reserve(t, t->count + size);
    if (*failed)
        return;
    memcpy(t->items + t->count, data, size);
    t->count += size;
}

void ng_obj_text(struct obj_text *t, bool *failed, const char *fmt, ...)
{
    char text[1024];
    va_list args;
    va_start(args, fmt);
    int n = vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    append(t, failed, text, n < 0 ? 0 : (size_t)n < sizeof text ? (size_t)n : sizeof text - 1);
}

void ng_obj_string(struct obj_text *t, bool *failed, const char *text)
{
    append(t, failed, "\"", 1);
    while (*text) {
        const char *begin = text;
        uint32_t character = ng_next_character(&text);
        unsigned byte = (unsigned char)*begin;
        if (byte == '"' || byte == '\\')
            ng_obj_text(t, failed, "\\%c", (int)byte);
        else if (byte < 0x20 || character == NG_NO_CHARACTER)
            ng_obj_text(t, failed, "\\u%04x", byte);
        else
            append(t, failed, begin, (size_t)(text - begin));
    }
    append(t, failed, "\"", 1);
}

// ---- lists -----------------------------------------------------------------------------------------------
uint32_t ng_obj_begin(struct obj_glb *glb, enum obj_list list)
{
    if (glb->lists[list].count)
        append(&glb->lists[list].text, &glb->failed, ",\n", 2);
    return glb->lists[list].count++;
}

void ng_obj_item_string(struct obj_glb *glb, enum obj_list list, const char *text)
{
    ng_obj_string(&glb->lists[list].text, &glb->failed, text);
}

void ng_obj_append(struct obj_glb *glb, enum obj_list list, const struct obj_text *text)
{
    append(&glb->lists[list].text, &glb->failed, text->items, text->count);
}

uint32_t ng_obj_view(struct obj_glb *glb, const void *data, size_t size)
{
    static const char zeros[4] = {0};
    if (size > glb->limit - glb->bytes.count)
        glb->failed = true;
    append(&glb->bytes, &glb->failed, zeros, (4 - glb->bytes.count % 4) % 4);
    uint32_t view = ng_obj_begin(glb, OBJ_VIEWS);
    ng_obj_item(glb, OBJ_VIEWS, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", glb->bytes.count,
                size);
    append(&glb->bytes, &glb->failed, data, size);
    return view;
}

uint32_t ng_obj_accessor(struct obj_glb *glb, const void *data, size_t count, unsigned width, int type,
                         const char *more)
{
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    uint32_t view = ng_obj_view(glb, data, count * width * 4);
    uint32_t accessor = ng_obj_begin(glb, OBJ_ACCESSORS);
    ng_obj_item(glb, OBJ_ACCESSORS,
                "{\"bufferView\":%u,\"componentType\":%d,\"count\":%zu,\"type\":\"%s\"%s}", view, type, count,
                types[width], more);
    return accessor;
}

// ---- the file --------------------------------------------------------------------------------------------
static void write_head(struct obj_text *t, bool *failed, const struct obj_glb *glb, const char *title,
                       const char *copyright, const struct obj_text *roots)
{
    ng_obj_text(t, failed, "{\"asset\":{\"version\":\"2.0\"");
    if (copyright) {
        ng_obj_text(t, failed, ",\"copyright\":");
        ng_obj_string(t, failed, copyright);
    }
    ng_obj_text(t, failed, "},\"scene\":0,\"scenes\":[{");
    if (title) {
        ng_obj_text(t, failed, "\"name\":");
        ng_obj_string(t, failed, title);
        ng_obj_text(t, failed, ",");
    }
    ng_obj_text(t, failed, "\"nodes\":[");
    append(t, failed, roots->items, roots->count);
    ng_obj_text(t, failed,
                "]}],\"extensionsUsed\":[\"KHR_materials_emissive_strength\","
                "\"KHR_materials_specular\"]");
    if (glb->bytes.count)
        ng_obj_text(t, failed, ",\"buffers\":[{\"byteLength\":%zu}]", glb->bytes.count);
}

static void put_u32(unsigned char *at, size_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(value >> 8 * i);
}

// Header, JSON, bytes; the parts are multiples of 4 bytes.
static unsigned char *join(const struct obj_text *json, const struct obj_text *bytes, size_t *size)
{
    *size = 12 + 8 + json->count + (bytes->count ? 8 + bytes->count : 0);
    unsigned char *out = *size <= UINT32_MAX ? malloc(*size + 1) : NULL;
    if (!out)
        return NULL;
    memcpy(out, "glTF", 4);
    put_u32(out + 4, 2);
    put_u32(out + 8, *size);
    put_u32(out + 12, json->count);
    memcpy(out + 16, "JSON", 4);
    memcpy(out + 20, json->items, json->count);
    if (bytes->count) {
        unsigned char *chunk = out + 20 + json->count;
        put_u32(chunk, bytes->count);
        memcpy(chunk + 4, "BIN", 4);
        memcpy(chunk + 8, bytes->items, bytes->count);
    }
    out[*size] = 0;
    return out;
}

ng_result ng_obj_glb_end(struct obj_glb *glb, const char *path, const char *title, const char *copyright,
                         const struct obj_text *roots, unsigned char **out, size_t *size)
{
    static const char *const names[] = {"nodes",  "meshes",   "materials", "textures",
                                        "images", "samplers", "accessors", "bufferViews"};
    struct obj_text json = {0};
    append(&glb->bytes, &glb->failed, "\0\0\0", (4 - glb->bytes.count % 4) % 4);
    write_head(&json, &glb->failed, glb, title, copyright, roots);
    for (int i = 0; i < OBJ_LIST_COUNT; i++)
        if (glb->lists[i].count) {
            ng_obj_text(&json, &glb->failed, ",\n\"%s\":[", names[i]);
            append(&json, &glb->failed, glb->lists[i].text.items, glb->lists[i].text.count);
            ng_obj_text(&json, &glb->failed, "]");
        }
    ng_obj_text(&json, &glb->failed, "}");
    append(&json, &glb->failed, "   ", (4 - json.count % 4) % 4);
    *out = glb->failed ? NULL : join(&json, &glb->bytes, size);
    ng_array_finish(&json);
    if (*out)
        return NG_OK;
    ng_log_error("%s: needs more memory than a scene may have, %llu bytes" NG_GLTF_RAISE, path,
                 (unsigned long long)glb->limit);
    return NG_ERROR_MEMORY;
}

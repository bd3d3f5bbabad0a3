#include "asset/gltf_writer.h"

#include "base/result.h"

#include <cjson/cJSON.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const list_names[NG_GLTF_LIST_COUNT] = {
    "accessors", "animations", "buffers", "bufferViews", "cameras", "images", "lights",
    "materials", "meshes",     "nodes",   "samplers",    "scenes",  "skins",  "textures",
};

bool ng_gltf_bytes_append(struct ng_gltf_bytes *b, const void *data, size_t size)
{
    if (!size)
        return true;
    if (!ng_array_reserve(b, b->count + size))
        return false;
    memcpy(b->items + b->count, data, size);
    b->count += size;
    return true;
}

static cJSON *keep(struct ng_gltf_writer *w, cJSON *item)
{
    w->failed |= !item;
    return item;
}

// ---- the document ----------------------------------------------------------------------------------------

// Where a list stands; null if there is none.
static cJSON *find_list(const struct ng_gltf_writer *w, enum ng_gltf_list list)
{
    const cJSON *owner = w->root;
    if (list == NG_GLTF_LIGHTS)
        owner = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(owner, "extensions"),
                                                 "KHR_lights_punctual");
    cJSON *array = cJSON_GetObjectItemCaseSensitive(owner, list_names[list]);
    return cJSON_IsArray(array) ? array : NULL;
}

void ng_gltf_writer_init(struct ng_gltf_writer *w, cJSON *root)
{
    *w = (struct ng_gltf_writer){0};
    w->root = root ? root : keep(w, cJSON_CreateObject());
    for (int list = 0; list < NG_GLTF_LIST_COUNT; list++) {
        cJSON *item;
        cJSON_ArrayForEach(item, find_list(w, (enum ng_gltf_list)list)) w->failed |=
            !ng_array_push(&w->lists[list], item);
    }
}

void ng_gltf_writer_finish(struct ng_gltf_writer *w)
{
    cJSON_Delete(w->root);
    ng_array_finish(&w->data);
    ng_array_finish(&w->free_views);
    ng_array_finish(&w->free_accessors);
    for (int list = 0; list < NG_GLTF_LIST_COUNT; list++)
        ng_array_finish(&w->lists[list]);
    *w = (struct ng_gltf_writer){0};
}

// ---- GLB -------------------------------------------------------------------------------------------------

static void put32(unsigned char *p, size_t v)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(v >> (8 * i) & 255);
}

bool ng_gltf_put_header(struct ng_gltf_bytes *out)
{
    return ng_gltf_bytes_append(out, "glTF\2\0\0\0\0\0\0\0", 12);
}

bool ng_gltf_put_chunk(struct ng_gltf_bytes *out, uint32_t type, const void *data, size_t size)
{
    unsigned char head[8];
    size_t padded = (size + 3) / 4 * 4;
    put32(head, padded);
    put32(head + 4, type);
    return ng_gltf_bytes_append(out, head, 8) && ng_gltf_bytes_append(out, data, size) &&
           ng_gltf_bytes_append(out, type == NG_GLTF_CHUNK_JSON ? "   " : "\0\0\0", padded - size);
}

void ng_gltf_put_length(struct ng_gltf_bytes *out)
{
    put32(out->items + 8, out->count);
}

bool ng_gltf_writer_glb(struct ng_gltf_writer *w, struct ng_gltf_bytes *out)
{
    cJSON *buffer;
    ng_gltf_append(w, NG_GLTF_BUFFERS, &buffer);
    ng_gltf_json_number(w, buffer, "byteLength", (double)w->data.count);
    char *json = w->failed ? NULL : cJSON_PrintUnformatted(w->root);
    bool ok = json && ng_gltf_put_header(out) &&
              ng_gltf_put_chunk(out, NG_GLTF_CHUNK_JSON, json, strlen(json)) &&
              ng_gltf_put_chunk(out, NG_GLTF_CHUNK_BIN, w->data.items, w->data.count);
    if (ok)
        ng_gltf_put_length(out);
    cJSON_free(json);
    return ok;
}

// ---- JSON ------------------------------------------------------------------------------------------------

// Puts a value where an older one of that key is, or at the end.
static void put(struct ng_gltf_writer *w, cJSON *object, const char *key, cJSON *value)
{
    if (!keep(w, value))
        return;
    bool ok = cJSON_GetObjectItemCaseSensitive(object, key)
                  ? cJSON_ReplaceItemInObjectCaseSensitive(object, key, value)
                  : cJSON_AddItemToObject(object, key, value);
    if (!ok) {
        cJSON_Delete(value);
        w->failed = true;
    }
}

static cJSON *member(struct ng_gltf_writer *w, cJSON *object, const char *key, cJSON *(*create)(void))
{
    cJSON *item = object ? cJSON_GetObjectItemCaseSensitive(object, key) : NULL;
    if (item || !object)
        return item;
    put(w, object, key, create());
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

cJSON *ng_gltf_json_object(struct ng_gltf_writer *w, cJSON *object, const char *key)
{
    return member(w, object, key, cJSON_CreateObject);
}

cJSON *ng_gltf_json_list(struct ng_gltf_writer *w, cJSON *object, const char *key)
{
    return member(w, object, key, cJSON_CreateArray);
}

cJSON *ng_gltf_json_append(struct ng_gltf_writer *w, cJSON *array)
{
    cJSON *item = array ? keep(w, cJSON_CreateObject()) : NULL;
    if (item)
        cJSON_AddItemToArray(array, item);
    return item;
}

void ng_gltf_json_number(struct ng_gltf_writer *w, cJSON *object, const char *key, double value)
{
    if (object)
        put(w, object, key, cJSON_CreateNumber(value));
}

void ng_gltf_json_bool(struct ng_gltf_writer *w, cJSON *object, const char *key, bool value)
{
    if (object)
        put(w, object, key, cJSON_CreateBool(value));
}

void ng_gltf_json_text(struct ng_gltf_writer *w, cJSON *object, const char *key, const char *value)
{
    if (object && value)
        put(w, object, key, cJSON_CreateString(value));
}

void ng_gltf_json_numbers(struct ng_gltf_writer *w, cJSON *object, const char *key, const double *values,
                          size_t count)
{
    cJSON *list = object ? keep(w, cJSON_CreateArray()) : NULL;
    for (size_t i = 0; list && i < count; i++)
        cJSON_AddItemToArray(list, keep(w, cJSON_CreateNumber(values[i])));
    if (list)
        put(w, object, key, list);
}

static void use_extension(struct ng_gltf_writer *w, const char *name)
{
    cJSON *used = ng_gltf_json_list(w, w->root, "extensionsUsed"), *item;
    cJSON_ArrayForEach(item, used)
    {
        if (cJSON_IsString(item) && strcmp(item->valuestring, name) == 0)
            return;
    }
    if (used)
        cJSON_AddItemToArray(used, keep(w, cJSON_CreateString(name)));
}

cJSON *ng_gltf_json_extension(struct ng_gltf_writer *w, cJSON *object, const char *name)
{
    use_extension(w, name);
    return ng_gltf_json_object(w, ng_gltf_json_object(w, object, "extensions"), name);
}

cJSON *ng_gltf_json_component(struct ng_gltf_writer *w, cJSON *object, const char *name)
{
    cJSON *scene = ng_gltf_json_extension(w, object, "NG_scene");
    return ng_gltf_json_object(w, ng_gltf_json_object(w, scene, "components"), name);
}

int ng_gltf_append(struct ng_gltf_writer *w, enum ng_gltf_list list, cJSON **out)
{
    cJSON *owner =
        list == NG_GLTF_LIGHTS ? ng_gltf_json_extension(w, w->root, "KHR_lights_punctual") : w->root;
    *out = ng_gltf_json_append(w, ng_gltf_json_list(w, owner, list_names[list]));
    if (!*out || !ng_array_push(&w->lists[list], *out))
        w->failed = true;
    return w->failed ? 0 : (int)w->lists[list].count - 1;
}

cJSON *ng_gltf_at(const struct ng_gltf_writer *w, enum ng_gltf_list list, int index)
{
    return index >= 0 && (size_t)index < w->lists[list].count ? w->lists[list].items[index] : NULL;
}

// ---- data ------------------------------------------------------------------------------------------------

// A free place in a list, emptied, or a new one.
static int reuse(struct ng_gltf_writer *w, enum ng_gltf_list list, int **free_items, size_t *free_count,
                 cJSON **out)
{
    if (!*free_count)
        return ng_gltf_append(w, list, out);
    int index = (*free_items)[--*free_count];
    *out = ng_gltf_at(w, list, index);
    while ((*out)->child)
        cJSON_Delete(cJSON_DetachItemViaPointer(*out, (*out)->child));
    return index;
}

int ng_gltf_add_view(struct ng_gltf_writer *w, const void *data, size_t size, enum ng_gltf_target target)
{
    size_t at = w->data_offset + w->data.count;
    if (!ng_gltf_bytes_append(&w->data, data, size) ||
        !ng_gltf_bytes_append(&w->data, "\0\0\0", (4 - size % 4) % 4))
        w->failed = true;
    cJSON *view;
    int index = reuse(w, NG_GLTF_VIEWS, &w->free_views.items, &w->free_views.count, &view);
    ng_gltf_json_number(w, view, "buffer", w->buffer);
    ng_gltf_json_number(w, view, "byteOffset", (double)at);
    ng_gltf_json_number(w, view, "byteLength", (double)size);
    if (target != NG_GLTF_NO_TARGET)
        ng_gltf_json_number(w, view, "target", target);
    return index;
}

static size_t type_size(enum ng_gltf_component_type type)
{
    return type == NG_GLTF_U8 ? 1 : type == NG_GLTF_U16 ? 2 : 4;
}

int ng_gltf_add_accessor(struct ng_gltf_writer *w, const void *data, size_t count, unsigned width,
                         enum ng_gltf_component_type type, enum ng_gltf_target target, cJSON **out)
{
    static const char *const shapes[17] = {
        [1] = "SCALAR", [2] = "VEC2", [3] = "VEC3", [4] = "VEC4", [16] = "MAT4"};
    int view = ng_gltf_add_view(w, data, count * width * type_size(type), target);
    cJSON *accessor;
    int index = reuse(w, NG_GLTF_ACCESSORS, &w->free_accessors.items, &w->free_accessors.count, &accessor);
    ng_gltf_json_number(w, accessor, "bufferView", view);
    ng_gltf_json_number(w, accessor, "componentType", type);
    ng_gltf_json_number(w, accessor, "count", (double)count);
    ng_gltf_json_text(w, accessor, "type", shapes[width]);
    if (out)
        *out = accessor;
    return index;
}

static void set_bounds(struct ng_gltf_writer *w, cJSON *accessor, const float *values, size_t count,
                       unsigned width)
{
    double low[16], high[16];
    for (unsigned k = 0; k < width; k++) {
        low[k] = high[k] = (double)values[k];
        for (size_t i = 1; i < count; i++) {
            low[k] = fmin(low[k], (double)values[i * width + k]);
            high[k] = fmax(high[k], (double)values[i * width + k]);
        }
    }
    ng_gltf_json_numbers(w, accessor, "min", low, width);
    ng_gltf_json_numbers(w, accessor, "max", high, width);
}

int ng_gltf_add_floats(struct ng_gltf_writer *w, const float *values, size_t count, unsigned width,
                       enum ng_gltf_target target, bool bounds)
{
    cJSON *accessor;
    int index = ng_gltf_add_accessor(w, values, count, width, NG_GLTF_F32, target, &accessor);
    if (bounds)
        set_bounds(w, accessor, values, count, width);
    return index;
}

int ng_gltf_add_integers(struct ng_gltf_writer *w, const uint32_t *values, size_t count, unsigned width,
                         unsigned bytes, enum ng_gltf_target target, cJSON **out)
{
    uint32_t most = 0;
    for (size_t i = 0; i < count * width; i++)
        most = values[i] > most ? values[i] : most;
    if (!bytes)
        bytes = most < UINT8_MAX ? 1 : most < UINT16_MAX ? 2 : 4;
    unsigned char *data = malloc(count * width * bytes + 1);
    if (!data) {
        w->failed = true;
        if (out)
            *out = NULL;
        return 0;
    }
    for (size_t i = 0; i < count * width; i++)
        for (unsigned k = 0; k < bytes; k++)
            data[i * bytes + k] = (unsigned char)(values[i] >> (8 * k) & 255);
    enum ng_gltf_component_type type = bytes == 1 ? NG_GLTF_U8 : bytes == 2 ? NG_GLTF_U16 : NG_GLTF_U32;
    int index = ng_gltf_add_accessor(w, data, count, width, type, target, out);
    free(data);
    return index;
}

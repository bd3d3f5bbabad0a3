// The values of a document as a text that tinygltf takes, whatever is wrong with the file.
//
// tinygltf gives up a file at the first thing that it needs and does not find. So this text has what the
// engine uses of a document, whole numbers as such, and something neutral wherever the file has nothing, or
// nothing that tinygltf takes; gltf_document.c puts what the file has there in its place again. Buffers and
// images are read elsewhere and are not in it.
//
// A text has some items of one list, since tinygltf takes up to a thousand times the bytes that the file has
// for an item: a million empty ones must not cost gigabytes. Whatever needs two lists is looked up later.
#include "asset/gltf_internal.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct writer {
    struct gltf_normal *out;
    bool failed; // out of memory
};

// ---- what tinygltf reads ---------------------------------------------------------------------------------
enum kind { TEXT, BOOLEAN, NUMBER, NUMBERS, SIZE, INTEGER, INTEGERS, OBJECT, INDICES };

struct property {
    const char *name;    // null: the end
    enum kind kind;      // INTEGER fits an int; INDICES: by any name
    const char *neutral; // JSON where there is nothing to write (OBJECT: any); null: the property is left out
    const struct property *members;            // of an OBJECT
    bool (*takes)(const struct gltf_value *v); // null: tinygltf takes all
};

static bool takes_stride(const struct gltf_value *v)
{
    return v->number <= 252 && fmod(v->number, 4) == 0;
}

static bool takes_component_type(const struct gltf_value *v)
{
    return v->number >= GLTF_I8 && v->number <= GLTF_F64;
}

static bool takes_type(const struct gltf_value *v)
{
    return ng_gltf_type_width(v->string) != 0;
}

static bool takes_camera(const struct gltf_value *v)
{
    return strcmp(v->string, "perspective") == 0 || strcmp(v->string, "orthographic") == 0;
}

static bool takes_three(const struct gltf_value *v)
{
    return v->count == 3;
}

static bool takes_four(const struct gltf_value *v)
{
    return v->count == 4;
}

#define PROPERTIES static const struct property
#define P(property, type, ...)                                                                               \
    {                                                                                                        \
        .name = (property), .kind = (type), __VA_ARGS__                                                      \
    }
#define NEUTRAL(json) .neutral = (json)
PROPERTIES view[] = {P("buffer", INTEGER, NEUTRAL("-1")),
                     P("byteOffset", SIZE),
                     P("byteLength", SIZE, NEUTRAL("0")),
                     P("byteStride", SIZE, .takes = takes_stride),
                     {0}};

PROPERTIES sparse_indices[] = {P("bufferView", INTEGER, NEUTRAL("-1")),
                               P("byteOffset", SIZE),
                               P("componentType", INTEGER, NEUTRAL("0")),
                               {0}};
PROPERTIES sparse_values[] = {P("bufferView", INTEGER, NEUTRAL("-1")), P("byteOffset", SIZE), {0}};
PROPERTIES sparse[] = {P("count", SIZE, NEUTRAL("0")),
                       P("indices", OBJECT, NEUTRAL("{}"), .members = sparse_indices),
                       P("values", OBJECT, NEUTRAL("{}"), .members = sparse_values),
                       {0}};
PROPERTIES accessor[] = {
    P("bufferView", INTEGER),
    P("byteOffset", SIZE),
    P("count", SIZE, NEUTRAL("0")),
    P("componentType", INTEGER, NEUTRAL("5130"), .takes = takes_component_type), // GLTF_F64
    P("type", TEXT, NEUTRAL("\"SCALAR\""), .takes = takes_type),
    P("normalized", BOOLEAN),
    P("sparse", OBJECT, .members = sparse),
    {0}};

PROPERTIES primitive[] = {
    P("attributes", INDICES, NEUTRAL("{}")), P("material", INTEGER), P("mode", INTEGER), {0}};
PROPERTIES mesh[] = {P("name", TEXT), P("weights", NUMBERS), {0}};

PROPERTIES node[] = {P("name", TEXT),
                     P("mesh", INTEGER),
                     P("skin", INTEGER),
                     P("camera", INTEGER),
                     P("matrix", NUMBERS),
                     P("translation", NUMBERS),
                     P("rotation", NUMBERS),
                     P("scale", NUMBERS),
                     P("weights", NUMBERS),
                     P("children", INTEGERS),
                     {0}};

PROPERTIES texture_use[] = {
    P("index", INTEGER, NEUTRAL("-1")), P("texCoord", INTEGER), P("scale", NUMBER), {0}};
PROPERTIES roughness[] = {P("baseColorFactor", NUMBERS, .takes = takes_four),
                          P("metallicFactor", NUMBER),
                          P("roughnessFactor", NUMBER),
                          P("baseColorTexture", OBJECT, .members = texture_use),
                          P("metallicRoughnessTexture", OBJECT, .members = texture_use),
                          {0}};
PROPERTIES material[] = {P("name", TEXT),
                         P("alphaMode", TEXT),
                         P("alphaCutoff", NUMBER),
                         P("doubleSided", BOOLEAN),
                         P("emissiveFactor", NUMBERS, .takes = takes_three),
                         P("pbrMetallicRoughness", OBJECT, .members = roughness),
                         P("normalTexture", OBJECT, .members = texture_use),
                         P("emissiveTexture", OBJECT, .members = texture_use),
                         {0}};

PROPERTIES texture[] = {P("source", INTEGER), P("sampler", INTEGER), {0}};
PROPERTIES sampler[] = {
    P("magFilter", INTEGER), P("minFilter", INTEGER), P("wrapS", INTEGER), P("wrapT", INTEGER), {0}};

PROPERTIES perspective[] = {P("yfov", NUMBER, NEUTRAL("0")), P("znear", NUMBER, NEUTRAL("0")), {0}};
PROPERTIES orthographic[] = {P("xmag", NUMBER, NEUTRAL("0")),
                             P("ymag", NUMBER, NEUTRAL("0")),
                             P("zfar", NUMBER, NEUTRAL("0")),
                             P("znear", NUMBER, NEUTRAL("0")),
                             {0}};
PROPERTIES camera[] = {P("type", TEXT, NEUTRAL("\"orthographic\""), .takes = takes_camera),
                       P("perspective", OBJECT, NEUTRAL("{}"), .members = perspective),
                       P("orthographic", OBJECT, NEUTRAL("{}"), .members = orthographic),
                       {0}};

// tinygltf's own default angle is a quarter of pi of ten digits only.
PROPERTIES spot[] = {
    P("innerConeAngle", NUMBER), P("outerConeAngle", NUMBER, NEUTRAL("0.78539816339744830962")), {0}};
PROPERTIES light[] = {P("name", TEXT),
                      P("type", TEXT, NEUTRAL("\"\"")),
                      P("color", NUMBERS),
                      P("intensity", NUMBER),
                      P("spot", OBJECT, NEUTRAL("{}"), .members = spot),
                      {0}};

PROPERTIES skin[] = {P("name", TEXT),
                     P("inverseBindMatrices", INTEGER, NEUTRAL("-1")),
                     P("skeleton", INTEGER),
                     P("joints", INTEGERS, NEUTRAL("[]")),
                     {0}};

PROPERTIES target[] = {P("node", INTEGER, NEUTRAL("-1")), P("path", TEXT, NEUTRAL("\"\"")), {0}};
PROPERTIES channel[] = {
    P("sampler", INTEGER, NEUTRAL("-1")), P("target", OBJECT, NEUTRAL("{}"), .members = target), {0}};
PROPERTIES keys[] = {
    P("input", INTEGER, NEUTRAL("-1")), P("output", INTEGER, NEUTRAL("-1")), P("interpolation", TEXT), {0}};
PROPERTIES animation[] = {P("name", TEXT), {0}};

PROPERTIES scene[] = {P("name", TEXT), P("nodes", INTEGERS), {0}};

// A list of the document, or (`within`) all of a list that its items have, one after the other.
static const struct list {
    const char *name, *within;
    const struct property *members; // of an item
    const char *before, *after;     // the items in the text
} lists[GLTF_LIST_COUNT] = {
    [GLTF_VIEWS] = {"bufferViews", NULL, view, "\"bufferViews\":[", "]"},
    [GLTF_ACCESSORS] = {"accessors", NULL, accessor, "\"accessors\":[", "]"},
    [GLTF_MESHES] = {"meshes", NULL, mesh, "\"meshes\":[", "]"},
    [GLTF_PRIMITIVES] = {"meshes", "primitives", primitive, "\"meshes\":[{\"primitives\":[", "]}]"},
    [GLTF_NODES] = {"nodes", NULL, node, "\"nodes\":[", "]"},
    [GLTF_MATERIALS] = {"materials", NULL, material, "\"materials\":[", "]"},
    [GLTF_TEXTURES] = {"textures", NULL, texture, "\"textures\":[", "]"},
    [GLTF_SAMPLERS] = {"samplers", NULL, sampler, "\"samplers\":[", "]"},
    [GLTF_CAMERAS] = {"cameras", NULL, camera, "\"cameras\":[", "]"},
    [GLTF_LIGHTS] = {"lights", NULL, light, "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[", "]}}"},
    [GLTF_SKINS] = {"skins", NULL, skin, "\"skins\":[", "]"},
    [GLTF_ANIMATIONS] = {"animations", NULL, animation, "\"animations\":[", "]"},
    [GLTF_CHANNELS] = {"animations", "channels", channel, "\"animations\":[{\"channels\":[", "]}]"},
    [GLTF_KEYS] = {"animations", "samplers", keys, "\"animations\":[{\"samplers\":[", "]}]"},
    [GLTF_SCENES] = {"scenes", NULL, scene, "\"scenes\":[", "]"},
};

// ---- the text --------------------------------------------------------------------------------------------
static void put_bytes(struct writer *w, const char *text, size_t size)
{
    struct gltf_normal *out = w->out;
    w->failed = w->failed || !ng_array_reserve(out, out->count + size);
    if (w->failed || size == 0)
        return;
    memcpy(out->items + out->count, text, size);
    out->count += size;
}

static void put(struct writer *w, const char *text)
{
    put_bytes(w, text, strlen(text));
}

static void put_number(struct writer *w, double v)
{
    char text[NG_GLTF_NUMBER_SIZE];
    put_bytes(w, text, ng_gltf_number_text(v, text));
}

// -0.0, which is whole to the file, is so to tinygltf without its sign.
static void put_whole(struct writer *w, double v)
{
    put_number(w, v == 0 ? 0 : v);
}

static void put_string(struct writer *w, const char *text)
{
    put(w, "\"");
    for (const char *p = text; *p;) {
        size_t plain = 0;
        while ((unsigned char)p[plain] >= ' ' && p[plain] != '"' && p[plain] != '\\')
            plain++;
        put_bytes(w, p, plain);
        p += plain;
        if (*p) {
            char escaped[8];
            snprintf(escaped, sizeof escaped, "\\u%04x", (unsigned)(unsigned char)*p++);
            put(w, escaped);
        }
    }
    put(w, "\"");
}

// Begins a value: the place of a member, or of an item (null).
static void put_place(struct writer *w, bool first, const char *key)
{
    if (!first)
        put(w, ",");
    if (!key)
        return;
    put_string(w, key);
    put(w, ":");
}

// Whole ones are indices, of which those that are none become -1.
static void put_numbers(struct writer *w, const struct gltf_value *v, bool whole)
{
    put(w, "[");
    for (uint32_t i = 0; i < v->count; i++) {
        const struct gltf_value *item = &v->items[i];
        put_place(w, i == 0, NULL);
        if (whole)
            put_whole(w, item->kind == GLTF_NUMBER ? item->number : -1);
        else
            put_number(w, item->number);
    }
    put(w, "]");
}

static void put_indices(struct writer *w, const struct gltf_value *v)
{
    bool first = true;
    put(w, "{");
    for (uint32_t i = 0; v->kind == GLTF_OBJECT && i < v->count; i++)
        if (v->items[i].kind == GLTF_NUMBER) {
            put_place(w, first, v->items[i].key);
            put_whole(w, v->items[i].number);
            first = false;
        }
    put(w, "}");
}

// Null for an object that is not there.
static void put_object(struct writer *w, const struct property *members, const struct gltf_value *v);

static void put_value(struct writer *w, const struct property *p, const struct gltf_value *v)
{
    switch (p->kind) {
    case TEXT:
        put_string(w, v->string);
        break;
    case BOOLEAN:
        put(w, v->boolean ? "true" : "false");
        break;
    case NUMBER:
        put_number(w, v->number);
        break;
    case SIZE:
    case INTEGER:
        put_whole(w, v->number);
        break;
    case NUMBERS:
    case INTEGERS:
        put_numbers(w, v, p->kind == INTEGERS);
        break;
    case OBJECT:
        put_object(w, p->members, v);
        break;
    case INDICES:
        put_indices(w, v);
        break;
    }
}

// ---- values ----------------------------------------------------------------------------------------------
// Whether a value is of the property's type and tinygltf takes it.
static bool is_taken(const struct property *p, const struct gltf_value *v)
{
    static const enum gltf_kind kinds[] = {
        [TEXT] = GLTF_STRING,    [BOOLEAN] = GLTF_BOOL,  [NUMBER] = GLTF_NUMBER,
        [NUMBERS] = GLTF_ARRAY,  [SIZE] = GLTF_NUMBER,   [INTEGER] = GLTF_NUMBER,
        [INTEGERS] = GLTF_ARRAY, [OBJECT] = GLTF_OBJECT, [INDICES] = GLTF_OBJECT};
    if (!v || v->kind != kinds[p->kind])
        return false;
    if (p->kind == INTEGER && v->number > INT32_MAX)
        return false;
    if (p->kind == NUMBERS && ng_gltf_number_count(v) == 0) // else a matrix that is none hides the rotation
        return false;
    return !p->takes || p->takes(v);
}

static void put_object(struct writer *w, const struct property *members, const struct gltf_value *v)
{
    bool first = true;
    put(w, "{");
    for (const struct property *p = members; p->name; p++) {
        const struct gltf_value *member = ng_gltf_member(v, p->name);
        bool taken = is_taken(p, member);
        if (!taken && !p->neutral)
            continue;
        put_place(w, first, p->name);
        first = false;
        if (taken)
            put_value(w, p, member);
        else if (p->kind == OBJECT)
            put_object(w, p->members, NULL);
        else
            put(w, p->neutral);
    }
    put(w, "}");
}

// ---- some items of a list --------------------------------------------------------------------------------
static const struct gltf_value *outer_list(const struct gltf_value *root, enum gltf_list list)
{
    const struct gltf_value *owner = root;
    if (list == GLTF_LIGHTS)
        owner = ng_gltf_member(ng_gltf_member(root, "extensions"), "KHR_lights_punctual");
    return ng_gltf_array(owner, lists[list].name);
}

size_t ng_gltf_list_count(const struct gltf_value *root, enum gltf_list list)
{
    const struct gltf_value *outer = outer_list(root, list);
    size_t count = outer ? outer->count : 0, sum = 0;
    if (!lists[list].within)
        return count;
    for (size_t i = 0; i < count; i++) {
        const struct gltf_value *inner = ng_gltf_array(&outer->items[i], lists[list].within);
        sum += inner ? inner->count : 0;
    }
    return sum;
}

// The next item, or null.
static const struct gltf_value *next_item(struct gltf_normal *n)
{
    const char *within = lists[n->list].within;
    for (; n->outer && n->next < n->outer->count; n->next++) {
        const struct gltf_value *item = &n->outer->items[n->next];
        const struct gltf_value *inner = within ? ng_gltf_array(item, within) : NULL;
        if (!within) {
            n->next++;
            return item;
        }
        if (inner && n->next_within < inner->count)
            return &inner->items[n->next_within++];
        n->next_within = 0;
    }
    return NULL;
}

void ng_gltf_normal_begin(struct gltf_normal *n, const struct gltf_value *root, enum gltf_list list)
{
    *n = (struct gltf_normal){.list = list, .outer = outer_list(root, list)};
}

bool ng_gltf_normal_next(struct gltf_normal *n)
{
    enum { MOST_ITEMS = 1024, ENOUGH_TEXT = 256 << 10 };
    struct writer w = {.out = n};
    const struct gltf_value *item;
    n->count = n->item_count = 0;
    put(&w, "{\"asset\":{\"version\":\"\"},");
    put(&w, lists[n->list].before);
    while (n->item_count < MOST_ITEMS && n->count < ENOUGH_TEXT && (item = next_item(n))) {
        put_place(&w, n->item_count++ == 0, NULL);
        put_object(&w, lists[n->list].members, item);
    }
    put(&w, lists[n->list].after);
    put(&w, "}");
    return !w.failed;
}

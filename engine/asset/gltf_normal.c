// The values of a document as a text that tinygltf takes, whatever is wrong with the file.
//
// tinygltf gives up a file at the first thing that it needs and does not find. So this text has what the
// engine uses of a document, whole numbers as such, and something neutral wherever the file has nothing, or
// nothing that tinygltf takes; gltf_document.c puts what the file has there in its place again. Buffers and
// images are read elsewhere and are not in it. Items keep their places, so indices are those of the file.
#include "asset/gltf_internal.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct writer {
    struct gltf_normal *out;
    bool failed;  // out of memory
    bool *viewed; // of each accessor: its buffer view is one of the file's
    uint32_t accessor_count;
};

// ---- what tinygltf reads ---------------------------------------------------------------------------------
enum kind { TEXT, BOOLEAN, NUMBER, NUMBERS, SIZE, INTEGER, INTEGERS, OBJECT, LIST, INDICES, INDICES_LIST };

struct property {
    const char *name;    // null: the end
    enum kind kind;      // INTEGER fits an int; INDICES: by any name
    const char *neutral; // JSON where there is nothing to write (OBJECT: any); null: the property is left out
    const struct property *members;                                    // of an OBJECT, of each item of a LIST
    bool (*takes)(const struct writer *w, const struct gltf_value *v); // null: tinygltf takes all
};

static bool takes_stride(const struct writer *w, const struct gltf_value *v)
{
    NG_UNUSED(w);
    return v->number <= 252 && fmod(v->number, 4) == 0;
}

static bool takes_component_type(const struct writer *w, const struct gltf_value *v)
{
    NG_UNUSED(w);
    return v->number >= GLTF_I8 && v->number <= GLTF_F64;
}

static bool takes_type(const struct writer *w, const struct gltf_value *v)
{
    NG_UNUSED(w);
    return ng_gltf_type_width(v->string) != 0;
}

// Indices without bytes in the file are valid: extensions compress them.
static bool takes_indices(const struct writer *w, const struct gltf_value *v)
{
    return v->number >= 0 && v->number < w->accessor_count && w->viewed[(size_t)v->number];
}

static bool takes_camera(const struct writer *w, const struct gltf_value *v)
{
    NG_UNUSED(w);
    return strcmp(v->string, "perspective") == 0 || strcmp(v->string, "orthographic") == 0;
}

static bool takes_three(const struct writer *w, const struct gltf_value *v)
{
    NG_UNUSED(w);
    return v->count == 3;
}

static bool takes_four(const struct writer *w, const struct gltf_value *v)
{
    NG_UNUSED(w);
    return v->count == 4;
}

#define PROPERTIES static const struct property
#define P(property, type, ...)                                                                               \
    {                                                                                                        \
        .name = (property), .kind = (type), __VA_ARGS__                                                      \
    }
#define NEUTRAL(json) .neutral = (json)
PROPERTIES asset[] = {P("version", TEXT, NEUTRAL("\"\"")), {0}};

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

PROPERTIES primitive[] = {P("attributes", INDICES, NEUTRAL("{}")),
                          P("indices", INTEGER, .takes = takes_indices),
                          P("material", INTEGER),
                          P("mode", INTEGER),
                          P("targets", INDICES_LIST),
                          {0}};
PROPERTIES mesh[] = {
    P("name", TEXT), P("primitives", LIST, .members = primitive), P("weights", NUMBERS), {0}};

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
PROPERTIES lights_punctual[] = {P("lights", LIST, .members = light), {0}};
PROPERTIES extensions[] = {P("KHR_lights_punctual", OBJECT, .members = lights_punctual), {0}};

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
PROPERTIES animation[] = {
    P("name", TEXT), P("channels", LIST, .members = channel), P("samplers", LIST, .members = keys), {0}};

PROPERTIES scene[] = {P("name", TEXT), P("nodes", INTEGERS), {0}};

PROPERTIES document[] = {P("asset", OBJECT, NEUTRAL("{}"), .members = asset),
                         P("bufferViews", LIST, .members = view),
                         P("accessors", LIST, .members = accessor),
                         P("meshes", LIST, .members = mesh),
                         P("nodes", LIST, .members = node),
                         P("materials", LIST, .members = material),
                         P("textures", LIST, .members = texture),
                         P("samplers", LIST, .members = sampler),
                         P("cameras", LIST, .members = camera),
                         P("extensions", OBJECT, .members = extensions),
                         P("skins", LIST, .members = skin),
                         P("animations", LIST, .members = animation),
                         P("scenes", LIST, .members = scene),
                         P("scene", INTEGER),
                         {0}};

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
    w->out->value_count++;
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

static void put_list(struct writer *w, const struct property *p, const struct gltf_value *v);

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
    case LIST:
    case INDICES_LIST:
        put_list(w, p, v);
        break;
    }
}

// ---- values ----------------------------------------------------------------------------------------------
// Whether a value is of the property's type and tinygltf takes it.
static bool is_taken(const struct writer *w, const struct property *p, const struct gltf_value *v)
{
    static const enum gltf_kind kinds[] = {
        [TEXT] = GLTF_STRING, [BOOLEAN] = GLTF_BOOL,   [NUMBER] = GLTF_NUMBER,     [NUMBERS] = GLTF_ARRAY,
        [SIZE] = GLTF_NUMBER, [INTEGER] = GLTF_NUMBER, [INTEGERS] = GLTF_ARRAY,    [OBJECT] = GLTF_OBJECT,
        [LIST] = GLTF_ARRAY,  [INDICES] = GLTF_OBJECT, [INDICES_LIST] = GLTF_ARRAY};
    if (!v || v->kind != kinds[p->kind])
        return false;
    if (p->kind == INTEGER && v->number > INT32_MAX)
        return false;
    if (p->kind == NUMBERS && ng_gltf_number_count(v) == 0) // else a matrix that is none hides the rotation
        return false;
    return !p->takes || p->takes(w, v);
}

static void put_object(struct writer *w, const struct property *members, const struct gltf_value *v)
{
    bool first = true;
    put(w, "{");
    for (const struct property *p = members; p->name; p++) {
        const struct gltf_value *member = ng_gltf_member(v, p->name);
        bool taken = is_taken(w, p, member);
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

static void put_list(struct writer *w, const struct property *p, const struct gltf_value *v)
{
    put(w, "[");
    for (uint32_t i = 0; i < v->count; i++) {
        put_place(w, i == 0, NULL);
        if (p->kind == LIST)
            put_object(w, p->members, &v->items[i]);
        else
            put_indices(w, &v->items[i]);
    }
    put(w, "]");
}

// ---- the document ----------------------------------------------------------------------------------------
static bool find_viewed(struct writer *w, const struct gltf_value *root)
{
    const struct gltf_value *accessors = ng_gltf_array(root, "accessors");
    const struct gltf_value *views = ng_gltf_array(root, "bufferViews");
    w->accessor_count = accessors ? accessors->count : 0;
    w->viewed = calloc(w->accessor_count + (size_t)1, sizeof *w->viewed);
    for (uint32_t i = 0; w->viewed && i < w->accessor_count; i++) {
        int at = ng_gltf_index(&accessors->items[i], "bufferView", -1);
        w->viewed[i] = views && at >= 0 && (uint32_t)at < views->count;
    }
    return w->viewed != NULL;
}

bool ng_gltf_normal(const struct gltf_value *root, struct gltf_normal *out)
{
    struct writer w = {.out = out};
    *out = (struct gltf_normal){0};
    w.failed = !find_viewed(&w, root);
    if (!w.failed)
        put_object(&w, document, root);
    free(w.viewed);
    if (w.failed)
        ng_array_finish(out);
    return !w.failed;
}

// The JSON of a file as the tree that saving changes.
//
// What is only the file's stays the text that it was: extras, extensions that are not known, and numbers that
// a double does not hold. So it comes back byte for byte, and costs one value however long it is.
#include "asset/gltf_origin_internal.h"
#include "base/array.h"

#include <cjson/cJSON.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_DEPTH = 128 }; // loading has seen that there are fewer

struct reader {
    const char *at, *end; // a zero byte follows
    bool failed;          // out of memory, or no JSON
    size_t left;          // values that may be made
};

// ---- tokens ----------------------------------------------------------------------------------------------
static void skip_space(struct reader *r)
{
    while (r->at < r->end && strchr(" \t\r\n", *r->at) && *r->at)
        r->at++;
}

static bool take(struct reader *r, char c)
{
    skip_space(r);
    if (r->at >= r->end || *r->at != c)
        return false;
    r->at++;
    return true;
}

static void skip_string(struct reader *r)
{
    for (r->at++; r->at < r->end && *r->at != '"'; r->at++)
        r->at += *r->at == '\\';
    r->at = r->at < r->end ? r->at + 1 : r->end;
}

static void skip_scalar(struct reader *r)
{
    if (*r->at == '"')
        skip_string(r);
    else
        while (r->at < r->end && *r->at && !strchr(",:[]{}\" \t\r\n", *r->at))
            r->at++;
}

// Past a value of any kind.
static void skip_value(struct reader *r)
{
    size_t open = 0;
    do {
        const char *begin = r->at;
        skip_space(r);
        if (r->at < r->end && strchr("[{", *r->at) && *r->at) {
            open++;
            r->at++;
        } else if (r->at < r->end && strchr("]},:", *r->at) && *r->at) {
            open -= *r->at == ']' || *r->at == '}';
            r->at++;
        } else if (r->at < r->end) {
            skip_scalar(r);
        }
        r->failed |= r->at == begin;
    } while (open && !r->failed);
}

// ---- values ----------------------------------------------------------------------------------------------
static cJSON *made(struct reader *r, cJSON *value)
{
    if (!value || !r->left) {
        cJSON_Delete(value);
        r->failed = true;
        return NULL;
    }
    r->left--;
    return value;
}

static char *copy_text(const char *begin, size_t size)
{
    char *text = malloc(size + 1);
    if (text) {
        memcpy(text, begin, size);
        text[size] = 0;
    }
    return text;
}

static cJSON *raw(struct reader *r, const char *begin)
{
    char *text = r->failed ? NULL : copy_text(begin, (size_t)(r->at - begin));
    cJSON *value = text ? cJSON_CreateRaw(text) : NULL;
    free(text);
    return made(r, value);
}

static cJSON *read_as_it_is(struct reader *r)
{
    skip_space(r);
    const char *begin = r->at;
    skip_value(r);
    return raw(r, begin);
}

// A string of C ends where this one has a zero.
static bool has_zero(const char *begin, const char *end)
{
    for (; begin + 6 <= end; begin += *begin == '\\' ? 2 : 1)
        if (strncmp(begin, "\\u0000", 6) == 0)
            return true;
    return false;
}

static cJSON *read_string(struct reader *r)
{
    const char *begin = r->at;
    skip_string(r);
    cJSON *text = has_zero(begin, r->at) ? NULL : cJSON_ParseWithLength(begin, (size_t)(r->at - begin));
    return text ? made(r, text) : raw(r, begin); // cJSON takes no halves of characters
}

// Loading reads a whole number as such, which has no -0.
static cJSON *read_number(struct reader *r)
{
    const double exact = 9007199254740992; // 2^53
    const char *begin = r->at;
    char *end;
    double v = strtod(begin, &end);
    skip_scalar(r);
    bool whole = !memchr(begin, '.', (size_t)(r->at - begin)) && v == floor(v);
    if (end != r->at || !isfinite(v) || (whole && fabs(v) >= exact))
        return raw(r, begin);
    return made(r, cJSON_CreateNumber(whole && v == 0 ? 0 : v));
}

static cJSON *read_value(struct reader *r, unsigned depth, bool extensions);

static cJSON *read_array(struct reader *r, unsigned depth)
{
    cJSON *array = made(r, cJSON_CreateArray());
    r->at++;
    while (!r->failed && !take(r, ']')) {
        cJSON_AddItemToArray(array, read_value(r, depth, false));
        take(r, ',');
    }
    return array;
}

// The name of a member; null: it cannot be a name in C.
static char *read_key(struct reader *r)
{
    skip_space(r);
    const char *begin = r->at;
    if (r->at >= r->end || *r->at != '"') {
        r->failed = true;
        return NULL;
    }
    skip_string(r);
    if (has_zero(begin, r->at))
        return NULL;
    cJSON *text = cJSON_ParseWithLength(begin, (size_t)(r->at - begin));
    char *key = cJSON_IsString(text) ? copy_text(text->valuestring, strlen(text->valuestring)) : NULL;
    r->failed |= text && !key;
    cJSON_Delete(text);
    return key;
}

static cJSON *read_member(struct reader *r, const char *key, unsigned depth, bool of_extensions)
{
    bool unknown =
        of_extensions && !ng_gltf_knows_extension(key) && strcmp(key, "KHR_materials_variants") != 0;
    if (unknown || strcmp(key, "extras") == 0)
        return read_as_it_is(r);
    return read_value(r, depth, strcmp(key, "extensions") == 0);
}

// ---- members of one name ---------------------------------------------------------------------------------
struct member {
    cJSON *item;
    size_t place;
};

static int compare_members(const void *a, const void *b)
{
    const struct member *x = a, *y = b;
    int by_name = strcmp(x->item->string, y->item->string);
    return by_name ? by_name : (x->place > y->place) - (x->place < y->place);
}

// Of members with one name the last counts, as when loading.
static void keep_the_last(struct reader *r, cJSON *object, size_t count)
{
    if (count < 2 || r->failed)
        return;
    struct member *members = malloc(count * sizeof *members);
    size_t n = 0;
    r->failed = !members;
    for (cJSON *item = members ? object->child : NULL; item && n < count; item = item->next, n++)
        members[n] = (struct member){item, n};
    if (n > 1)
        qsort(members, n, sizeof *members, compare_members);
    for (size_t i = 0; i + 1 < n; i++)
        if (strcmp(members[i].item->string, members[i + 1].item->string) == 0)
            cJSON_Delete(cJSON_DetachItemViaPointer(object, members[i].item));
    free(members);
}

static cJSON *read_object(struct reader *r, unsigned depth, bool extensions)
{
    cJSON *object = made(r, cJSON_CreateObject());
    size_t count = 0;
    r->at++;
    while (!r->failed && !take(r, '}')) {
        char *key = read_key(r);
        r->failed |= !take(r, ':');
        cJSON *value = r->failed ? NULL : read_member(r, key ? key : "extras", depth, extensions);
        if (!key || !value || !cJSON_AddItemToObject(object, key, value))
            cJSON_Delete(value);
        else
            count++;
        free(key);
        take(r, ',');
    }
    keep_the_last(r, object, count);
    return object;
}

static cJSON *read_value(struct reader *r, unsigned depth, bool extensions)
{
    skip_space(r);
    if (r->at >= r->end || depth >= MAX_DEPTH) {
        r->failed = true;
        return NULL;
    }
    const char *begin = r->at;
    switch (*r->at) {
    case '{':
        return read_object(r, depth + 1, extensions);
    case '[':
        return read_array(r, depth + 1);
    case '"':
        return read_string(r);
    case 't':
    case 'f':
    case 'n':
        skip_scalar(r);
        return made(r, cJSON_ParseWithLength(begin, (size_t)(r->at - begin)));
    default:
        return read_number(r);
    }
}

cJSON *ng_gltf_origin_json(const char *text, size_t size, size_t max_values)
{
    bool marked = size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0;
    struct reader r = {.at = text + (marked ? 3 : 0), .end = text + size, .left = max_values};
    cJSON *root = read_value(&r, 0, false);
    if (!r.failed)
        return root;
    cJSON_Delete(root);
    return NULL;
}

// ---- comparing -------------------------------------------------------------------------------------------
bool ng_gltf_json_same(const cJSON *a, const cJSON *b)
{
    if ((a->type & 0xff) != (b->type & 0xff))
        return false;
    if (cJSON_IsNumber(a))
        return a->valuedouble == b->valuedouble && signbit(a->valuedouble) == signbit(b->valuedouble);
    if (cJSON_IsString(a) || cJSON_IsRaw(a))
        return strcmp(a->valuestring, b->valuestring) == 0;
    for (a = a->child, b = b->child; a && b; a = a->next, b = b->next)
        if ((a->string && strcmp(a->string, b->string) != 0) || !ng_gltf_json_same(a, b))
            return false;
    return !a && !b;
}

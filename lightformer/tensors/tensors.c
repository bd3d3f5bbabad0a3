// A file is put together in memory and written at once. The hash's place is the same in every file, because
// its note comes first.
#include "lightformer/tensors/tensors.h"

#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "base/system.h"
#include "lightformer/tensors/json_reader.h"
#include "lightformer/tensors/text.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAD        "{\"__metadata__\":{\"hash\":\""
#define HASH_AT     (8 + sizeof HEAD - 1)
#define HASH_DIGITS 16

static const struct {
    const char *name;
    uint32_t size;
} dtypes[] = {[LF_F32] = {"F32", 4}, [LF_I32] = {"I32", 4}, [LF_F16] = {"F16", 2}, [LF_U8] = {"U8", 1}};

uint32_t lf_dtype_size(enum lf_dtype dtype)
{
    return dtypes[dtype].size;
}

const char *lf_dtype_name(enum lf_dtype dtype)
{
    return dtypes[dtype].name;
}

// False if it is more than the limit.
static bool size_of(enum lf_dtype dtype, uint32_t rank, const uint64_t *shape, uint64_t *out)
{
    uint64_t size = dtypes[dtype].size;
    for (uint32_t i = 0; i < rank; i++)
        if (shape[i] == 0)
            size = 0;
    for (uint32_t i = 0; size && i < rank; i++) {
        if (shape[i] > LF_TENSOR_LIMIT / size)
            return false;
        size *= shape[i];
    }
    *out = size;
    return true;
}

void *lf_tensors_add(struct lf_tensors *t, const char *name, enum lf_dtype dtype, uint32_t rank,
                     const uint64_t *shape)
{
    struct lf_tensor tensor = {.dtype = dtype, .rank = rank};
    snprintf(tensor.name, sizeof tensor.name, "%s", name);
    for (uint32_t i = 0; i < rank; i++)
        tensor.shape[i] = shape[i];
    if (!size_of(dtype, rank, shape, &tensor.size) || tensor.size > LF_TENSOR_LIMIT - t->bytes) {
        ng_log_error("a file of tensors over %d GiB (at %s); make shards or crops smaller",
                     (int)(LF_TENSOR_LIMIT >> 30), name);
        return NULL;
    }
    if (tensor.size <= ng_system_available_memory())
        tensor.data = calloc(tensor.size ? tensor.size : 1, 1);
    if (!tensor.data || !ng_array_push(&t->list, tensor)) {
        ng_log_error("out of memory for %s (%" PRIu64 " bytes); make shards or crops smaller", name,
                     tensor.size);
        free(tensor.data);
        return NULL;
    }
    t->bytes += tensor.size;
    return tensor.data;
}

ng_result lf_tensors_note(struct lf_tensors *t, const char *key, const char *value)
{
    size_t size = strlen(value) + 1;
    struct lf_tensor_note note = {.value = malloc(size)};
    snprintf(note.key, sizeof note.key, "%s", key);
    if (note.value && ng_array_push(&t->notes, note)) {
        memcpy(note.value, value, size);
        return NG_OK;
    }
    free(note.value);
    return ng_out_of_memory("the notes of a file of tensors");
}

const struct lf_tensor *lf_tensors_find(const struct lf_tensors *t, const char *name)
{
    for (size_t i = 0; i < t->list.count; i++)
        if (strcmp(t->list.items[i].name, name) == 0)
            return &t->list.items[i];
    return NULL;
}

const char *lf_tensors_noted(const struct lf_tensors *t, const char *key)
{
    for (size_t i = 0; i < t->notes.count; i++)
        if (strcmp(t->notes.items[i].key, key) == 0)
            return t->notes.items[i].value;
    return NULL;
}

void lf_tensors_finish(struct lf_tensors *t)
{
    for (size_t i = 0; !t->file && i < t->list.count; i++)
        free(t->list.items[i].data);
    for (size_t i = 0; i < t->notes.count; i++)
        free(t->notes.items[i].value);
    free(t->file);
    ng_array_finish(&t->list);
    ng_array_finish(&t->notes);
    *t = (struct lf_tensors){0};
}

static uint64_t hash_file(unsigned char *file, size_t size)
{
    unsigned char digits[HASH_DIGITS];
    memcpy(digits, file + HASH_AT, HASH_DIGITS);
    memset(file + HASH_AT, '0', HASH_DIGITS);
    uint64_t hash = ng_hash_bytes(0, file, size);
    memcpy(file + HASH_AT, digits, HASH_DIGITS);
    return hash;
}

// ---- writing ---------------------------------------------------------------------------------------------

static void put_tensor(struct lf_text *t, const struct lf_tensor *tensor, uint64_t offset)
{
    char number[96];
    lf_text_put(t, ",");
    lf_text_quote(t, tensor->name);
    lf_text_put(t, ":{\"dtype\":");
    lf_text_quote(t, dtypes[tensor->dtype].name);
    lf_text_put(t, ",\"shape\":[");
    for (uint32_t i = 0; i < tensor->rank; i++) {
        snprintf(number, sizeof number, "%s%" PRIu64, i ? "," : "", tensor->shape[i]);
        lf_text_put(t, number);
    }
    snprintf(number, sizeof number, "],\"data_offsets\":[%" PRIu64 ",%" PRIu64 "]}", offset,
             offset + tensor->size);
    lf_text_put(t, number);
}

static void put_header(struct lf_text *text, const struct lf_tensors *t)
{
    uint64_t offset = 0;
    lf_text_put(text, HEAD "0000000000000000\"");
    for (size_t i = 0; i < t->notes.count; i++) {
        lf_text_put(text, ",");
        lf_text_quote(text, t->notes.items[i].key);
        lf_text_put(text, ":");
        lf_text_quote(text, t->notes.items[i].value);
    }
    lf_text_put(text, "}");
    for (size_t i = 0; i < t->list.count; i++) {
        put_tensor(text, &t->list.items[i], offset);
        offset += t->list.items[i].size;
    }
    lf_text_put(text, "}");
    while (!text->failed && text->bytes.count % 8)
        lf_text_put(text, " ");
}

// Wide elements first, otherwise in the order in which they were added.
static ng_result sort_by_width(struct lf_tensors *t)
{
    NG_ARRAY(struct lf_tensor) sorted = {0};
    if (!ng_array_reserve(&sorted, t->list.count + 1))
        return ng_out_of_memory("the list of tensors");
    for (uint32_t width = 4; width; width /= 2)
        for (size_t i = 0; i < t->list.count; i++)
            if (dtypes[t->list.items[i].dtype].size == width)
                sorted.items[sorted.count++] = t->list.items[i];
    ng_array_finish(&t->list);
    t->list.items = sorted.items;
    t->list.count = sorted.count;
    t->list.capacity = sorted.capacity;
    return NG_OK;
}

static ng_result assemble(const struct lf_tensors *t, const char *path, unsigned char **out, size_t *size)
{
    struct lf_text header = {0};
    put_header(&header, t);
    *size = 8 + header.bytes.count + (size_t)t->bytes;
    unsigned char *file = header.failed ? NULL : malloc(*size);
    if (file) {
        unsigned char *at = file;
        for (int i = 0; i < 8; i++)
            *at++ = (unsigned char)((uint64_t)header.bytes.count >> (8 * i));
        memcpy(at, header.bytes.items, header.bytes.count);
        at += header.bytes.count;
        for (size_t i = 0; i < t->list.count; i++) {
            memcpy(at, t->list.items[i].data, t->list.items[i].size);
            at += t->list.items[i].size;
        }
    } else {
        ng_log_error("%s: out of memory for %zu bytes; make shards smaller", path, *size);
    }
    ng_array_finish(&header.bytes);
    *out = file;
    return file ? NG_OK : NG_ERROR_MEMORY;
}

ng_result lf_tensors_write(struct lf_tensors *t, const char *path)
{
    unsigned char *file;
    char digits[HASH_DIGITS + 1];
    size_t size;
    NG_TRY(sort_by_width(t));
    NG_TRY(assemble(t, path, &file, &size));
    t->hash = hash_file(file, size);
    snprintf(digits, sizeof digits, "%016" PRIx64, t->hash);
    memcpy(file + HASH_AT, digits, HASH_DIGITS);
    ng_result result = ng_file_write(path, file, size);
    free(file);
    return result;
}

// ---- reading ---------------------------------------------------------------------------------------------

// A value is no longer than what is left of the header, into which it is read.
static bool read_notes(struct lf_json *j, struct lf_tensors *t)
{
    size_t size = (size_t)(j->end - j->at) + 1;
    char key[sizeof t->notes.items->key], *value = malloc(size);
    bool ok = value;
    lf_json_open(j, '{');
    while (ok && lf_json_more(j, '}'))
        ok = lf_json_key(j, key, sizeof key) && lf_json_string(j, value, size) &&
             (strcmp(key, "hash") == 0 || lf_tensors_note(t, key, value) == NG_OK);
    free(value);
    return ok && !j->failed;
}

static bool read_dtype(struct lf_json *j, enum lf_dtype *out)
{
    char name[8];
    if (!lf_json_string(j, name, sizeof name))
        return false;
    for (size_t i = 0; i < NG_COUNT(dtypes); i++)
        if (strcmp(name, dtypes[i].name) == 0) {
            *out = (enum lf_dtype)i;
            return true;
        }
    return false;
}

static bool read_numbers(struct lf_json *j, uint64_t *out, uint32_t limit, uint32_t *count)
{
    *count = 0;
    lf_json_open(j, '[');
    while (lf_json_more(j, ']'))
        if (*count == limit || !lf_json_number(j, &out[(*count)++]))
            return false;
    return !j->failed;
}

// Tensors follow one another in the data, each as large as its shape says.
static bool read_tensor(struct lf_json *j, struct lf_tensors *t, unsigned char *data, uint64_t data_size,
                        struct lf_tensor *out)
{
    uint64_t offsets[2] = {0}, size;
    uint32_t offset_count = 0, seen = 0;
    lf_json_open(j, '{');
    while (lf_json_more(j, '}')) {
        char key[16];
        bool ok = lf_json_key(j, key, sizeof key);
        if (ok && strcmp(key, "dtype") == 0)
            ok = read_dtype(j, &out->dtype), seen |= 1;
        else if (ok && strcmp(key, "shape") == 0)
            ok = read_numbers(j, out->shape, LF_TENSOR_RANK, &out->rank), seen |= 2;
        else if (ok && strcmp(key, "data_offsets") == 0)
            ok = read_numbers(j, offsets, 2, &offset_count), seen |= 4;
        else
            ok = false;
        if (!ok)
            return false;
    }
    if (j->failed || seen != 7 || offset_count != 2 || !size_of(out->dtype, out->rank, out->shape, &size) ||
        offsets[0] != t->bytes || offsets[1] < offsets[0] || offsets[1] - offsets[0] != size ||
        offsets[1] > data_size)
        return false;
    out->size = size;
    out->data = data + offsets[0];
    t->bytes = offsets[1];
    return true;
}

static int by_name(const void *a, const void *b)
{
    return strcmp((*(const struct lf_tensor *const *)a)->name, (*(const struct lf_tensor *const *)b)->name);
}

static bool names_differ(const struct lf_tensors *t)
{
    size_t count = t->list.count;
    const struct lf_tensor **sorted = malloc((count + 1) * sizeof(const struct lf_tensor *));
    bool differ = sorted;
    for (size_t i = 0; differ && i < count; i++)
        sorted[i] = &t->list.items[i];
    if (differ)
        qsort(sorted, count, sizeof *sorted, by_name);
    for (size_t i = 1; differ && i < count; i++)
        differ = by_name(&sorted[i - 1], &sorted[i]) != 0;
    free(sorted);
    return differ;
}

static bool read_header(struct lf_tensors *t, unsigned char *file, size_t size, uint64_t header)
{
    struct lf_json j = lf_json_begin(file + 8, header);
    lf_json_open(&j, '{');
    while (lf_json_more(&j, '}')) {
        struct lf_tensor tensor = {0};
        if (!lf_json_key(&j, tensor.name, sizeof tensor.name))
            return false;
        if (strcmp(tensor.name, "__metadata__") == 0) {
            if (!read_notes(&j, t))
                return false;
        } else if (!read_tensor(&j, t, file + 8 + header, size - 8 - header, &tensor) ||
                   !ng_array_push(&t->list, tensor)) {
            return false;
        }
    }
    return lf_json_end(&j) && t->bytes == size - 8 - header && names_differ(t);
}

// Null, or what is wrong.
static const char *parse(struct lf_tensors *t, unsigned char *file, size_t size)
{
    uint64_t header = 0;
    char digits[HASH_DIGITS + 1];
    for (size_t i = 0; size >= 8 && i < 8; i++)
        header |= (uint64_t)file[i] << (8 * i);
    if (size < HASH_AT + HASH_DIGITS || header > size - 8 || header < HASH_AT + HASH_DIGITS - 8)
        return "is cut off or not a file of tensors";
    if (memcmp(file + 8, HEAD, sizeof HEAD - 1) != 0)
        return "is not a file of tensors with a checksum as lightformer writes it";
    t->hash = hash_file(file, size);
    snprintf(digits, sizeof digits, "%016" PRIx64, t->hash);
    if (memcmp(file + HASH_AT, digits, HASH_DIGITS) != 0)
        return "is damaged: its checksum is wrong";
    return read_header(t, file, size, header) ? NULL : "has a header that breaks the format";
}

ng_result lf_tensors_try(const char *path, struct lf_tensors *out, const char **wrong)
{
    size_t size;
    *out = (struct lf_tensors){0};
    *wrong = NULL;
    NG_TRY(ng_file_read(path, 0, &out->file, &size));
    *wrong = parse(out, out->file, size);
    if (!*wrong)
        return NG_OK;
    lf_tensors_finish(out);
    return NG_ERROR_FORMAT;
}

ng_result lf_tensors_read(const char *path, struct lf_tensors *out)
{
    const char *wrong;
    ng_result result = lf_tensors_try(path, out, &wrong);
    if (wrong)
        ng_log_error("%s: %s", path, wrong);
    return result;
}

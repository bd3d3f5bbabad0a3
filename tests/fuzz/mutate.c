#include "mutate.h"

#include "base/file.h"

void bytes_splice(struct bytes *b, size_t at, size_t removed, const void *put, size_t size)
{
    size_t rest = b->data.count - at - removed;
    unsigned char *copy = malloc(size + 1); // `put` may be of the same bytes
    assert_non_null(copy);
    memcpy(copy, put, size);
    assert_true(ng_array_reserve(&b->data, at + size + rest + 1));
    memmove(b->data.items + at + size, b->data.items + at + removed, rest);
    memcpy(b->data.items + at, copy, size);
    b->data.count = at + size + rest;
    free(copy);
}

struct bytes bytes_read(const char *path)
{
    struct bytes b = {0};
    void *data;
    size_t size;
    assert_int_equal(ng_file_read(path, 0, &data, &size), NG_OK);
    bytes_splice(&b, 0, 0, data, size);
    free(data);
    return b;
}

// ---- bytes -----------------------------------------------------------------------------------------------

static void put_length(struct bytes *b, size_t at, struct ng_rng *r)
{
    static const uint32_t lengths[] = {0, 1, 255, 65535, 65536, INT32_MAX, 0x80000000u, UINT32_MAX};
    uint32_t value = fuzz_one_in(r, 3) ? ng_rng_below(r, 4096) : lengths[ng_rng_below(r, NG_COUNT(lengths))];
    for (size_t i = 0; i < 4 && at + i < b->data.count; i++)
        b->data.items[at + i] = (unsigned char)(value >> (8 * i));
}

void mutate_bytes(struct bytes *b, struct ng_rng *r)
{
    static const char usual[] = "0123456789-.+e\",:{}[]AZ/=\\ ";
    if (b->data.count == 0)
        return;
    size_t at = ng_rng_below(r, (uint32_t)b->data.count), left = b->data.count - at;
    if (fuzz_one_in(r, 4) && b->data.count > 64) // headers are where it hurts
        at = ng_rng_below(r, 64), left = b->data.count - at;
    size_t length = 1 + ng_rng_below(r, (uint32_t)(left < 64 ? left : 64));
    length = length < left ? length : left;
    switch (ng_rng_below(r, 8)) {
    case 0:
        b->data.items[at] ^= (unsigned char)(1u << ng_rng_below(r, 8));
        break;
    case 1:
        b->data.items[at] = (unsigned char)usual[ng_rng_below(r, sizeof usual - 1)];
        break;
    case 2:
        put_length(b, at, r);
        break;
    case 3:
        memset(b->data.items + at, fuzz_one_in(r, 2) ? 0 : 0xff, length);
        break;
    case 4:
        bytes_splice(b, at, length, "", 0);
        break;
    case 5:
        bytes_splice(b, at, 0, b->data.items + at, length);
        break;
    case 6:
        b->data.count = fuzz_one_in(r, 8) ? at : b->data.count;
        break;
    default:
        b->data.items[at] = (unsigned char)ng_rng_u32(r);
    }
}

// ---- JSON ------------------------------------------------------------------------------------------------

// A value in the text; as a member it begins with its key.
struct span {
    size_t item, begin, end;
};

struct scan {
    const char *text;
    size_t at, end;
    NG_ARRAY(struct span) spans;
};

static char peek(struct scan *s)
{
    while (s->at < s->end && strchr(" \t\r\n", s->text[s->at]) && s->text[s->at])
        s->at++;
    return s->at < s->end ? s->text[s->at] : 0;
}

static void skip_string(struct scan *s)
{
    for (s->at++; s->at < s->end && s->text[s->at] != '"'; s->at++)
        s->at += s->text[s->at] == '\\';
    s->at = s->at < s->end ? s->at + 1 : s->end;
}

// Lists the values of what is hopefully JSON; always moves on.
static void scan_value(struct scan *s, size_t item, int depth)
{
    char c = peek(s), close = c == '{' ? '}' : ']';
    struct span span = {item == SIZE_MAX ? s->at : item, s->at, 0};
    if (c == '"') {
        skip_string(s);
    } else if ((c == '{' || c == '[') && depth < 200) {
        s->at++;
        while (peek(s) && peek(s) != close) {
            size_t first = s->at;
            if (c == '{' && peek(s) == '"') {
                skip_string(s);
                s->at += peek(s) == ':';
            }
            scan_value(s, first, depth + 1);
            s->at += peek(s) == ',';
            s->at += s->at == first;
        }
        s->at += s->at < s->end;
    } else {
        while (s->at < s->end && !strchr(",]}: \t\r\n", s->text[s->at]))
            s->at++;
    }
    span.end = s->at;
    assert_true(ng_array_push(&s->spans, span));
}

static const char *const values[] = {"0",
                                     "1",
                                     "-1",
                                     "2",
                                     "3",
                                     "255",
                                     "65536",
                                     "100000",
                                     "2147483647",
                                     "4294967295",
                                     "4294967296",
                                     "1e19",
                                     "1e39",
                                     "-1e30",
                                     "1e308",
                                     "1e-40",
                                     "0.5",
                                     "3.0",
                                     "null",
                                     "true",
                                     "false",
                                     "\"\"",
                                     "[]",
                                     "{}",
                                     "[[[0]]]",
                                     "{\"a\":{}}",
                                     "\"\\u0000\"",
                                     "\"\\u001b[31m\"",
                                     "\"\xff\"",
                                     "\"../../x\"",
                                     "\"data:image/png;base64,AAAA\"",
                                     "[1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16]"};

// A number that is off by one, twice as large, or negative.
static size_t shift_number(const char *text, size_t size, struct ng_rng *r, char out[32])
{
    char copy[32] = {0};
    memcpy(copy, text, size < sizeof copy - 1 ? size : sizeof copy - 1);
    double n = strtod(copy, NULL);
    const double shifted[] = {n + 1, n - 1, n * 2, -n, n * 1e6};
    return (size_t)snprintf(out, 32, "%.9g", shifted[ng_rng_below(r, NG_COUNT(shifted))]);
}

static void nest(struct bytes *b, const struct span *v, struct ng_rng *r)
{
    size_t depth = 1 + ng_rng_below(r, fuzz_one_in(r, 8) ? 100 : 3);
    bool object = fuzz_one_in(r, 3);
    for (size_t i = 0; i < depth; i++)
        bytes_splice(b, v->end, 0, object ? "}" : "]", 1);
    for (size_t i = 0; i < depth; i++)
        bytes_splice(b, v->begin, 0, object ? "{\"a\":" : "[", object ? 5 : 1);
}

// The item again, some times or many.
static void repeat(struct bytes *b, const struct span *v, struct ng_rng *r)
{
    size_t size = v->end - v->item, count = 1 + ng_rng_below(r, fuzz_one_in(r, 6) ? 300 : 4);
    unsigned char *item = malloc(size + 1);
    assert_non_null(item);
    memcpy(item, b->data.items + v->item, size);
    item[size] = ',';
    for (size_t i = 0; i < count && b->data.count < 1u << 18; i++)
        bytes_splice(b, v->item, 0, item, size + 1);
    free(item);
}

static void change_value(struct bytes *b, const struct span *v, const struct span *other, struct ng_rng *r)
{
    const unsigned char *text = b->data.items;
    char number[32];
    const char *value = values[ng_rng_below(r, NG_COUNT(values))];
    bool is_number = strchr("-0123456789", text[v->begin]) && v->end > v->begin;
    switch (ng_rng_below(r, 8)) {
    case 0: { // with the comma behind it, or before it
        bool comma = v->end < b->data.count && text[v->end] == ',',
             before = v->item && text[v->item - 1] == ',';
        bytes_splice(b, v->item - (!comma && before), v->end - v->item + (comma || before), "", 0);
        break;
    }
    case 1:
        repeat(b, v, r);
        break;
    case 2:
        bytes_splice(b, v->begin, v->end - v->begin, text + other->begin, other->end - other->begin);
        break;
    case 3:
        nest(b, v, r);
        break;
    case 4: // another's key
        bytes_splice(b, v->item, v->begin - v->item, text + other->item, other->begin - other->item);
        break;
    case 5:
        bytes_splice(b, v->begin, v->end - v->begin, value, strlen(value));
        break;
    default:
        if (is_number)
            bytes_splice(b, v->begin, v->end - v->begin, number,
                         shift_number((const char *)text + v->begin, v->end - v->begin, r, number));
        else
            bytes_splice(b, v->begin, v->end - v->begin, value, strlen(value));
    }
}

void mutate_json(struct bytes *b, size_t begin, size_t *end, struct ng_rng *r)
{
    struct scan s = {.text = (const char *)b->data.items, .at = begin, .end = *end};
    size_t before = b->data.count;
    scan_value(&s, SIZE_MAX, 0);
    if (s.spans.count < 2 || fuzz_one_in(r, 20)) {
        mutate_bytes(b, r);
    } else {
        // The last span is the whole.
        struct span v = s.spans.items[ng_rng_below(r, (uint32_t)s.spans.count - 1)];
        change_value(b, &v, &s.spans.items[ng_rng_below(r, (uint32_t)s.spans.count - 1)], r);
    }
    *end = *end + b->data.count - before;
    *end = *end < b->data.count ? *end : b->data.count;
    ng_array_finish(&s.spans);
}

void mutate_text(struct bytes *b, struct ng_rng *r)
{
    size_t end = b->data.count;
    if (fuzz_one_in(r, 6))
        mutate_bytes(b, r);
    else
        mutate_json(b, 0, &end, r);
}

static uint32_t word_at(const struct bytes *b, size_t at)
{
    uint32_t value = 0;
    for (size_t i = 0; i < 4 && at + i < b->data.count; i++)
        value |= (uint32_t)b->data.items[at + i] << (8 * i);
    return value;
}

static void put_word(struct bytes *b, size_t at, size_t value)
{
    for (size_t i = 0; i < 4 && at + i < b->data.count; i++)
        b->data.items[at + i] = (unsigned char)(value >> (8 * i));
}

void mutate_glb(struct bytes *b, struct ng_rng *r)
{
    size_t end = 20 + (size_t)word_at(b, 12);
    if (end > b->data.count || fuzz_one_in(r, 3)) {
        mutate_bytes(b, r);
        return;
    }
    mutate_json(b, 20, &end, r);
    while (end < b->data.count && end % 4 != 0)
        bytes_splice(b, end++, 0, " ", 1);
    put_word(b, 12, end - 20);
    put_word(b, 8, b->data.count);
}

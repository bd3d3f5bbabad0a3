// Java's .properties: one key and value a line, which a backslash at its end continues.
#include "asset/catalogue_internal.h"
#include "base/array.h"

#include <string.h>

struct reader {
    const unsigned char *at, *end;
};

struct text {
    char *items;
    size_t count, capacity;
};

static bool is_blank(int c)
{
    return c == ' ' || c == '\t' || c == '\f';
}

static int peek(const struct reader *r)
{
    return r->at == r->end ? -1 : *r->at;
}

static void skip_blanks(struct reader *r)
{
    while (is_blank(peek(r)))
        r->at++;
}

static bool is_line_end(int c)
{
    return c < 0 || c == '\n' || c == '\r';
}

// Past the end of a line and the blanks that begin the next.
static void skip_line_end(struct reader *r)
{
    if (peek(r) == '\r')
        r->at++;
    if (peek(r) == '\n')
        r->at++;
    skip_blanks(r);
}

static int hex_digit(int c)
{
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    const char *found = c > 0 ? strchr(digits, c) : NULL;
    return found ? (int)(found - digits) % 16 : -1;
}

// A UTF-16 unit after "\u"; what is none is a question mark.
static unsigned read_unit(struct reader *r)
{
    unsigned value = 0;
    for (int i = 0; i < 4; i++, r->at++) {
        int digit = hex_digit(peek(r));
        if (digit < 0)
            return '?';
        value = value * 16 + (unsigned)digit;
    }
    return value;
}

static bool put(struct text *t, unsigned code)
{
    if (code < 0x80)
        return ng_array_push(t, (char)code);
    if (code < 0x800)
        return ng_array_push(t, (char)(0xc0 | code >> 6)) && ng_array_push(t, (char)(0x80 | (code & 0x3f)));
    return (code < 0x10000 ? ng_array_push(t, (char)(0xe0 | code >> 12))
                           : ng_array_push(t, (char)(0xf0 | code >> 18)) &&
                                 ng_array_push(t, (char)(0x80 | (code >> 12 & 0x3f)))) &&
           ng_array_push(t, (char)(0x80 | (code >> 6 & 0x3f))) &&
           ng_array_push(t, (char)(0x80 | (code & 0x3f)));
}

static unsigned read_escape(struct reader *r)
{
    int c = peek(r);
    r->at++;
    switch (c) {
    case 't':
        return '\t';
    case 'n':
    case 'r':
    case 'f':
        return ' ';
    case 'u':
        break;
    default:
        return (unsigned)c;
    }
    unsigned high = read_unit(r);
    if (high < 0xd800 || high > 0xdfff)
        return high ? high : '?';
    if (high > 0xdbff || r->end - r->at < 6 || r->at[0] != '\\' || r->at[1] != 'u')
        return '?';
    r->at += 2;
    unsigned low = read_unit(r);
    return low >= 0xdc00 && low <= 0xdfff ? 0x10000 + ((high - 0xd800) << 10) + (low - 0xdc00) : '?';
}

// Up to the end of the line; a key also up to what parts it from its value.
static bool read_text(struct reader *r, bool is_key, struct text *out)
{
    out->count = 0;
    for (int c = peek(r); !is_line_end(c); c = peek(r)) {
        if (is_key && (c == '=' || c == ':' || is_blank(c)))
            break;
        r->at++;
        if (c == '\\' && is_line_end(peek(r))) {
            skip_line_end(r);
            continue;
        }
        if (!put(out, c == '\\' ? read_escape(r) : c ? (unsigned)c : '?'))
            return false;
    }
    return put(out, 0);
}

static bool read_line(struct reader *r, struct text *key, struct text *value)
{
    if (!read_text(r, true, key))
        return false;
    skip_blanks(r);
    if (peek(r) == '=' || peek(r) == ':') {
        r->at++;
        skip_blanks(r);
    }
    return read_text(r, false, value);
}

bool ng_properties_read(const char *text, size_t size,
                        bool (*each)(void *user, const char *key, const char *value), void *user)
{
    struct reader r = {(const unsigned char *)text, (const unsigned char *)text + size};
    struct text key = {0}, value = {0};
    bool going = true;
    while (going && r.at != r.end) {
        skip_blanks(&r);
        if (is_line_end(peek(&r))) {
            r.at += r.at != r.end;
        } else if (peek(&r) == '#' || peek(&r) == '!') {
            while (!is_line_end(peek(&r)))
                r.at++;
        } else {
            going = read_line(&r, &key, &value) && each(user, key.items, value.items);
        }
    }
    ng_array_finish(&key);
    ng_array_finish(&value);
    return going;
}

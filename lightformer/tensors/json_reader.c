// A scanner that moves one pointer; who calls knows what comes next.
#include "lightformer/tensors/json_reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct lf_json lf_json_begin(const void *text, size_t size)
{
    return (struct lf_json){.at = text, .end = (const char *)text + size};
}

static bool fail(struct lf_json *j)
{
    j->failed = true;
    return false;
}

// The next character that is not white space; 0 at the end.
static char peek(struct lf_json *j)
{
    while (j->at < j->end && *j->at && strchr(" \t\r\n", *j->at))
        j->at++;
    return j->at < j->end && !j->failed ? *j->at : 0;
}

static bool take(struct lf_json *j, char c)
{
    if (peek(j) != c || !c)
        return fail(j);
    j->at++;
    return true;
}

bool lf_json_open(struct lf_json *j, char bracket)
{
    j->first = true;
    return take(j, bracket);
}

bool lf_json_more(struct lf_json *j, char bracket)
{
    bool first = j->first;
    j->first = false;
    if (peek(j) == bracket) {
        j->at++;
        return false;
    }
    if (!first)
        return take(j, ',');
    return peek(j) || fail(j);
}

bool lf_json_string(struct lf_json *j, char *out, size_t size)
{
    static const char escapes[] = "\"\"\\\\//b\bf\fn\nr\rt\t";
    size_t n = 0;
    if (!take(j, '"'))
        return false;
    while (j->at < j->end && *j->at != '"') {
        char c = *j->at++;
        if ((unsigned char)c < 0x20)
            return fail(j);
        if (c == '\\') {
            const char *e = escapes;
            while (*e && j->at < j->end && *e != *j->at)
                e += 2;
            if (!*e || j->at == j->end)
                return fail(j);
            c = e[1];
            j->at++;
        }
        if (n + 1 >= size)
            return fail(j);
        out[n++] = c;
    }
    out[n] = 0;
    return take(j, '"');
}

bool lf_json_key(struct lf_json *j, char *out, size_t size)
{
    return lf_json_string(j, out, size) && take(j, ':');
}

bool lf_json_number(struct lf_json *j, uint64_t *out)
{
    char c = peek(j);
    uint64_t n = 0;
    if (c < '0' || c > '9')
        return fail(j);
    do {
        n = n * 10 + (uint64_t)(*j->at++ - '0');
        if (n > (uint64_t)1 << 53)
            return fail(j);
    } while (j->at < j->end && *j->at >= '0' && *j->at <= '9');
    *out = n;
    return true;
}

static size_t digits(const char *s)
{
    return strspn(s, "0123456789");
}

// What strtod takes but JSON does not (a sign +, a point without digits, hexadecimal, "inf") is told by
// measuring the number first.
bool lf_json_real(struct lf_json *j, double *out)
{
    char text[40] = {0};
    peek(j);
    size_t left = (size_t)(j->end - j->at), length = 0;
    memcpy(text, j->at, left < sizeof text - 1 ? left : sizeof text - 1);
    length += text[0] == '-';
    size_t whole = digits(text + length);
    length += whole;
    if (text[length] == '.') {
        size_t fraction = digits(text + length + 1);
        whole = fraction ? whole : 0;
        length += 1 + fraction;
    }
    if (text[length] == 'e' || text[length] == 'E') {
        size_t sign = text[length + 1] == '-' || text[length + 1] == '+';
        size_t exponent = digits(text + length + 1 + sign);
        whole = exponent ? whole : 0;
        length += 1 + sign + exponent;
    }
    if (j->failed || !whole || length == sizeof text - 1)
        return fail(j);
    text[length] = 0;
    *out = strtod(text, NULL);
    j->at += length;
    return isfinite((float)*out) || fail(j);
}

static bool skip(struct lf_json *j, int depth)
{
    char text[256], c = peek(j);
    uint64_t number;
    if (depth == LF_JSON_MAX_DEPTH)
        return fail(j);
    if (c == '"')
        return lf_json_string(j, text, sizeof text);
    if (c != '{' && c != '[')
        return lf_json_number(j, &number);
    char close = c == '{' ? '}' : ']';
    lf_json_open(j, c);
    while (lf_json_more(j, close)) {
        if (c == '{')
            lf_json_key(j, text, sizeof text);
        skip(j, depth + 1);
    }
    return !j->failed;
}

bool lf_json_skip(struct lf_json *j)
{
    return skip(j, 0);
}

bool lf_json_end(struct lf_json *j)
{
    return peek(j) == 0 && j->at == j->end && !j->failed;
}

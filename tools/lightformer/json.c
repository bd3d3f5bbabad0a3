#include "json.h"

#include "base/printable.h"

#include <assert.h>
#include <math.h>

static void print_string(FILE *out, const char *text)
{
    fputc('"', out);
    for (const char *p = text, *begin = p; *p; begin = p) {
        uint32_t c = ng_next_character(&p);
        if (c == '"' || c == '\\')
            fprintf(out, "\\%c", (int)c);
        else if (ng_character_shows(c))
            fwrite(begin, 1, (size_t)(p - begin), out);
        else // U+FFFD stands for what is no character
            fprintf(out, "\\u%04x", c == NG_NO_CHARACTER ? 0xfffdu : c);
    }
    fputc('"', out);
}

// What stands before a value: comma, line, indent, key.
static void begin_value(struct json *j, const char *key)
{
    if (j->depth > 0) {
        fputs(j->filled[j->depth] ? ",\n" : "\n", j->out);
        fprintf(j->out, "%*s", 2 * j->depth, "");
    }
    j->filled[j->depth] = true;
    if (key) {
        print_string(j->out, key);
        fputs(": ", j->out);
    }
}

static void open_value(struct json *j, const char *key, char open, char close)
{
    begin_value(j, key);
    fputc(open, j->out);
    j->depth++;
    assert(j->depth < JSON_MAX_DEPTH);
    j->filled[j->depth] = false;
    j->close[j->depth] = close;
}

void json_object(struct json *j, const char *key)
{
    open_value(j, key, '{', '}');
}

void json_array(struct json *j, const char *key)
{
    open_value(j, key, '[', ']');
}

void json_end(struct json *j)
{
    assert(j->depth > 0);
    bool filled = j->filled[j->depth];
    char close = j->close[j->depth--];
    if (filled)
        fprintf(j->out, "\n%*s", 2 * j->depth, "");
    fputc(close, j->out);
    if (j->depth == 0)
        fputc('\n', j->out);
}

void json_text(struct json *j, const char *key, const char *value)
{
    begin_value(j, key);
    if (value)
        print_string(j->out, value);
    else
        fputs("null", j->out);
}

void json_number(struct json *j, const char *key, double value)
{
    begin_value(j, key);
    if (isfinite(value))
        fprintf(j->out, "%.9g", value);
    else
        fputs("null", j->out);
}

void json_bool(struct json *j, const char *key, bool value)
{
    begin_value(j, key);
    fputs(value ? "true" : "false", j->out);
}

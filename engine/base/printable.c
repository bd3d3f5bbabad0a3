#include "base/printable.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

uint32_t ng_next_character(const char **text)
{
    static const uint32_t least[] = {0, 0x80, 0x800, 0x10000}; // that takes so many bytes more
    const unsigned char *at = (const unsigned char *)(*text)++;
    if (*at < 0x80)
        return *at;
    uint32_t more = *at >= 0xf0 ? 3 : *at >= 0xe0 ? 2 : 1;
    uint32_t character = *at & (0x3fu >> more);
    if (*at < 0xc0 || *at >= 0xf8)
        return NG_NO_CHARACTER;
    for (uint32_t i = 1; i <= more; i++) {
        if ((at[i] & 0xc0) != 0x80)
            return NG_NO_CHARACTER;
        character = character << 6 | (at[i] & 0x3fu);
    }
    bool surrogate = character >= 0xd800 && character < 0xe000;
    if (character < least[more] || character > 0x10ffff || surrogate)
        return NG_NO_CHARACTER;
    *text += more;
    return character;
}

bool ng_character_shows(uint32_t c)
{
    bool control = c < 0x20 || (c >= 0x7f && c < 0xa0);
    bool separator = c == 0x2028 || c == 0x2029;
    bool direction = c == 0x61c || c == 0x200e || c == 0x200f || (c >= 0x202a && c <= 0x202e) ||
                     (c >= 0x2066 && c <= 0x2069);
    return !control && !separator && !direction && c != NG_NO_CHARACTER;
}

void ng_make_printable(char *text)
{
    char *to = text;
    for (const char *at = text, *begin; *at;) {
        begin = at;
        bool shows = ng_character_shows(ng_next_character(&at));
        size_t size = shows ? (size_t)(at - begin) : 1;
        memmove(to, shows ? begin : "?", size);
        to += size;
    }
    *to = 0;
}

void ng_print_line(FILE *out, const char *fmt, ...)
{
    va_list args, again;
    va_start(args, fmt);
    va_copy(again, args);
    int length = vsnprintf(NULL, 0, fmt, args);
    char *line = length < 0 ? NULL : malloc((size_t)length + 1);
    if (line) {
        vsnprintf(line, (size_t)length + 1, fmt, again);
        ng_make_printable(line);
        fprintf(out, "%s\n", line);
    }
    free(line);
    va_end(again);
    va_end(args);
}

// Text from files as it may reach a terminal or a title. Names may hold anything: control characters, of
// which a terminal makes commands, characters that turn the direction of writing, and what is no UTF-8.
#ifndef NG_BASE_PRINTABLE_H
#define NG_BASE_PRINTABLE_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

NG_EXTERN_C_BEGIN

#define NG_NO_CHARACTER UINT32_MAX

// The next character of a text in UTF-8, and moves past it; NG_NO_CHARACTER for a byte that begins none. Not
// at the end of a text.
uint32_t ng_next_character(const char **text);
// False for what must not be shown as it is: control characters (C0, DEL, C1), separators of lines, marks of
// the direction of writing, and NG_NO_CHARACTER.
bool ng_character_shows(uint32_t character);
// Puts '?' in the place of each such character; the text does not become longer.
void ng_make_printable(char *text);
// Prints one line, made printable, and its end. A line that finds no memory is left out.
void ng_print_line(FILE *out, const char *fmt, ...) NG_PRINTF(2, 3);

NG_EXTERN_C_END

#endif

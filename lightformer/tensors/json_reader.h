// Reads JSON from left to right, as the headers of shards and manifests need it: strict, bounded, without
// allocating. A mistake makes `failed` true; from then on all calls return false.
//
//     if (lf_json_open(&j, '{'))
//         while (lf_json_more(&j, '}'))
//             if (lf_json_key(&j, key, sizeof key)) ... read or lf_json_skip the value
#ifndef LF_TENSORS_JSON_READER_H
#define LF_TENSORS_JSON_READER_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

#define LF_JSON_MAX_DEPTH 16

struct lf_json {
    const char *at, *end; // borrowed text
    bool failed;
    bool first; // no member of the innermost object or array has been read yet
};

struct lf_json lf_json_begin(const void *text, size_t size);
// Enters an object or an array.
bool lf_json_open(struct lf_json *j, char bracket);
// True if there is another member; false at the closing bracket, which is passed.
bool lf_json_more(struct lf_json *j, char bracket);
// A member's name and its colon. Strings longer than size - 1 bytes, or with escapes that are not ASCII,
// fail.
bool lf_json_key(struct lf_json *j, char *out, size_t size);
bool lf_json_string(struct lf_json *j, char *out, size_t size);
// A whole number from 0 to 2^53.
bool lf_json_number(struct lf_json *j, uint64_t *out);
// Any number that is finite as a float.
bool lf_json_real(struct lf_json *j, double *out);
// Passes over any value whose numbers are whole.
bool lf_json_skip(struct lf_json *j);
// True if nothing but white space is left and nothing failed.
bool lf_json_end(struct lf_json *j);

NG_EXTERN_C_END

#endif

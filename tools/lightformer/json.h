// Writes JSON as it goes, indented for people. Numbers keep nine digits; what is not finite becomes null.
//
//     struct json j = {.out = stdout};
//     json_object(&j, NULL);
//     json_text(&j, "name", "chess");
//     json_array(&j, "sizes"); json_number(&j, NULL, 1); json_end(&j);
//     json_end(&j);
//
// The key is null inside arrays and for the outermost value.
#ifndef LIGHTFORMER_JSON_H
#define LIGHTFORMER_JSON_H

#include <stdbool.h>
#include <stdio.h>

#define JSON_MAX_DEPTH 16

struct json {
    FILE *out;
    int depth;
    bool filled[JSON_MAX_DEPTH]; // the value at this depth has a member already
    char close[JSON_MAX_DEPTH];
};

void json_object(struct json *j, const char *key);
void json_array(struct json *j, const char *key);
// Ends the innermost object or array; after the outermost one also the line.
void json_end(struct json *j);
void json_text(struct json *j, const char *key, const char *value); // null pointer: null
void json_number(struct json *j, const char *key, double value);
void json_bool(struct json *j, const char *key, bool value);

#endif

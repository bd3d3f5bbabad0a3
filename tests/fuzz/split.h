// A glTF file taken apart: base64 hides bytes from whoever damages files at random.
#ifndef NG_TESTS_SPLIT_H
#define NG_TESTS_SPLIT_H

#include "mutate.h"

struct split {
    struct bytes json;   // without data: URIs
    struct bytes buffer; // the first one; empty if there is none
    NG_ARRAY(struct bytes) pictures;
};

void split_read(const char *path, struct split *out);
void split_finish(struct split *split);
// The JSON and its buffer as GLB. Pictures are lost.
void split_write_glb(const struct split *split, const char *path);

#endif

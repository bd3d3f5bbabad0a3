// Damages files: as bytes, and as JSON, whose values, members and items are moved about.
#ifndef NG_TESTS_MUTATE_H
#define NG_TESTS_MUTATE_H

#include "fuzz.h"

#include "base/array.h"

struct bytes {
    NG_ARRAY(unsigned char) data;
};

struct bytes bytes_read(const char *path);
// Replaces `removed` bytes at a place.
void bytes_splice(struct bytes *b, size_t at, size_t removed, const void *put, size_t size);
// Bits, bytes, lengths, cuts, blocks twice or not at all.
void mutate_bytes(struct bytes *b, struct ng_rng *r);
// A value of the JSON text in [begin, *end), which moves the end. Text that is no JSON is damaged as bytes.
void mutate_json(struct bytes *b, size_t begin, size_t *end, struct ng_rng *r);
// A file that is JSON, mostly as that.
void mutate_text(struct bytes *b, struct ng_rng *r);
// The JSON chunk of a GLB, with lengths that are right again, or the file as bytes.
void mutate_glb(struct bytes *b, struct ng_rng *r);

#endif

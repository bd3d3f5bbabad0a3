// Named arrays in a file: safetensors (huggingface/safetensors, format of 2023), which numpy and torch read.
//
//     u64 n, little endian | n bytes of JSON, padded with spaces to a multiple of 8 | data
//     {"__metadata__": {"hash": "16 hex digits", ...}, "12/target.indirect": {"dtype": "F32",
//      "shape": [4, 3, 128, 128], "data_offsets": [0, 786432]}, ...}
//
// Tensors lie without gaps, those of wide elements first, so that each is aligned. The hash is of the whole
// file with the digits themselves read as zeros: it finds damage anywhere.
#ifndef LF_TENSORS_TENSORS_H
#define LF_TENSORS_TENSORS_H

#include "base/array.h"
#include "base/extern_c.h"
#include "base/result.h"

#include <stdint.h>

NG_EXTERN_C_BEGIN

enum lf_dtype { LF_F32, LF_I32, LF_F16, LF_U8 };
#define LF_TENSOR_RANK  6
#define LF_TENSOR_NAME  64
#define LF_TENSOR_LIMIT ((uint64_t)2 << 30) // bytes of a file's data

uint32_t lf_dtype_size(enum lf_dtype dtype);
const char *lf_dtype_name(enum lf_dtype dtype); // "F32", ...

struct lf_tensor {
    char name[LF_TENSOR_NAME];
    enum lf_dtype dtype;
    uint32_t rank;
    uint64_t shape[LF_TENSOR_RANK];
    uint64_t size; // bytes
    void *data;
};

// A word about the whole file.
struct lf_tensor_note {
    char key[32];
    char *value; // owned
};

// To write: zero is empty. Read: everything points into `file`.
struct lf_tensors {
    NG_ARRAY(struct lf_tensor) list;
    NG_ARRAY(struct lf_tensor_note) notes; // without the hash
    uint64_t hash;                         // set by write and read
    uint64_t bytes;                        // of all data
    void *file;                            // as read; null when written
};

// Adds a tensor of zeros and returns its data, of `shape`[rank], row-major. Null, logged, if there is no
// memory or the file would pass LF_TENSOR_LIMIT.
void *lf_tensors_add(struct lf_tensors *t, const char *name, enum lf_dtype dtype, uint32_t rank,
                     const uint64_t *shape);
NG_NODISCARD ng_result lf_tensors_note(struct lf_tensors *t, const char *key, const char *value);
// Null if there is none.
const struct lf_tensor *lf_tensors_find(const struct lf_tensors *t, const char *name);
const char *lf_tensors_noted(const struct lf_tensors *t, const char *key);

// Whole or not at all (ng_file_write).
NG_NODISCARD ng_result lf_tensors_write(struct lf_tensors *t, const char *path);
// Trusts nothing. Errors, logged: those of ng_file_read; NG_ERROR_FORMAT: not a safetensors file, one without
// our hash, or damaged. `out` is then empty.
NG_NODISCARD ng_result lf_tensors_read(const char *path, struct lf_tensors *out);
// The same for a file that may well be damaged: what is wrong with its contents is told instead of logged.
// `*wrong` is null if the file could not be read at all.
NG_NODISCARD ng_result lf_tensors_try(const char *path, struct lf_tensors *out, const char **wrong);
void lf_tensors_finish(struct lf_tensors *t);

NG_EXTERN_C_END

#endif

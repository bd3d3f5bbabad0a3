// Whole files in, whole files out. Errors are logged with the path, the reason and what to do, and returned.
#ifndef NG_BASE_FILE_H
#define NG_BASE_FILE_H

#include "base/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Reads a regular file whole. `*data` is from malloc, owned by the caller, and followed by a zero byte that
// is not counted. Files larger than `limit` bytes (0: 4 GiB) are refused before anything is allocated.
NG_NODISCARD ng_result ng_file_read(const char *path, uint64_t limit, void **data, size_t *size);
// The same for a file that another one names: messages begin with `name` instead of the path.
NG_NODISCARD ng_result ng_file_read_named(const char *name, const char *path, uint64_t limit, void **data,
                                          size_t *size);

// Writes to "path.tmp-PID", flushes to disk and renames: readers see the old file or the new one, never a
// part. A symbolic link stays one, its target is replaced; devices and pipes are written to as they are.
NG_NODISCARD ng_result ng_file_write(const char *path, const void *data, size_t size);
// Whether ng_file_write would find a place for this file: to be asked before hours of work. Writes nothing.
NG_NODISCARD ng_result ng_file_check_writable(const char *path);

bool ng_file_exists(const char *path);
// Whether two paths lead to one file, or would if it were there.
bool ng_file_same(const char *a, const char *b);
// Creates a directory and its parents where missing.
NG_NODISCARD ng_result ng_file_make_directory(const char *path);
// Calls `fn` with the name of each entry of a directory, "." and ".." too, in no order.
NG_NODISCARD ng_result ng_file_list(const char *path, void (*fn)(void *user, const char *name), void *user);

// Writes "DIR/NAME" into out, where DIR is the directory part of `beside` ("" if none). An absolute NAME
// stays as it is. False if it does not fit.
bool ng_path_beside(const char *beside, const char *name, char *out, size_t out_size);
// The part after the last dot of the last path component, without the dot; "" if none. Borrowed from `path`.
const char *ng_path_extension(const char *path);
// The last path component. Borrowed from `path`.
const char *ng_path_name(const char *path);

#endif

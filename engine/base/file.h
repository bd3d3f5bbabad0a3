// Whole files in, whole files out. Errors are logged with the path, the reason and what to do, and returned.
#ifndef NG_BASE_FILE_H
#define NG_BASE_FILE_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

// Reads a regular file whole. `*data` is from malloc, owned by the caller, and followed by a zero byte that
// is not counted. Files larger than `limit` bytes (0: 4 GiB) are refused before anything is allocated.
NG_NODISCARD ng_result ng_file_read(const char *path, uint64_t limit, void **data, size_t *size);
// The same for a file that another one names, or of a limit that can be raised: messages begin with `name`
// instead of the path, that of the limit ends with `raise` (may be null).
NG_NODISCARD ng_result ng_file_read_named(const char *name, const char *path, uint64_t limit,
                                          const char *raise, void **data, size_t *size);

// Writes beside it under a name of its own, flushes to disk, renames: readers see the old file or the new
// one, never a part. What is replaced keeps its mode, and as far as the process may give them its owner and
// access list; its other hard links keep the old bytes. A file that nobody may write to is refused. A
// symbolic link stays one: what it leads to is replaced or made. Devices and pipes are written to as they
// are, /dev/stdout after what went there before. What a process that was killed has left of a file is removed
// by the next who writes it. Thread-safe; one file is written at a time.
NG_NODISCARD ng_result ng_file_write(const char *path, const void *data, size_t size);
// Whether ng_file_write would find a place for this file: to be asked before hours of work. Writes nothing.
NG_NODISCARD ng_result ng_file_check_writable(const char *path);
// Removes what ng_file_write has not finished, for a process that ends at once. Safe in a signal handler.
void ng_file_abandon(void);

bool ng_file_exists(const char *path);
// What a path leads to, links followed: paths with equal ids are one file or folder, or would be if it were
// there.
struct ng_file_id {
    uint64_t device, number; // of the file; of its folder, if it is not there yet
    uint64_t name;           // hash of a name that is not there yet; else 0
};
// False for what cannot be replaced, such as devices and pipes, and where not even a folder is.
bool ng_file_identify(const char *path, struct ng_file_id *out);
bool ng_file_same(const char *a, const char *b);
// Whether a file, links followed, is in the folder of the path `beside` or below; true if there is none.
bool ng_file_is_below(const char *path, const char *beside);
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

NG_EXTERN_C_END

#endif

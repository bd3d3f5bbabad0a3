// Where a path leads, for those who write there or compare it with another.
#ifndef NG_BASE_FILE_INTERNAL_H
#define NG_BASE_FILE_INTERNAL_H

#include "base/result.h"

#include <limits.h>
#include <stdbool.h>
#include <sys/stat.h>

struct ng_file_place {
    char folder[PATH_MAX]; // without links; the file's own name may not be there yet
    char path[PATH_MAX];   // the folder, '/' and the name
    int descriptor;        // one of this process that the path stands for (/dev/stdout); else -1
    bool exists;
    struct stat status; // if it exists
};

// Follows links to their end, also to one where nothing is. Errors, logged with `path`: NG_ERROR_NOT_FOUND,
// NG_ERROR_IO.
NG_NODISCARD ng_result ng_file_place_find(const char *path, struct ng_file_place *out);
// The same, silently: errno says why not.
bool ng_file_place_try(const char *path, struct ng_file_place *out);
// Whether a file can be written there, or replaced; if not it was logged with `path`.
NG_NODISCARD ng_result ng_file_place_check(const char *path, const struct ng_file_place *place);

// Logs "NAME: cannot VERB: what errno says".
ng_result ng_file_error(const char *verb, const char *name);

#endif

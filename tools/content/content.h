// What tools/content makes: every file of content/, each by one function.
#ifndef CONTENT_CONTENT_H
#define CONTENT_CONTENT_H

#include "image.h"

struct content_file {
    const char *path; // below content/
    ng_result (*build)(struct bytes *out);
};

// All files; ends with a null path.
extern const struct content_file content_files[];

// Builds one file. On failure one line names it, and `out` is empty.
NG_NODISCARD ng_result content_build(const struct content_file *file, struct bytes *out);

// The scenes, by source file.
NG_NODISCARD ng_result chess_build(struct bytes *out);

#endif

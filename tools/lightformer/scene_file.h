// What SCENE may name: told from a network before it is read as glTF, whose parser would find malformed JSON.
#ifndef LIGHTFORMER_SCENE_FILE_H
#define LIGHTFORMER_SCENE_FILE_H

#include "base/result.h"

// NG_ERROR_FORMAT, logged, for a network by its name. Whether there is such a file is for others to find.
NG_NODISCARD ng_result scene_file_check(const char *path);

#endif

// What tinygltf reads of a file by itself, as text, for tests of what the engine has it read.
#ifndef NG_TESTS_UNIT_TINYGLTF_TEXT_H
#define NG_TESTS_UNIT_TINYGLTF_TEXT_H

#include "base/extern_c.h"

#include <stddef.h>

NG_EXTERN_C_BEGIN

struct gltf_document;

// Both from malloc, of one form: a line for each node, mesh, primitive, accessor, ...
// Of the file as it is; null: tinygltf does not take it.
char *tinygltf_text_of_file(const char *path);
char *tinygltf_text_of_document(const struct gltf_document *doc);

NG_EXTERN_C_END

#endif

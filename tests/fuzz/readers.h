// What several fuzzers do with a file.
#ifndef NG_TESTS_READERS_H
#define NG_TESTS_READERS_H

#include "base/result.h"

// Loads a scene of any format; one that loads is animated, extracted, and asked for its variations. Of one
// that does not, nothing is left.
ng_result fuzz_read_scene(const char *path);

#endif

// What a furniture catalogue has: lightformer info CATALOGUE.sh3f.
#ifndef LIGHTFORMER_INFO_CATALOGUE_H
#define LIGHTFORMER_INFO_CATALOGUE_H

#include "base/result.h"

#include <stdbool.h>

NG_NODISCARD ng_result info_catalogue(const char *path, bool json);

#endif

// What is in a scene, and what is made where its file says nothing: lightformer info SCENE.
#ifndef LIGHTFORMER_INFO_SCENE_H
#define LIGHTFORMER_INFO_SCENE_H

#include "base/result.h"

#include <stdbool.h>

struct opening;

NG_NODISCARD ng_result info_scene(const char *path, bool json, const struct opening *opening);

#endif

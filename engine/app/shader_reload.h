// Shaders from their sources while the program runs, for those who work on them: a changed file is compiled
// with the command of the build (glslangValidator) in a thread of its own, and what draws it changes between
// frames. The last good shaders stay while a file has an error, which is one line that names file and line.
//
// The folder stands in the place of engine/shaders: stages (x.vert, x.frag, x.comp) by the names of those
// built in, and what they include, in it or in folders below. A stage that is not there stays as it is.
// Structs of engine/shaders/shared are the program's, too: where they change, it must be built again.
#ifndef NG_APP_SHADER_RELOAD_H
#define NG_APP_SHADER_RELOAD_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct ng_gpu;
struct ng_shader_reload;

// Without a stage in the folder: an error.
NG_NODISCARD ng_result ng_shader_reload_create(const char *folder, struct ng_shader_reload **out);
void ng_shader_reload_destroy(struct ng_shader_reload **reload);
// Between frames, now and then. Touches no file itself. True: what was compiled since the last time has been
// put in place, or has an error, which is said.
bool ng_shader_reload_update(struct ng_shader_reload *reload, struct ng_gpu *gpu);
// Whether what is in the files now is not what is drawn.
bool ng_shader_reload_failed(const struct ng_shader_reload *reload);

NG_EXTERN_C_END

#endif

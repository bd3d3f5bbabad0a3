#include "scene_file.h"

#include "base/file.h"
#include "base/log.h"

#include <string.h>

ng_result scene_file_check(const char *path)
{
    if (strcmp(ng_path_extension(path), "safetensors") != 0)
        return NG_OK;
    ng_log_error(
        "%s: is a network, not a scene; lightformer net shows it, lightformer bench --net measures it", path);
    return NG_ERROR_FORMAT;
}

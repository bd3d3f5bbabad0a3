#include "content.h"

#include "base/log.h"

const struct content_file content_files[] = {
    {"chess/chess.glb", chess_build},
    {0},
};

ng_result content_build(const struct content_file *file, struct bytes *out)
{
    *out = (struct bytes){0};
    ng_result result = file->build(out);
    if (result != NG_OK) {
        ng_log_error("content/%s was not built: %s", file->path, ng_result_text(result));
        bytes_finish(out);
    }
    return result;
}

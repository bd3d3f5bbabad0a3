#include "view_shot.h"
#include "output.h"

#include "app/clip_menu.h"
#include "base/file.h"
#include "base/log.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_SHOTS 9999

// The scene's name without what follows its last dot, and the number.
static bool name_shot(const char *scene, int number, char *out, size_t size)
{
    const char *name = ng_path_name(scene), *extension = ng_path_extension(name);
    int stem = (int)(strlen(name) - strlen(extension)) - (*extension ? 1 : 0);
    int n = snprintf(out, size, "%.*s.%04d.png", stem, name, number);
    return n >= 0 && (size_t)n < size;
}

// Makes a file that nobody has made before.
static FILE *open_next(const char *scene, char *path, size_t size)
{
    FILE *file = NULL;
    for (int i = 1; !file && i <= MOST_SHOTS; i++) {
        if (!name_shot(scene, i, path, size))
            break;
        errno = 0;
        file = fopen(path, "wbx");
        if (!file && errno != EEXIST)
            break;
    }
    if (!file)
        ng_log_error("%s: the picture cannot be written here: %s", path,
                     errno ? strerror(errno) : "no name is free");
    return file;
}

ng_result view_shot_write(const struct view_frame *f, const char *command, char *said, size_t size)
{
    const struct output_origin origin = {command, f->scene_hash};
    const struct output_picture picture = {
        .width = f->width, .height = f->height, .display = f->pixels.items};
    char path[512] = "";
    void *data;
    size_t bytes;
    NG_TRY(output_encode_png(&picture, &origin, &data, &bytes));
    FILE *file = open_next(f->scene, path, sizeof path);
    bool written = file && fwrite(data, 1, bytes, file) == bytes;
    free(data);
    if (!file)
        return NG_ERROR_IO;
    if (fclose(file) != 0 || !written) {
        ng_log_error("%s: the picture could not be written whole; is the disk full?", path);
        remove(path);
        return NG_ERROR_IO;
    }
    snprintf(said, size, "written: %s", path);
    return NG_OK;
}

const char *view_clip_option(const struct view_frame *f, const char *opened)
{
    uint32_t clip = f->order.clip;
    if (clip == NG_CLIPS_ALL || clip == NG_CLIPS_NONE)
        return clip == NG_CLIPS_ALL ? "all" : "none";
    return clip < f->clips.count ? f->clips.items[clip].name : opened;
}

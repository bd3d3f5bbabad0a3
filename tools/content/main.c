// content_builder DIR: writes every file of content/ below DIR.
#include "content.h"

#include "base/file.h"
#include "base/interrupt.h"
#include "base/log.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static ng_result write_file(const char *dir, const struct content_file *file)
{
    char path[4096];
    int n = snprintf(path, sizeof path, "%s/%s", dir, file->path);
    NG_REQUIRE(n > 0 && (size_t)n < sizeof path, "the directory's name is too long");
    struct bytes bytes;
    NG_TRY(content_build(file, &bytes));
    char *slash = strrchr(path, '/');
    *slash = 0;
    ng_result result = ng_file_make_directory(path);
    *slash = '/';
    if (result == NG_OK)
        result = ng_file_write(path, bytes.items, bytes.count);
    if (result == NG_OK)
        printf("%8zu  %s\n", bytes.count, path);
    bytes_finish(&bytes);
    return result;
}

int main(int argc, char **argv)
{
    ng_interrupt_watch();
    bool help = argc == 2 && strcmp(argv[1], "--help") == 0;
    if (argc != 2 || argv[1][0] == '-') { // an option's name is a poor one for a folder; "./-x" is one
        fputs("usage: content_builder DIR\nWrites the files of content/ below DIR.\n",
              help ? stdout : stderr);
        return help ? 0 : 2;
    }
    for (const struct content_file *f = content_files; f->path; f++)
        if (write_file(argv[1], f) != NG_OK)
            return 1;
    return 0;
}

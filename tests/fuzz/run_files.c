// The main of a fuzz target where there is no libFuzzer: runs it on the files given, and on those of the
// folders given. Options are libFuzzer's, and have no meaning here.
#include "target.h"

#include "base/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static unsigned count;

static bool run_file(const char *path)
{
    void *data;
    size_t size;
    printf("%s\n", path);
    fflush(stdout); // the last line names what crashed
    if (ng_file_read(path, 0, &data, &size) != NG_OK)
        return false;
    // A copy of exactly this size, so that AddressSanitizer sees a byte read past it.
    uint8_t *bytes = malloc(size ? size : 1);
    if (bytes) {
        memcpy(bytes, data, size);
        LLVMFuzzerTestOneInput(bytes, size);
        count++;
    }
    free(bytes);
    free(data);
    return bytes;
}

static void run_entry(void *user, const char *name)
{
    char path[1024];
    const char *folder = user;
    if (name[0] != '.' && (size_t)snprintf(path, sizeof path, "%s/%s", folder, name) < sizeof path &&
        !run_file(path))
        exit(EXIT_FAILURE);
}

static bool run(char *path)
{
    struct stat status;
    bool folder = stat(path, &status) == 0 && S_ISDIR(status.st_mode);
    return folder ? ng_file_list(path, run_entry, path) == NG_OK : run_file(path);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (argv[i][0] != '-' && !run(argv[i]))
            return EXIT_FAILURE;
    printf("%u inputs\n", count);
    return count ? EXIT_SUCCESS : EXIT_FAILURE;
}

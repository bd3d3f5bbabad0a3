#include "target.h"

#include "test.h"

#include "base/file.h"

#include <unistd.h>

static const char *folder(void)
{
    static char path[512];
    if (path[0])
        return path;
    const char *parent = getenv("NG_TEST_DIR");
    snprintf(path, sizeof path, "%s/fuzz.%ld", parent ? parent : "/tmp", (long)getpid());
    if (ng_file_make_directory(path) != NG_OK)
        abort();
    return path;
}

static const char *path_of(const char *name)
{
    static char paths[4][600]; // as many files as a target has
    static unsigned count;
    char path[sizeof paths[0]];
    snprintf(path, sizeof path, "%s/%s", folder(), name);
    for (unsigned i = 0; i < count; i++)
        if (strcmp(paths[i], path) == 0)
            return paths[i];
    if (count == NG_COUNT(paths))
        abort();
    return memcpy(paths[count++], path, sizeof path);
}

// Not ng_file_write, which waits for the disk.
const char *target_file(const char *name, const void *data, size_t size)
{
    const char *path = path_of(name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) {
        perror(path);
        abort();
    }
    return path;
}

void target_remove(const char *name)
{
    (void)remove(path_of(name));
}

static struct test_log log_now;

void target_begin(void)
{
    test_log_begin(&log_now);
}

void target_end(ng_result result)
{
    test_log_end(&log_now);
    if (log_now.errors == (result != NG_OK) && result != NG_ERROR_USAGE)
        return;
    fprintf(stderr, "%s, but %d errors were logged:\n%s\n", ng_result_text(result), log_now.errors,
            log_now.text);
    abort();
}

void target_ignore(void)
{
    test_log_end(&log_now);
}

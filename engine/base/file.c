#define _POSIX_C_SOURCE 200809L
#include "base/file.h"
#include "base/file_internal.h"
#include "base/log.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

ng_result ng_file_error(const char *verb, const char *name)
{
    int e = errno;
    ng_log_error("%s: cannot %s: %s", name, verb, strerror(e));
    return e == ENOENT ? NG_ERROR_NOT_FOUND : NG_ERROR_IO;
}

ng_result ng_file_read_named(const char *name, const char *path, uint64_t limit, const char *raise,
                             void **data, size_t *size)
{
    if (limit == 0)
        limit = (uint64_t)4 << 30;
    // O_NONBLOCK: opening a pipe must fail below, not wait for a writer.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return ng_file_error("open", name);
    struct stat st;
    if (fstat(fd, &st) != 0) {
        ng_result r = ng_file_error("read", name);
        close(fd);
        return r;
    }
    if (!S_ISREG(st.st_mode)) {
        ng_log_error("%s: is not a regular file", name);
        close(fd);
        return NG_ERROR_IO;
    }
    if ((uint64_t)st.st_size > limit) {
        ng_log_error("%s: has %lld bytes, more than the limit of %llu%s", name, (long long)st.st_size,
                     (unsigned long long)limit, raise ? raise : "");
        close(fd);
        return NG_ERROR_MEMORY;
    }
    size_t want = (size_t)st.st_size, got = 0;
    unsigned char *p = malloc(want + 1);
    if (!p) {
        ng_log_error("%s: out of memory for %zu bytes", name, want);
        close(fd);
        return NG_ERROR_MEMORY;
    }
    while (got < want) {
        ssize_t n = read(fd, p + got, want - got);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0) {
            ng_result r = ng_file_error("read", name);
            free(p);
            close(fd);
            return r;
        }
        if (n == 0)
            break; // truncated while we read: what is there is what counts
        got += (size_t)n;
    }
    close(fd);
    p[got] = 0;
    *data = p;
    *size = got;
    return NG_OK;
}

ng_result ng_file_read(const char *path, uint64_t limit, void **data, size_t *size)
{
    return ng_file_read_named(path, path, limit, NULL, data, size);
}

bool ng_file_exists(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0;
}

ng_result ng_file_make_directory(const char *path)
{
    char part[4096];
    size_t n = strlen(path);
    if (n == 0 || n >= sizeof part) {
        ng_log_error("\"%.200s\": not a usable directory name", path);
        return NG_ERROR_IO;
    }
    memcpy(part, path, n + 1);
    for (size_t i = 1; i <= n; i++) {
        if (part[i] != '/' && part[i] != 0)
            continue;
        char saved = part[i];
        part[i] = 0;
        if (mkdir(part, 0777) != 0 && errno != EEXIST)
            return ng_file_error("create directory", part);
        part[i] = saved;
    }
    return NG_OK;
}

ng_result ng_file_list(const char *path, void (*fn)(void *user, const char *name), void *user)
{
    DIR *directory = opendir(path);
    if (!directory)
        return ng_file_error("open", path);
    errno = 0;
    for (const struct dirent *entry; (entry = readdir(directory)); errno = 0)
        fn(user, entry->d_name);
    ng_result result = errno ? ng_file_error("read", path) : NG_OK;
    closedir(directory);
    return result;
}

bool ng_path_beside(const char *beside, const char *name, char *out, size_t out_size)
{
    const char *slash = strrchr(beside, '/');
    int directory = slash && name[0] != '/' ? (int)(slash - beside + 1) : 0;
    int n = snprintf(out, out_size, "%.*s%s", directory, beside, name);
    return n >= 0 && (size_t)n < out_size;
}

const char *ng_path_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

const char *ng_path_extension(const char *path)
{
    const char *name = ng_path_name(path);
    const char *dot = strrchr(name, '.');
    return dot && dot != name ? dot + 1 : "";
}

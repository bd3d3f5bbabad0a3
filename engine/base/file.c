#define _XOPEN_SOURCE 700 // realpath
#include "base/file.h"
#include "base/log.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static ng_result io_error(const char *verb, const char *name)
{
    int e = errno;
    ng_log_error("%s: cannot %s: %s", name, verb, strerror(e));
    return e == ENOENT ? NG_ERROR_NOT_FOUND : NG_ERROR_IO;
}

ng_result ng_file_read_named(const char *name, const char *path, uint64_t limit, void **data, size_t *size)
{
    if (limit == 0)
        limit = (uint64_t)4 << 30;
    // O_NONBLOCK: opening a pipe must fail below, not wait for a writer.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return io_error("open", name);
    struct stat st;
    if (fstat(fd, &st) != 0) {
        ng_result r = io_error("read", name);
        close(fd);
        return r;
    }
    if (!S_ISREG(st.st_mode)) {
        ng_log_error("%s: is not a regular file", name);
        close(fd);
        return NG_ERROR_IO;
    }
    if ((uint64_t)st.st_size > limit) {
        ng_log_error("%s: has %lld bytes, more than the limit of %llu", name, (long long)st.st_size,
                     (unsigned long long)limit);
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
            ng_result r = io_error("read", name);
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
    return ng_file_read_named(path, path, limit, data, size);
}

static bool write_all(int fd, const unsigned char *p, size_t size)
{
    while (size) {
        ssize_t n = write(fd, p, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        p += n;
        size -= (size_t)n;
    }
    return true;
}

// Closes in any case. On failure errno is that of the first call that failed.
static bool write_and_close(int fd, const void *data, size_t size, bool flush)
{
    bool ok = write_all(fd, data, size) && (!flush || fsync(fd) == 0);
    int e = errno;
    if (close(fd) != 0 && ok)
        return false;
    errno = e;
    return ok;
}

// Devices, pipes and the like are not replaced by a file: they are written to.
static ng_result write_in_place(const char *path, const void *data, size_t size)
{
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    return fd >= 0 && write_and_close(fd, data, size, false) ? NG_OK : io_error("write", path);
}

static ng_result replace(const char *path, const void *data, size_t size)
{
    char temporary[PATH_MAX];
    int n = snprintf(temporary, sizeof temporary, "%s.tmp-%ld", path, (long)getpid());
    if (n < 0 || (size_t)n >= sizeof temporary) {
        ng_log_error("%.200s...: path is too long", path);
        return NG_ERROR_IO;
    }
    int fd = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (fd < 0)
        return io_error("write", path);
    if (write_and_close(fd, data, size, true) && rename(temporary, path) == 0)
        return NG_OK;
    ng_result r = io_error("write", path);
    unlink(temporary);
    return r;
}

ng_result ng_file_write(const char *path, const void *data, size_t size)
{
    struct stat st;
    if (stat(path, &st) != 0)
        return replace(path, data, size);
    if (!S_ISREG(st.st_mode))
        return write_in_place(path, data, size);
    // A link stays a link: what it points to is replaced.
    char *target = realpath(path, NULL);
    if (!target)
        return io_error("write", path);
    ng_result r = replace(target, data, size);
    free(target);
    return r;
}

// The directory in which `path` is replaced.
static bool directory_is_writable(const char *path)
{
    char directory[PATH_MAX];
    return ng_path_beside(path, ".", directory, sizeof directory) && access(directory, W_OK | X_OK) == 0;
}

ng_result ng_file_check_writable(const char *path)
{
    struct stat st;
    if (stat(path, &st) != 0)
        return directory_is_writable(path) ? NG_OK : io_error("write", path);
    if (S_ISDIR(st.st_mode)) {
        errno = EISDIR;
        return io_error("write", path);
    }
    if (!S_ISREG(st.st_mode))
        return access(path, W_OK) == 0 ? NG_OK : io_error("write", path);
    char *target = realpath(path, NULL);
    ng_result r = target && directory_is_writable(target) ? NG_OK : io_error("write", path);
    free(target);
    return r;
}

bool ng_file_exists(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0;
}

static bool same_place(const char *a, const char *b)
{
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

bool ng_file_same(const char *a, const char *b)
{
    char of_a[PATH_MAX], of_b[PATH_MAX];
    if (ng_file_exists(a) || ng_file_exists(b))
        return same_place(a, b);
    return strcmp(ng_path_name(a), ng_path_name(b)) == 0 && ng_path_beside(a, ".", of_a, sizeof of_a) &&
           ng_path_beside(b, ".", of_b, sizeof of_b) && same_place(of_a, of_b);
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
            return io_error("create directory", part);
        part[i] = saved;
    }
    return NG_OK;
}

ng_result ng_file_list(const char *path, void (*fn)(void *user, const char *name), void *user)
{
    DIR *directory = opendir(path);
    if (!directory)
        return io_error("open", path);
    errno = 0;
    for (const struct dirent *entry; (entry = readdir(directory)); errno = 0)
        fn(user, entry->d_name);
    ng_result result = errno ? io_error("read", path) : NG_OK;
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

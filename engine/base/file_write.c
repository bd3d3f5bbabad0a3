// Files are replaced, not changed: the new one is made beside the old one and takes its place when it is
// whole and on the disk. So whoever reads finds one of the two, whatever happens in between.
#define _GNU_SOURCE // O_PATH
#include "base/file.h"
#include "base/file_internal.h"
#include "base/log.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>
#include <sys/xattr.h>
#include <unistd.h>

// The file that is being made. One at a time: the disk would not take two faster.
static pthread_mutex_t making = PTHREAD_MUTEX_INITIALIZER;
static struct {
    int folder;
    char name[NAME_MAX + 1];
    atomic_bool there;
} unfinished;

void ng_file_abandon(void)
{
    if (atomic_load(&unfinished.there))
        unlinkat(unfinished.folder, unfinished.name, 0);
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

// Not every file system, and not every folder, can be told to reach the disk.
static bool sync_to_disk(int fd)
{
    return fsync(fd) == 0 || errno == EINVAL || errno == ENOSYS || errno == EBADF;
}

// Closes in any case; errno is that of what failed first.
static bool close_after(bool ok, int fd)
{
    int e = errno;
    if (close(fd) != 0 && ok)
        return false;
    errno = e;
    return ok;
}

// Devices, pipes and the like are not replaced by a file: they are written to.
static bool write_in_place(const struct ng_file_place *place, const void *data, size_t size)
{
    int fd = place->descriptor;
    if (fd >= 0)
        return (fd != STDOUT_FILENO || fflush(stdout) == 0) && write_all(fd, data, size);
    fd = open(place->path, O_WRONLY | O_CLOEXEC);
    return fd >= 0 && close_after(write_all(fd, data, size), fd);
}

// "NAME.tmp-RANDOM", cut where it would be too long for a name; not within a letter, which some file systems
// refuse.
static bool choose_name(const char *path)
{
    enum { SUFFIX = 5 + 16 };
    const char *name = ng_path_name(path);
    uint64_t random;
    size_t length = strlen(name);
    if (getrandom(&random, sizeof random, 0) != sizeof random)
        return false;
    if (length > NAME_MAX - SUFFIX)
        for (length = NAME_MAX - SUFFIX; length > 0 && ((unsigned char)name[length] & 0xc0) == 0x80;)
            length--;
    snprintf(unfinished.name, sizeof unfinished.name, "%.*s.tmp-%016" PRIx64, (int)length, name, random);
    return true;
}

// Owner, list of access and mode of the file that is replaced, as far as we may give them; no program becomes
// another user's by it.
static bool keep_access(int fd, const struct ng_file_place *place)
{
    static const char list[] = "system.posix_acl_access";
    char access[4096];
    const struct stat *old = &place->status;
    if (!place->exists)
        return true;
    if (fchown(fd, old->st_uid, old->st_gid) != 0 && fchown(fd, (uid_t)-1, old->st_gid) != 0)
        ng_log_debug("%s: its owner changes", place->path);
    if (fchmod(fd, old->st_mode & (S_IRWXU | S_IRWXG | S_IRWXO)) != 0)
        return false;
    ssize_t n = getxattr(place->path, list, access, sizeof access);
    return n <= 0 || fsetxattr(fd, list, access, (size_t)n, 0) == 0;
}

static bool fill(int fd, const struct ng_file_place *place, const void *data, size_t size)
{
    return close_after(write_all(fd, data, size) && keep_access(fd, place) && sync_to_disk(fd), fd);
}

static bool replace_in(int folder, const struct ng_file_place *place, const void *data, size_t size)
{
    if (!choose_name(place->path))
        return false;
    unfinished.folder = folder;
    atomic_store(&unfinished.there, true);
    // Until it has the mode of the old one it is for our eyes only.
    int fd = openat(folder, unfinished.name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                    place->exists ? 0600 : 0666);
    bool ok = fd >= 0 && fill(fd, place, data, size) &&
              renameat(folder, unfinished.name, folder, ng_path_name(place->path)) == 0;
    int e = errno;
    if (fd >= 0 && !ok)
        unlinkat(folder, unfinished.name, 0);
    atomic_store(&unfinished.there, false);
    errno = e;
    return ok && sync_to_disk(folder);
}

static bool replace(const struct ng_file_place *place, const void *data, size_t size)
{
    int folder = open(place->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0 && errno == EACCES) // one that may be written to, but not listed
        folder = open(place->folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0)
        return false;
    pthread_mutex_lock(&making);
    bool ok = replace_in(folder, place, data, size);
    pthread_mutex_unlock(&making);
    return close_after(ok, folder);
}

ng_result ng_file_write(const char *path, const void *data, size_t size)
{
    struct ng_file_place place;
    NG_TRY(ng_file_place_find(path, &place));
    NG_TRY(ng_file_place_check(path, &place));
    bool stream = place.descriptor >= 0 || (place.exists && !S_ISREG(place.status.st_mode));
    return (stream ? write_in_place : replace)(&place, data, size) ? NG_OK : ng_file_error("write", path);
}

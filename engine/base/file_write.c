// Files are replaced, not changed: the new one is made beside the old one and takes its place when it is
// whole and on the disk. So whoever reads finds one of the two, whatever happens in between.
#define _GNU_SOURCE // O_PATH
#include "base/file.h"
#include "base/file_internal.h"
#include "base/log.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
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

// ---- the unfinished file ---------------------------------------------------------------------------------
// "NAME.tmp-RANDOM", cut where it would be too long for a name; not within a letter, which some file systems
// refuse. Who makes it holds a lock on it, which ends with the process: one without a lock is nobody's.
#define MARK   ".tmp-"
#define DIGITS 16
#define TRIES  16 // names, of which others take each for nobody's before it is locked

static size_t stem_length(const char *name)
{
    const size_t most = NAME_MAX - strlen(MARK) - DIGITS;
    size_t length = strlen(name);
    if (length > most)
        for (length = most; length > 0 && ((unsigned char)name[length] & 0xc0) == 0x80;)
            length--;
    return length;
}

static bool choose_name(const char *name)
{
    uint64_t random;
    if (getrandom(&random, sizeof random, 0) != sizeof random)
        return false;
    snprintf(unfinished.name, sizeof unfinished.name, "%.*s" MARK "%016" PRIx64, (int)stem_length(name), name,
             random);
    return true;
}

static bool is_unfinished(const char *entry, const char *name)
{
    const size_t stem = stem_length(name), mark = strlen(MARK);
    return strncmp(entry, name, stem) == 0 && strncmp(entry + stem, MARK, mark) == 0 &&
           strspn(entry + stem + mark, "0123456789abcdef") == DIGITS && !entry[stem + mark + DIGITS];
}

static void remove_if_left(int folder, const char *entry)
{
    struct stat status;
    int fd = openat(folder, entry, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd >= 0 && fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && flock(fd, LOCK_EX | LOCK_NB) == 0)
        unlinkat(folder, entry, 0);
    if (fd >= 0)
        close(fd);
}

// Removes what processes that were killed have left of a file. Nothing depends on it, so nothing fails.
static void sweep(int folder, const char *name)
{
    int fd = openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *entries = fd >= 0 ? fdopendir(fd) : NULL;
    if (!entries && fd >= 0)
        close(fd);
    for (struct dirent *e; entries && (e = readdir(entries));)
        if (is_unfinished(e->d_name, name))
            remove_if_left(folder, e->d_name);
    if (entries)
        closedir(entries);
}

// Locked, where the file system has locks, and under its name still; -1: errno says why not.
static int make_unfinished(int folder, const struct ng_file_place *place)
{
    unfinished.folder = folder;
    for (int i = 0; i < TRIES && choose_name(ng_path_name(place->path)); i++) {
        struct stat status;
        atomic_store(&unfinished.there, true);
        // Until it has the mode of the old one it is for our eyes only.
        int fd = openat(folder, unfinished.name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                        place->exists ? 0600 : 0666);
        if (fd < 0)
            return -1;
        bool locked = flock(fd, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
        if (locked && fstat(fd, &status) == 0 && status.st_nlink > 0)
            return fd;
        unlinkat(folder, unfinished.name, 0);
        close(fd);
        atomic_store(&unfinished.there, false);
        errno = EBUSY;
    }
    return -1;
}

// ---- replacing -------------------------------------------------------------------------------------------

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
    return write_all(fd, data, size) && keep_access(fd, place) && sync_to_disk(fd);
}

static bool replace_in(int folder, const struct ng_file_place *place, const void *data, size_t size)
{
    const char *name = ng_path_name(place->path);
    sweep(folder, name);
    int fd = make_unfinished(folder, place);
    int lock = fd >= 0 ? dup(fd) : -1; // closing may fail, so it comes first; the lock is held to the end
    bool ok = fd >= 0 && close_after(fill(fd, place, data, size), fd) &&
              renameat(folder, unfinished.name, folder, name) == 0;
    int e = errno;
    if (fd >= 0 && !ok)
        unlinkat(folder, unfinished.name, 0);
    if (lock >= 0)
        close(lock);
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

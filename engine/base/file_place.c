#define _GNU_SOURCE // AT_EACCESS, realpath
#include "base/file.h"
#include "base/file_internal.h"
#include "base/hash.h"
#include "base/log.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MOST_LINKS 40 // as the kernel has it

static bool join(const char *folder, const char *name, char out[PATH_MAX])
{
    const char *slash = strcmp(folder, "/") == 0 ? "" : "/";
    int n = snprintf(out, PATH_MAX, "%s%s%s", folder, slash, name);
    errno = ENAMETOOLONG;
    return n >= 0 && n < PATH_MAX;
}

// The real path of the folder that a path's last name is in.
static bool find_folder(const char *path, char out[PATH_MAX])
{
    char beside[PATH_MAX];
    errno = ENAMETOOLONG;
    return ng_path_beside(path, ".", beside, sizeof beside) && realpath(beside, out);
}

// "/proc/PID/fd/N", where /dev/stdout and /dev/fd/N lead to: what is there is no file that could be replaced.
static int own_descriptor(const struct ng_file_place *place)
{
    char own[64];
    snprintf(own, sizeof own, "/proc/%ld/fd", (long)getpid());
    if (strcmp(place->folder, own) != 0)
        return -1;
    char *end;
    long n = strtol(ng_path_name(place->path), &end, 10);
    return *end == 0 && n >= 0 && n <= INT_MAX ? (int)n : -1;
}

// One step: to the folder and the name of `at`; if a link is there `at` becomes what it says.
static bool step(char at[PATH_MAX], struct ng_file_place *out, bool *link)
{
    char target[PATH_MAX];
    *link = false;
    if (!find_folder(at, out->folder) || !join(out->folder, ng_path_name(at), out->path))
        return false;
    out->descriptor = own_descriptor(out);
    ssize_t n = out->descriptor < 0 ? readlink(out->path, target, sizeof target) : -1;
    if (n < 0)
        return out->descriptor >= 0 || errno == EINVAL || errno == ENOENT;
    if (n == sizeof target) {
        errno = ENAMETOOLONG;
        return false;
    }
    target[n] = 0;
    *link = true;
    if (target[0] != '/')
        return join(out->folder, target, at);
    memcpy(at, target, (size_t)n + 1);
    return true;
}

bool ng_file_place_try(const char *path, struct ng_file_place *out)
{
    char at[PATH_MAX];
    bool link = true;
    errno = ENAMETOOLONG;
    if (snprintf(at, sizeof at, "%s", path) >= (int)sizeof at)
        return false;
    for (int links = 0; link && links <= MOST_LINKS; links++)
        if (!step(at, out, &link))
            return false;
    if (link) {
        errno = ELOOP;
        return false;
    }
    int status = out->descriptor >= 0 ? fstat(out->descriptor, &out->status) : stat(out->path, &out->status);
    out->exists = status == 0;
    return out->exists || (errno == ENOENT && out->descriptor < 0);
}

ng_result ng_file_place_find(const char *path, struct ng_file_place *out)
{
    return ng_file_place_try(path, out) ? NG_OK : ng_file_error("write", path);
}

// In a folder like /tmp a file can be replaced by its owner alone.
static bool is_stuck(const struct ng_file_place *place)
{
    struct stat folder;
    uid_t user = geteuid();
    return user != 0 && place->exists && stat(place->folder, &folder) == 0 && folder.st_mode & S_ISVTX &&
           folder.st_uid != user && place->status.st_uid != user;
}

ng_result ng_file_place_check(const char *path, const struct ng_file_place *place)
{
    mode_t mode = place->exists ? place->status.st_mode : 0;
    if (place->descriptor >= 0)
        return NG_OK;
    if (S_ISDIR(mode)) {
        errno = EISDIR;
        return ng_file_error("write", path);
    }
    // Asked of the bits, as root may write to all files.
    if (S_ISREG(mode) && !(mode & (S_IWUSR | S_IWGRP | S_IWOTH))) {
        ng_log_error("%s: is read-only; make it writable, or choose another name", path);
        return NG_ERROR_IO;
    }
    if (place->exists && faccessat(AT_FDCWD, place->path, W_OK, AT_EACCESS) != 0)
        return ng_file_error("write", path);
    if (place->exists && !S_ISREG(mode))
        return NG_OK;
    if (faccessat(AT_FDCWD, place->folder, W_OK | X_OK, AT_EACCESS) != 0)
        return ng_file_error("write to its folder", path);
    if (is_stuck(place)) {
        errno = EPERM;
        return ng_file_error("replace another user's file in this folder", path);
    }
    return NG_OK;
}

ng_result ng_file_check_writable(const char *path)
{
    struct ng_file_place place;
    NG_TRY(ng_file_place_find(path, &place));
    return ng_file_place_check(path, &place);
}

bool ng_file_identify(const char *path, struct ng_file_id *out)
{
    struct ng_file_place place;
    struct stat folder;
    if (!ng_file_place_try(path, &place))
        return false;
    if (place.exists) {
        *out = (struct ng_file_id){.device = place.status.st_dev, .number = place.status.st_ino};
        return S_ISREG(place.status.st_mode) || S_ISDIR(place.status.st_mode);
    }
    if (stat(place.folder, &folder) != 0)
        return false;
    *out = (struct ng_file_id){
        .device = folder.st_dev, .number = folder.st_ino, .name = ng_hash_string(ng_path_name(place.path))};
    return true;
}

bool ng_file_same(const char *a, const char *b)
{
    struct ng_file_id x, y;
    return ng_file_identify(a, &x) && ng_file_identify(b, &y) && x.device == y.device &&
           x.number == y.number && x.name == y.name;
}

bool ng_file_is_below(const char *path, const char *beside)
{
    char folder[PATH_MAX], real[PATH_MAX];
    if (!realpath(path, real))
        return true;
    if (!find_folder(beside, folder))
        return false;
    size_t n = strcmp(folder, "/") == 0 ? 0 : strlen(folder);
    return strncmp(real, folder, n) == 0 && real[n] == '/';
}

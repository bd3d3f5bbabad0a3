#define _GNU_SOURCE // sched_getaffinity
#include "base/system.h"

#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

static uint64_t clock_ns(clockid_t id)
{
    struct timespec t;
    clock_gettime(id, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

uint64_t ng_clock_ns(void)
{
    return clock_ns(CLOCK_MONOTONIC);
}

uint64_t ng_clock_cpu_ns(void)
{
    return clock_ns(CLOCK_PROCESS_CPUTIME_ID);
}

uint32_t ng_system_processors(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return (uint32_t)CPU_COUNT(&set);
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n > 0 ? (uint32_t)n : 1;
}

uint64_t ng_system_peak_memory(void)
{
    struct rusage u;
    if (getrusage(RUSAGE_SELF, &u) != 0)
        return 0;
    return (uint64_t)u.ru_maxrss * 1024u;
}

static FILE *open_below(const char *root, const char *path)
{
    char full[1024];
    int n = snprintf(full, sizeof full, "%s%s", root, path);
    return n > 0 && (size_t)n < sizeof full ? fopen(full, "re") : NULL;
}

// A file of the system that says "WORD NUMBER" in some line; UINT64_MAX if it does not.
static uint64_t read_word(const char *root, const char *path, const char *word)
{
    uint64_t found = UINT64_MAX;
    char line[256];
    FILE *file = open_below(root, path);
    while (file && found == UINT64_MAX && fgets(line, sizeof line, file))
        if (strncmp(line, word, strlen(word)) == 0 && strpbrk(line, "0123456789"))
            found = strtoull(line + strlen(word), NULL, 10);
    if (file)
        fclose(file);
    return found;
}

static uint64_t read_kilobytes(const char *root, const char *path, const char *word)
{
    uint64_t found = read_word(root, path, word);
    return found > UINT64_MAX / 1024 ? UINT64_MAX : found * 1024;
}

// The two versions of control groups: where they are, and how they say the same.
struct group_version {
    const char *mount, *limits[2], *used, *reclaimable;
};

static const struct group_version group_versions[] = {
    {"/sys/fs/cgroup/memory",
     {"memory.limit_in_bytes", NULL},
     "memory.usage_in_bytes",
     "total_inactive_file "},
    {"/sys/fs/cgroup", {"memory.max", "memory.high"}, "memory.current", "inactive_file "},
};

static uint64_t read_of_group(const char *root, const struct group_version *v, const char *group,
                              const char *file, const char *word)
{
    char path[1024];
    int n = snprintf(path, sizeof path, "%s%s/%s", v->mount, group, file);
    return n > 0 && (size_t)n < sizeof path ? read_word(root, path, word) : UINT64_MAX;
}

// What a group leaves. Files that are cached for it count as used, and make room when asked to.
static uint64_t left_in_group(const char *root, const struct group_version *v, const char *group)
{
    uint64_t limit = UINT64_MAX, used = read_of_group(root, v, group, v->used, "");
    uint64_t cached = read_of_group(root, v, group, "memory.stat", v->reclaimable);
    for (int i = 0; i < 2 && v->limits[i]; i++) {
        uint64_t one = read_of_group(root, v, group, v->limits[i], ""); // "max": none
        limit = one < limit ? one : limit;
    }
    if (limit == UINT64_MAX || used == UINT64_MAX)
        return UINT64_MAX;
    used -= cached < used ? cached : 0;
    return limit > used ? limit - used : 0;
}

// The least that a group and those around it leave. `group` is "/service/worker" and is shortened to "".
// Where a container sees its own groups alone, only the last exists.
static uint64_t left_in_groups(const char *root, const struct group_version *v, char *group)
{
    uint64_t least = UINT64_MAX;
    for (char *end = group + strlen(group); end; end = strrchr(group, '/')) {
        *end = 0;
        uint64_t left = left_in_group(root, v, group);
        least = left < least ? left : least;
    }
    return least;
}

// Lines "NUMBER:CONTROLLERS:GROUP"; version 2 names no controllers.
static uint64_t left_by_groups(const char *root)
{
    uint64_t least = UINT64_MAX;
    char line[1024];
    FILE *file = open_below(root, "/proc/self/cgroup");
    while (file && fgets(line, sizeof line, file)) {
        char *controllers = strchr(line, ':'), *group = controllers ? strchr(controllers + 1, ':') : NULL;
        if (!group)
            continue;
        *group++ = 0;
        group[strcspn(group, "\n")] = 0;
        bool second = controllers[1] == 0;
        if (!second && !strstr(controllers, "memory"))
            continue;
        uint64_t left = left_in_groups(root, &group_versions[second], group);
        least = left < least ? left : least;
    }
    if (file)
        fclose(file);
    return least;
}

static uint64_t left_of_address_space(const char *root)
{
    uint64_t taken = read_kilobytes(root, "/proc/self/status", "VmSize:");
    struct rlimit limit;
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || taken == UINT64_MAX)
        return UINT64_MAX;
    return limit.rlim_cur > taken ? limit.rlim_cur - taken : 0;
}

uint64_t ng_system_available_memory_below(const char *root)
{
    const uint64_t all[] = {read_kilobytes(root, "/proc/meminfo", "MemAvailable:"), left_by_groups(root),
                            left_of_address_space(root)};
    uint64_t least = UINT64_MAX;
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        least = all[i] < least ? all[i] : least;
    return least;
}

uint64_t ng_system_available_memory(void)
{
    return ng_system_available_memory_below("");
}

bool ng_system_stderr_is_terminal(void)
{
    return isatty(STDERR_FILENO) == 1;
}

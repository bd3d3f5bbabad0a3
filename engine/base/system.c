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

// A file of the system that says "WORD NUMBER kB" somewhere; UINT64_MAX if it does not.
static uint64_t read_kilobytes(const char *path, const char *word)
{
    uint64_t found = UINT64_MAX;
    char line[256];
    FILE *file = fopen(path, "re");
    while (file && found == UINT64_MAX && fgets(line, sizeof line, file))
        if (strncmp(line, word, strlen(word)) == 0)
            found = strtoull(line + strlen(word), NULL, 10) * 1024u;
    if (file)
        fclose(file);
    return found;
}

uint64_t ng_system_available_memory(void)
{
    uint64_t available = read_kilobytes("/proc/meminfo", "MemAvailable:");
    uint64_t taken = read_kilobytes("/proc/self/status", "VmSize:");
    struct rlimit limit;
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || taken == UINT64_MAX)
        return available;
    uint64_t left = limit.rlim_cur > taken ? limit.rlim_cur - taken : 0;
    return left < available ? left : available;
}

bool ng_system_stderr_is_terminal(void)
{
    return isatty(STDERR_FILENO) == 1;
}

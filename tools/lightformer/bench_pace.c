#include "bench_pace.h"

#include "base/system.h"

void bench_pace_begin(struct bench_pace *pace, const char *label, uint32_t most, double seconds)
{
    *pace = (struct bench_pace){.most = most, .seconds = seconds, .begun_ns = ng_clock_ns()};
    progress_begin(&pace->progress, label, most);
}

bool bench_pace_next(struct bench_pace *pace, uint32_t done)
{
    double elapsed = (double)(ng_clock_ns() - pace->begun_ns) * 1e-9;
    bool in_time = !done || elapsed * (done + 1) <= pace->seconds * done;
    pace->done = done;
    if (done < pace->most && in_time) {
        progress_update(&pace->progress, done);
        return true;
    }
    progress_end(&pace->progress);
    return false;
}

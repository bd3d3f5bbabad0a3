// Workers sleep on a condition variable, wake for a range, and take chunks from an atomic counter until none
// are left. No queue, no stealing: a frame is a sequence of wide loops, and this is all that they need.
#include "base/jobs.h"
#include "base/log.h"
#include "base/system.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

#define MAX_THREADS 256u

struct worker {
    struct ng_jobs *jobs;
    uint32_t index;
    pthread_t thread;
};

struct ng_jobs {
    pthread_mutex_t caller_lock; // one loop at a time
    pthread_mutex_t lock;
    pthread_cond_t wake, done;
    uint32_t threads; // workers, the caller counted
    uint32_t started; // threads that exist
    uint64_t round;   // counts loops, so that a sleeping worker knows a new one
    uint32_t busy;    // workers still inside the current loop
    bool quit;

    ng_jobs_fn fn;
    void *user;
    uint32_t count, grain;
    atomic_uint_fast64_t next; // 64 bits: the last additions pass `count` and must not wrap
    struct worker workers[];
};

static _Thread_local bool inside_job;

static void work(struct ng_jobs *j, uint32_t worker)
{
    inside_job = true;
    for (;;) {
        uint64_t begin = atomic_fetch_add_explicit(&j->next, j->grain, memory_order_relaxed);
        if (begin >= j->count)
            break;
        uint64_t end = begin + j->grain;
        j->fn(j->user, (uint32_t)begin, end < j->count ? (uint32_t)end : j->count, worker);
    }
    inside_job = false;
}

static void *worker_main(void *arg)
{
    struct worker *w = arg;
    struct ng_jobs *j = w->jobs;
    uint64_t seen = 0;
    pthread_mutex_lock(&j->lock);
    for (;;) {
        while (!j->quit && j->round == seen)
            pthread_cond_wait(&j->wake, &j->lock);
        if (j->quit)
            break;
        seen = j->round;
        pthread_mutex_unlock(&j->lock);
        work(j, w->index);
        pthread_mutex_lock(&j->lock);
        if (--j->busy == 0)
            pthread_cond_signal(&j->done);
    }
    pthread_mutex_unlock(&j->lock);
    return NULL;
}

// One a processor, unless there are more of them than threads can be.
static uint32_t choose_threads(void)
{
    uint32_t processors = ng_system_processors();
    return processors < MAX_THREADS ? processors : MAX_THREADS;
}

ng_result ng_jobs_create(const struct ng_jobs_params *params, struct ng_jobs **out)
{
    uint32_t threads = params && params->threads ? params->threads : choose_threads();
    NG_REQUIRE(threads <= MAX_THREADS, "at most %u threads", MAX_THREADS);
    struct ng_jobs *j = calloc(1, sizeof *j + threads * sizeof j->workers[0]);
    if (!j)
        return ng_out_of_memory("a set of worker threads");
    pthread_mutex_init(&j->caller_lock, NULL);
    pthread_mutex_init(&j->lock, NULL);
    pthread_cond_init(&j->wake, NULL);
    pthread_cond_init(&j->done, NULL);
    j->threads = threads;
    for (uint32_t i = 1; i < threads; i++) {
        j->workers[i] = (struct worker){.jobs = j, .index = i};
        if (pthread_create(&j->workers[i].thread, NULL, worker_main, &j->workers[i]) != 0) {
            ng_log_error("jobs: the system refused thread %u of %u; use fewer threads", i, threads);
            ng_jobs_destroy(&j);
            return NG_ERROR_MEMORY;
        }
        j->started++;
    }
    *out = j;
    return NG_OK;
}

void ng_jobs_destroy(struct ng_jobs **jobs)
{
    struct ng_jobs *j = *jobs;
    if (!j)
        return;
    pthread_mutex_lock(&j->lock);
    j->quit = true;
    pthread_cond_broadcast(&j->wake);
    pthread_mutex_unlock(&j->lock);
    for (uint32_t i = 1; i <= j->started; i++)
        pthread_join(j->workers[i].thread, NULL);
    pthread_cond_destroy(&j->wake);
    pthread_cond_destroy(&j->done);
    pthread_mutex_destroy(&j->lock);
    pthread_mutex_destroy(&j->caller_lock);
    free(j);
    *jobs = NULL;
}

uint32_t ng_jobs_threads(const struct ng_jobs *jobs)
{
    return jobs ? jobs->threads : 1;
}

void ng_jobs_for(struct ng_jobs *j, uint32_t count, uint32_t grain, ng_jobs_fn fn, void *user)
{
    if (count == 0)
        return;
    if (grain == 0)
        grain = 1;
    if (!j || j->threads == 1 || inside_job || count <= grain) {
        for (uint64_t begin = 0; begin < count; begin += grain)
            fn(user, (uint32_t)begin, begin + grain < count ? (uint32_t)(begin + grain) : count, 0);
        return;
    }
    pthread_mutex_lock(&j->caller_lock);
    pthread_mutex_lock(&j->lock);
    j->fn = fn;
    j->user = user;
    j->count = count;
    j->grain = grain;
    atomic_store_explicit(&j->next, 0, memory_order_relaxed);
    j->busy = j->threads - 1;
    j->round++;
    pthread_cond_broadcast(&j->wake);
    pthread_mutex_unlock(&j->lock);

    work(j, 0);

    pthread_mutex_lock(&j->lock);
    while (j->busy)
        pthread_cond_wait(&j->done, &j->lock);
    pthread_mutex_unlock(&j->lock);
    pthread_mutex_unlock(&j->caller_lock);
}

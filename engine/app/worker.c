#include "app/worker.h"

#include "base/log.h"

#include <pthread.h>
#include <stdlib.h>

struct ng_worker {
    struct ng_worker_params params;
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t wake;
    bool busy, quit;
};

static void *run(void *user)
{
    struct ng_worker *w = user;
    pthread_mutex_lock(&w->lock);
    for (;;) {
        while (!w->busy && !w->quit)
            pthread_cond_wait(&w->wake, &w->lock);
        if (!w->busy)
            break;
        pthread_mutex_unlock(&w->lock);
        w->params.work(w->params.user);
        pthread_mutex_lock(&w->lock);
        w->busy = false;
        pthread_mutex_unlock(&w->lock);
        if (w->params.done)
            w->params.done(w->params.user);
        pthread_mutex_lock(&w->lock);
    }
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

ng_result ng_worker_create(const struct ng_worker_params *params, struct ng_worker **out)
{
    struct ng_worker *w = calloc(1, sizeof *w);
    *out = NULL;
    if (!w)
        return ng_out_of_memory("a worker thread");
    w->params = *params;
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->wake, NULL);
    if (pthread_create(&w->thread, NULL, run, w) != 0) {
        pthread_cond_destroy(&w->wake);
        pthread_mutex_destroy(&w->lock);
        free(w);
        return ng_out_of_memory("a worker thread");
    }
    *out = w;
    return NG_OK;
}

void ng_worker_destroy(struct ng_worker **worker)
{
    struct ng_worker *w = *worker;
    *worker = NULL;
    if (!w)
        return;
    pthread_mutex_lock(&w->lock);
    w->quit = true;
    pthread_cond_signal(&w->wake);
    pthread_mutex_unlock(&w->lock);
    pthread_join(w->thread, NULL);
    pthread_cond_destroy(&w->wake);
    pthread_mutex_destroy(&w->lock);
    free(w);
}

void ng_worker_begin(struct ng_worker *w)
{
    pthread_mutex_lock(&w->lock);
    w->busy = true;
    pthread_cond_signal(&w->wake);
    pthread_mutex_unlock(&w->lock);
}

bool ng_worker_is_busy(struct ng_worker *w)
{
    pthread_mutex_lock(&w->lock);
    bool busy = w->busy;
    pthread_mutex_unlock(&w->lock);
    return busy;
}

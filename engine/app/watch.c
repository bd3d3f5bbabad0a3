// Looks at files by stat: what is watched may lie anywhere, on network drives, too.
#define _POSIX_C_SOURCE 200809L // clock_gettime, st_mtim
#include "app/watch.h"

#include "base/array.h"
#include "base/log.h"

#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#define PERIOD_NS 200000000L // between two looks
#define PATIENCE  5          // looks for which a file that is gone may be about to come back

// What of a file tells that it is another.
struct look {
    bool there;
    dev_t device;
    ino_t number;
    off_t size;
    struct timespec written;
};

struct watched {
    char *path;
    struct look known, last; // when it was said last; a period ago
    uint32_t gone;           // looks since it was there
};

struct ng_watch {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t wake;
    bool quit, changed;
    NG_ARRAY(struct watched) files;
};

static struct look look_at(const char *path)
{
    struct stat s;
    if (stat(path, &s) != 0)
        return (struct look){0};
    return (struct look){true, s.st_dev, s.st_ino, s.st_size, s.st_mtim};
}

static bool same(const struct look *a, const struct look *b)
{
    return a->there == b->there && a->device == b->device && a->number == b->number && a->size == b->size &&
           a->written.tv_sec == b->written.tv_sec && a->written.tv_nsec == b->written.tv_nsec;
}

// All are at rest, and one of them is not what it was.
static void look(struct ng_watch *w)
{
    bool rests = true, other = false;
    for (size_t i = 0; i < w->files.count; i++) {
        struct watched *f = &w->files.items[i];
        struct look now = look_at(f->path);
        f->gone = now.there ? 0 : f->gone + 1;
        bool replaced = f->known.there && f->gone && f->gone <= PATIENCE;
        rests = rests && same(&now, &f->last) && !replaced;
        other = other || !same(&now, &f->known);
        f->last = now;
    }
    if (!rests || !other)
        return;
    for (size_t i = 0; i < w->files.count; i++)
        w->files.items[i].known = w->files.items[i].last;
    w->changed = true;
}

static void *run(void *user)
{
    struct ng_watch *w = user;
    pthread_mutex_lock(&w->lock);
    while (!w->quit) {
        struct timespec until;
        look(w);
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += PERIOD_NS;
        until.tv_sec += until.tv_nsec / 1000000000L;
        until.tv_nsec %= 1000000000L;
        pthread_cond_timedwait(&w->wake, &w->lock, &until);
    }
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

ng_result ng_watch_create(struct ng_watch **out)
{
    struct ng_watch *w = calloc(1, sizeof *w);
    *out = NULL;
    if (!w)
        return ng_out_of_memory("the watch on files");
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->wake, NULL);
    if (pthread_create(&w->thread, NULL, run, w) != 0) {
        pthread_cond_destroy(&w->wake);
        pthread_mutex_destroy(&w->lock);
        free(w);
        return ng_out_of_memory("the watch on files");
    }
    *out = w;
    return NG_OK;
}

void ng_watch_destroy(struct ng_watch **watch)
{
    struct ng_watch *w = *watch;
    *watch = NULL;
    if (!w)
        return;
    pthread_mutex_lock(&w->lock);
    w->quit = true;
    pthread_cond_signal(&w->wake);
    pthread_mutex_unlock(&w->lock);
    pthread_join(w->thread, NULL);
    ng_watch_clear(w);
    ng_array_finish(&w->files);
    pthread_cond_destroy(&w->wake);
    pthread_mutex_destroy(&w->lock);
    free(w);
}

bool ng_watch_add(struct ng_watch *w, const char *path)
{
    size_t size = strlen(path) + 1;
    struct watched file = {.path = malloc(size)};
    if (!file.path)
        return false;
    memcpy(file.path, path, size);
    file.known = file.last = look_at(path);
    pthread_mutex_lock(&w->lock);
    bool added = ng_array_push(&w->files, file);
    pthread_mutex_unlock(&w->lock);
    if (!added)
        free(file.path);
    return added;
}

void ng_watch_clear(struct ng_watch *w)
{
    pthread_mutex_lock(&w->lock);
    for (size_t i = 0; i < w->files.count; i++)
        free(w->files.items[i].path);
    w->files.count = 0;
    w->changed = false;
    pthread_mutex_unlock(&w->lock);
}

bool ng_watch_changed(struct ng_watch *w)
{
    pthread_mutex_lock(&w->lock);
    bool changed = w->changed;
    w->changed = false;
    pthread_mutex_unlock(&w->lock);
    return changed;
}

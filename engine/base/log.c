// One mutex around one sink: messages are rare, so nothing cleverer pays.
#include "base/log.h"
#include "base/printable.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static void default_sink(void *user, enum ng_log_level level, const char *text)
{
    static const char *const prefix[] = {"debug: ", "", "warning: ", "error: "};
    NG_UNUSED(user);
    if (level == NG_LOG_DEBUG && !getenv("NG_DEBUG"))
        return;
    fprintf(stderr, "%s%s\n", prefix[level], text);
}

static pthread_mutex_t sink_lock = PTHREAD_MUTEX_INITIALIZER;
static ng_log_fn sink_fn = default_sink;
static void *sink_user;

void ng_log_set_sink(ng_log_fn fn, void *user)
{
    pthread_mutex_lock(&sink_lock);
    sink_fn = fn ? fn : default_sink;
    sink_user = fn ? user : NULL;
    pthread_mutex_unlock(&sink_lock);
}

static _Thread_local struct ng_log_catch *innermost;

void ng_log_catch_begin(struct ng_log_catch *scope)
{
    *scope = (struct ng_log_catch){.outer = innermost};
    innermost = scope;
}

void ng_log_catch_end(struct ng_log_catch *scope)
{
    innermost = scope->outer;
}

static void log_va(enum ng_log_level level, const char *fmt, va_list args)
{
    char text[2048];
    vsnprintf(text, sizeof text, fmt, args);
    ng_make_printable(text); // names from files may hold anything
    if (level == NG_LOG_ERROR && innermost) {
        if (!innermost->kind)
            snprintf(innermost->text, sizeof innermost->text, "%.*s", (int)sizeof innermost->text - 1, text);
        innermost->kind = innermost->kind ? innermost->kind : fmt;
        return;
    }
    pthread_mutex_lock(&sink_lock);
    sink_fn(sink_user, level, text);
    pthread_mutex_unlock(&sink_lock);
}

void ng_log(enum ng_log_level level, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    log_va(level, fmt, args);
    va_end(args);
}

void ng_require_failed_(const char *file, int line, const char *func, const char *fmt, ...)
{
    char rule[1024];
    va_list args;
    va_start(args, fmt);
    vsnprintf(rule, sizeof rule, fmt, args);
    va_end(args);
    ng_log_error("%s: %s (%s:%d)", func, rule, file, line);
}

const char *ng_result_text(ng_result r)
{
    switch (r) {
    case NG_OK:
        return "done";
    case NG_ERROR_USAGE:
        return "wrong use of the interface";
    case NG_ERROR_MEMORY:
        return "out of memory";
    case NG_ERROR_IO:
        return "file could not be read or written";
    case NG_ERROR_FORMAT:
        return "malformed content";
    case NG_ERROR_UNSUPPORTED:
        return "not supported";
    case NG_ERROR_NOT_FOUND:
        return "not found";
    case NG_ERROR_DEVICE:
        return "graphics device failed";
    case NG_ABANDONED:
        return "abandoned";
    }
    return "unknown result";
}

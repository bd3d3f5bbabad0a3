// The log: one line a message, to a sink that the application may replace. Thread-safe.
//
// Errors are logged once, where they are detected; callers pass the result on without a second message.
#ifndef NG_BASE_LOG_H
#define NG_BASE_LOG_H

#include "base/extern_c.h"
#include "base/result.h"

NG_EXTERN_C_BEGIN

enum ng_log_level { NG_LOG_DEBUG, NG_LOG_INFO, NG_LOG_WARN, NG_LOG_ERROR };

// `text` is one message without a newline, valid during the call. Calls never overlap.
typedef void (*ng_log_fn)(void *user, enum ng_log_level level, const char *text);

// Replaces the sink; a null `fn` restores the default, which writes "error: text" and "warning: text" to
// standard error (debug lines only where the environment has NG_DEBUG).
void ng_log_set_sink(ng_log_fn fn, void *user);

void ng_log(enum ng_log_level level, const char *fmt, ...) NG_PRINTF(2, 3);
#define ng_log_debug(...) ng_log(NG_LOG_DEBUG, __VA_ARGS__)
#define ng_log_info(...)  ng_log(NG_LOG_INFO, __VA_ARGS__)
#define ng_log_warn(...)  ng_log(NG_LOG_WARN, __VA_ARGS__)
#define ng_log_error(...) ng_log(NG_LOG_ERROR, __VA_ARGS__)

// Catches what this thread would log as errors: for whoever can do without a part of something, and says so
// in another way. Scopes may be nested; the innermost catches. Of several messages the first is kept.
struct ng_log_catch {
    char text[1024];  // "" if nothing was caught
    const void *kind; // the same for messages that were made with one format
    struct ng_log_catch *outer;
};
void ng_log_catch_begin(struct ng_log_catch *scope);
void ng_log_catch_end(struct ng_log_catch *scope);

// Logs "out of memory: WHAT", what the memory was for or the file it was for, and gives NG_ERROR_MEMORY.
// Inline, so that static analysis sees that it never gives NG_OK.
static inline ng_result ng_out_of_memory(const char *what)
{
    ng_log_error("out of memory: %s", what);
    return NG_ERROR_MEMORY;
}

NG_EXTERN_C_END

#endif

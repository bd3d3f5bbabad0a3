// What every test needs: cmocka with its includes in the right order, a scratch directory, a captured log.
#ifndef NG_TESTS_TEST_H
#define NG_TESTS_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A path in this test's own scratch directory, which CTest names in NG_TEST_DIR.
static inline void test_path(char *out, size_t size, const char *name)
{
    const char *dir = getenv("NG_TEST_DIR");
    assert_true((size_t)snprintf(out, size, "%s/%s", dir ? dir : "/tmp", name) < size);
}

// Captures the log between begin and end: the messages, one a line, and how many there were of each kind.
struct test_log {
    char text[8192];
    int errors, warnings;
};

static inline void test_log_sink(void *user, enum ng_log_level level, const char *text)
{
    struct test_log *log = user;
    size_t n = strlen(log->text);
    if (level >= NG_LOG_WARN)
        snprintf(log->text + n, sizeof log->text - n, "%s\n", text);
    log->errors += level == NG_LOG_ERROR;
    log->warnings += level == NG_LOG_WARN;
}

static inline void test_log_begin(struct test_log *log)
{
    *log = (struct test_log){0};
    ng_log_set_sink(test_log_sink, log);
}

static inline void test_log_end(struct test_log *log)
{
    NG_UNUSED(log);
    ng_log_set_sink(NULL, NULL);
}

#endif

// What a function that can fail returns, and how the three kinds of failure are treated.
//
//   the caller's bug      NG_REQUIRE: logs the broken rule and its place, fails the call
//   our own bug           assert
//   the world's fault     (file, format, memory, driver) logged once, where it is detected, with the name of
//                         the thing, the reason and what to do; then returned up as an ng_result
//
// A library never exits the process, and there is no global "last error": read the log sink (base/log.h).
#ifndef NG_BASE_RESULT_H
#define NG_BASE_RESULT_H

#include "base/extern_c.h"

NG_EXTERN_C_BEGIN

enum ng_result {
    NG_OK = 0,
    NG_ERROR_USAGE,       // a rule of the interface was broken by the caller
    NG_ERROR_MEMORY,      // out of host or device memory, or over a stated limit
    NG_ERROR_IO,          // a file could not be opened, read or written
    NG_ERROR_FORMAT,      // a file's content breaks its format
    NG_ERROR_UNSUPPORTED, // valid, but not something this program handles
    NG_ERROR_NOT_FOUND,   // a name or id that nothing answers to
    NG_ERROR_DEVICE,      // no driver, device lost, or the driver refused
    NG_ABANDONED,         // the caller asked to give it up; nothing is wrong, and nothing is logged
};
typedef enum ng_result ng_result;

#define NG_NODISCARD    __attribute__((warn_unused_result))
#define NG_PRINTF(f, a) __attribute__((format(printf, f, a)))
#define NG_UNUSED(x)    ((void)(x))
#define NG_COUNT(a)     (sizeof(a) / sizeof((a)[0]))

// A short English phrase for a result: "out of memory".
const char *ng_result_text(ng_result r);

// Returns from the calling function when `expr` fails.
#define NG_TRY(expr)                                                                                         \
    do {                                                                                                     \
        ng_result ng_try_result_ = (expr);                                                                   \
        if (ng_try_result_ != NG_OK)                                                                         \
            return ng_try_result_;                                                                           \
    } while (0)

// Checks a rule of the interface that the caller must keep; the message states the rule, printf style.
#define NG_REQUIRE(cond, ...) NG_REQUIRE_OR(cond, NG_ERROR_USAGE, __VA_ARGS__)
#define NG_REQUIRE_OR(cond, value, ...)                                                                      \
    do {                                                                                                     \
        if (!(cond)) {                                                                                       \
            ng_require_failed_(__FILE__, __LINE__, __func__, __VA_ARGS__);                                   \
            return value;                                                                                    \
        }                                                                                                    \
    } while (0)

void ng_require_failed_(const char *file, int line, const char *func, const char *fmt, ...) NG_PRINTF(4, 5);

NG_EXTERN_C_END

#endif

// A fuzz target: a function that libFuzzer calls with bytes (preset fuzz). Other builds link run_files.c, a
// main that calls it with each of the files given, so that every build tries what once found a fault.
#ifndef NG_TESTS_TARGET_H
#define NG_TESTS_TARGET_H

#include "base/result.h"

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

// Writes bytes as a file of a folder that this process has for itself, and gives its path, which is valid
// until the process ends. For readers that take no bytes.
const char *target_file(const char *name, const void *data, size_t size);
// Removes it, if it is there.
void target_remove(const char *name);

// Around each call that reads: what it logs is counted, then judged. A failure is one error that says
// something, a success none; a wrong judgement aborts.
void target_begin(void);
void target_end(ng_result result);
// Instead: whatever was logged is fine.
void target_ignore(void);

#endif

// SPDX-License-Identifier: MIT
// duet source --check
#ifndef CLI_SOURCE_CHECK_H
#define CLI_SOURCE_CHECK_H

#include "runtime/opencl/program.h"

typedef struct source_check_def {
    const char *kernel; // NULL: all of them
    uint64_t most;      // configs a kernel; 0: all
    uint64_t seed;      // which, where there are more
    bool json;
} source_check_def;

// Compiles valid configs on the device. Each that fails is a line on stderr;
// BUILD_FAILED with their number where there were some, INTERRUPTED on Ctrl-C.
bool source_check(gen *g, const device *d, const source_check_def *def, duet_error *err);

#endif

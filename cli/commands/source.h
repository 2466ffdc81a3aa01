// SPDX-License-Identifier: MIT
// The parts of `duet source` that are about many configs of a kernel. only: one kernel; NULL: all.
#ifndef CLI_SOURCE_H
#define CLI_SOURCE_H

#include "gen/gen.h"
#include "runtime/opencl/device.h"

// Prints kernels, their parameters and how many configs are valid.
bool source_list(gen *g, const char *only, const gen_limits *limits, bool json, duet_error *err);

typedef struct source_sample {
    uint64_t most; // configs of a kernel; 0: all
    uint64_t seed; // chooses them
} source_sample;

// Compiles valid configs on the device. Each that fails is a line on stderr; BUILD_FAILED with
// their number if there were some, INTERRUPTED on Ctrl-C.
bool source_check(gen *g, const device *d, const char *only, const source_sample *sample, bool json,
                  duet_error *err);

#endif

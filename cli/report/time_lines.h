// SPDX-License-Identifier: MIT
// A picture of one step: when each device ran which kernels, and sent or fetched what.
#ifndef CLI_TIME_LINES_H
#define CLI_TIME_LINES_H

#include "runtime/duet.h"

typedef struct time_lines {
    const char *title;
    const duet_device_pair *pair;
    const duet_plan *plan;
    double total_ms;
    const duet_stage *stages;
    uint32_t n_stages;
} time_lines;

// Writes the picture as SVG (lua/timeline.lua); "-" is stdout.
bool time_lines_write(const time_lines *shown, const char *path, duet_error *err);

#endif

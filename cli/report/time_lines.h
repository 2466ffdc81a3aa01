// SPDX-License-Identifier: MIT
// A picture of one step: when each device ran which kernels, and sent or fetched what.
#ifndef CLI_TIME_LINES_H
#define CLI_TIME_LINES_H

#include "cli/timed.h"

// Writes the picture of a step by that plan as SVG (lua/timeline.lua); "-" is stdout, and NULL
// writes nothing.
bool time_lines_write(const char *path, const char *title, const duet_device_pair *pair,
                      const duet_plan *plan, const timed_step *step, duet_error *err);

#endif

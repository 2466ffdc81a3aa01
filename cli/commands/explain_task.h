// SPDX-License-Identifier: MIT
#ifndef CLI_EXPLAIN_TASK_H
#define CLI_EXPLAIN_TASK_H

#include "cli/inputs.h"

// Tells what the task file of that path asks of the devices, and what its kernel leaves to be
// chosen there. pair: selectors, or NULL.
bool explain_task(const char *path, const scene_options *scene, const char *pair, bool json,
                  duet_error *err);

#endif

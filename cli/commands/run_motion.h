// SPDX-License-Identifier: MIT
// duet run --steps: a scene that moves, step by step.
#ifndef CLI_RUN_MOTION_H
#define CLI_RUN_MOTION_H

#include "cli/inputs.h"

typedef struct run_motion_options {
    uint64_t steps;      // 0: the scene is not advanced
    const char *picture; // a PNG of the last step
    const char *frames;  // a folder for PNGs, 30 of a second of the scene
    bool json;
} run_motion_options;

// Advances the scene and tells what was done: energy and pairs as it goes, then
// the time of each effect. Ctrl-C ends it with what was done until then.
bool run_motion(const run_motion_options *options, const duet_scene *scene, duet_device_pair *pair,
                const plan_options *plan, duet_error *err);

#endif

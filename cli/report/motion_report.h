// SPDX-License-Identifier: MIT
// The report of `duet run --steps`, to a person or as JSON: a row for some of the steps, and what
// they took by effect. The first step builds kernels and makes space: times are of those after it.
#ifndef CLI_MOTION_REPORT_H
#define CLI_MOTION_REPORT_H

#include "base/text.h"
#include "runtime/duet.h"

#include <stdbool.h>
#include <stdint.h>

enum { MOTION_REPORT_STAGES = 32 };

typedef struct motion_report {
    const duet_scene_info *scene;
    duet_motion *motion;
    bool plan_given;         // on the command line
    duet_profile profile;    // gave the plan, unless it was given
    text tuning;             // the command that measures a plan for this scene
    duet_motion_result last; // the last step
    uint64_t done;           // steps
    double total_ms;
    double slowest_ms;
    uint64_t since_timed;  // steps
    uint64_t staged_steps; // up to the last one that was timed by stages
    uint64_t timed_steps;
    struct {
        char name[24];
        double ms;
    } stages[MOTION_REPORT_STAGES];
    uint32_t n_stages;
} motion_report;

// Counts a step, whose result is `last` from then on.
void motion_report_add(motion_report *r, const duet_motion_result *step);

// Prints the scene, its effects and its plan, then the names of the columns.
bool motion_report_begin(const motion_report *r, duet_error *err);
bool motion_report_row(const motion_report *r, duet_error *err);

// Prints where the time went and the hash; or all as one object.
bool motion_report_end(const motion_report *r, uint64_t hash, bool json, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// What `duet run` tells, to a person or as JSON.
#ifndef CLI_RUN_REPORT_H
#define CLI_RUN_REPORT_H

#include "cli/timed.h"

// How the pairs compare with the reference's.
typedef struct reference_check {
    bool asked;
    uint64_t reference; // pairs there should be
    uint64_t missing;
    uint64_t extra;
} reference_check;

bool reference_check_is_right(const reference_check *check);

typedef struct run_report {
    const duet_scene_info *scene;
    const duet_device_pair *pair;
    const duet_plan *plan;
    const char *level;    // of accuracy
    bool plan_given;      // on the command line
    bool accuracy_given;  // there, too: a profile may have chosen a level by it
    duet_profile profile; // what the plan comes from, unless it was given
    const char *tuning;   // the command that measures a plan for this scene
    const timed *timed;
    timed_input input;
    bool ordered; // objects were put into the order of their cells
    reference_check check;
} run_report;

// The scene, and how the pairs compare with the reference's: a line each, and as a field.
struct cJSON;
void run_report_scene(const duet_scene_info *info);
void run_report_check(const reference_check *check);
void run_report_add_check(struct cJSON *o, const reference_check *check);

// Which device does how much of the work by which kernels.
void run_report_devices(const duet_device_pair *pair, const duet_plan *plan);
void run_report_grids(const duet_plan *plan); // a line, if both devices have a share

void run_report_text(const run_report *r);
bool run_report_json(const run_report *r, duet_error *err);

#endif

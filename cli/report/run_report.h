// SPDX-License-Identifier: MIT
// `duet run` tells this, to a person or as JSON.
#ifndef CLI_RUN_REPORT_H
#define CLI_RUN_REPORT_H

#include "cli/commands/run.h"
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
    const arguments *args;
    const duet_scene_info *scene;
    const duet_device_pair *pair;
    duet_world *world;
    duet_profile profile; // the source of the plan, unless it was given
    text tuning;          // the command that measures a plan for this scene
    timed timed;
    timed_input input;
    reference_check check;
} run_report;

// Adds the scene's name, kind ("rotated boxes"), dims and objects; the devices and the plan; how
// the pairs compare with the reference's. cli/report/words.lua tells them.
struct cJSON;
void run_report_add_scene(struct cJSON *o, const duet_scene_info *info, uint64_t objects);
void run_report_add_plan(struct cJSON *o, const duet_device_pair *pair, const duet_plan *plan);
void run_report_add_check(struct cJSON *o, const reference_check *check);

bool run_report_tell(const run_report *r, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// Which effects a scene calls for, and what each costs.
//
// An effect's time is what a step takes more than one of the same scene with
// what calls for it taken away; the two step in turn.
#ifndef CLI_COSTS_H
#define CLI_COSTS_H

#include "cli/report/json.h"
#include "runtime/duet.h"

enum { COSTS_MOST = 32 };

typedef struct cost {
    duet_effect_info info;
    bool measured; // false too where other effects call for this one as well
    double ms;     // a step; noise can take it below 0
} cost;

typedef struct costs {
    cost rows[COSTS_MOST]; // in the order of duet_motion_explain
    uint32_t n;
    duet_substep_info substeps; // 0 of them: no effect is active
    uint64_t steps;             // of each run; 0: nothing was measured
    double step_ms;             // with all effects
    core_tally cores;           // what other programs did meanwhile
} costs;

// steps 0 tells the effects and measures nothing.
bool costs_measure(costs *c, const duet_motion_def *def, const duet_scene *scene, uint64_t steps,
                   duet_error *err);

cJSON *costs_report_json(const costs *c, const duet_scene_info *scene,
                         const duet_device_pair *pair);

#define COSTS_TYPE "duet explain"

// BAD_INPUT if an object that is called that is none of ours, with costs.
bool costs_report_check(const cJSON *o, const char *path, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// One of the runs that `duet verify` compares: a scene's motion on its device pair, by its plan,
// with the recorded commands.
#ifndef CLI_VERIFIED_RUN_H
#define CLI_VERIFIED_RUN_H

#include "base/text.h"
#include "cli/inputs.h"
#include "runtime/commands/replay.h"

typedef struct verified_run {
    uint64_t ranks; // of a job that makes its steps (verified_jobs.h); 0: none, the motion does
    const char *selectors; // in the form of --pair; NULL: the default pair
    plan_options plan;
    const char *path; // a recording; NULL: no commands
    duet_device_pair *pair;
    duet_motion *motion;
    duet_replay *replay;
    duet_motion_result last;
    bool commanded;        // commands came since the last step
    duet_error unlike;     // the recording's hash differs at its end
    duet_error not_finite; // the state's, when its hash was asked for last
    uint64_t hash;
    text kept; // the state that was kept last, and where its replay was then
    replay_place kept_place;
} verified_run;

// Makes the motion and reads the recording; selectors, plan and path are given.
bool verified_run_open(verified_run *r, const duet_scene *scene, duet_error *err);
void verified_run_close(verified_run *r);

// The commands that come before the next step, then that step.
bool verified_run_command(verified_run *r, duet_error *err);
bool verified_run_step(verified_run *r, duet_error *err);

// Keeps the state, in the place of an earlier one, and goes back to it.
bool verified_run_keep(verified_run *r, duet_error *err);
bool verified_run_return(verified_run *r, duet_error *err);

// Fills hash, or not_finite.
bool verified_run_sum(verified_run *r, duet_error *err);

// Adds "pocl:0[0],pocl:0[1] (share 0.5, slab)", or the selector of a device that does all, or
// "3 ranks".
void verified_run_tell(const verified_run *r, text *to);

#endif

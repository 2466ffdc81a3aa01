// SPDX-License-Identifier: MIT
// The command line of `duet cluster`, which the program duet checks before any rank begins and
// each rank reads again.
#ifndef CLI_COMMANDS_CLUSTER_H
#define CLI_COMMANDS_CLUSTER_H

#include "cli/inputs.h"
#include "cli/mpirun.h"

typedef struct cluster_arguments {
    scene_options scene;
    plan_options plan;
    const char *level;
    const char *pair;
    const char *weights; // NULL: all ranks are alike
    const char *hosts;   // to start ranks on; NULL: this machine
    const char *pairs_path;
    const char *checkpoint, *resume; // files of a motion
    const char *replay;              // recorded commands; NULL: none
    const char *picture;             // a file; NULL: none
    const char *frames;              // a folder; NULL: none
    const char *format;              // that frames have
    const char *simulate;            // a platform; NULL: ranks are real
    const char *profile;             // gives the times of simulated ranks; NULL: they find pairs
    uint64_t stands_for;             // objects that each object stands for
    uint64_t parts;                  // that each rank's objects are searched in
    uint64_t ranks;                  // to start; 0: this is one of those that there are
    uint64_t repeat;
    uint64_t steps; // 0: nothing moves
    uint64_t every; // steps from one checkpoint to the next; 0: one at the end
    bool plain;
    bool resident;
    bool sorted;
    bool tune_colours;
    bool phases;
    bool check;
    bool verbose;
    bool json;
} cluster_arguments;

#define CLUSTER_ARGUMENTS_DEFAULT                                                              \
    {                                                                                          \
        .scene = SCENE_OPTIONS_DEFAULT, .plan = PLAN_OPTIONS_DEFAULT, .parts = 1, .repeat = 5, \
        .stands_for = 1,                                                                       \
    }

extern const command_line cluster_line;

// Which rank of an MPI job this process is, by what its launcher says; false for none.
bool cluster_job(unsigned long *rank, unsigned long *n_ranks);

// Refuses --ranks on a rank of an MPI job.
bool cluster_may_start(duet_error *err);

// Runs `ranks` ranks of the program duet-cluster, with these words behind it, NULL last, by
// mpirun_run: the job has all but argv.
bool cluster_run(mpirun_job *job, uint64_t ranks, char *const *words, int *status, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// Two runs that `duet verify` compares over ranks. Each is a job of `duet cluster`, which goes on
// from a checkpoint that both had and ends with one of its own: these have the same bytes at any
// number of ranks, so they differ if anything of the states does.
#ifndef CLI_VERIFIED_JOBS_H
#define CLI_VERIFIED_JOBS_H

#include "cli/verified_run.h"

typedef enum checkpoint { CK_FIRST, CK_OTHER, CK_KEPT, CK_FILES } checkpoint;

typedef struct verified_jobs {
    const char *scene; // as it was given, as are its options
    const scene_options *options;
    text folder, checkpoints[CK_FILES]; // and the files in it
    int status;                         // of a job that failed and has told why; EXIT_OK: none has
    struct {
        size_t at;
        double bytes[2]; // NAN: that one has ended
    } unlike;            // the first byte in which the checkpoints that were compared last differ
} verified_jobs;

// Makes the folder for a scene. Call verified_jobs_close whatever this returns.
bool verified_jobs_open(verified_jobs *j, const char *scene, const scene_options *options,
                        duet_error *err);
void verified_jobs_close(verified_jobs *j);

// Runs both from the step that was kept, or the scene's beginning (0), to another one, with the
// ranks, devices, plan and recording of each run. *differ: their states do. If a job fails, it has
// told why or err says it.
bool verified_jobs_go(verified_jobs *j, const verified_run runs[2], uint64_t kept, uint64_t step,
                      bool *differ, duet_error *err);

// Keeps the state that both reached.
bool verified_jobs_keep(const verified_jobs *j, duet_error *err);

// Loads the states that the jobs reached into the motions of the runs.
bool verified_jobs_load(const verified_jobs *j, verified_run runs[2], duet_error *err);

#endif

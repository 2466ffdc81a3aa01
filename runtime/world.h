// SPDX-License-Identifier: MIT
// A world's insides, for the files that make up its step.
#ifndef RUNTIME_WORLD_H
#define RUNTIME_WORLD_H

#include "runtime/device_pair.h"
#include "runtime/part.h"
#include "runtime/worker.h"

struct duet_world {
    duet_world_def def;
    part parts[2];      // A, B
    worker *worker;     // drives A while the caller's thread drives B
    host_block objects; // [n] poses or bounds
    uint32_t n;
    bool prepared[2]; // the part's kernels are those of the plan
    bool fitted;      // the grid is that of these objects
    uint32_t fitted_n;
    grid grid;
    bool cell_widened;
    duet_stage stages[2 * TIMELINE_STAGES]; // of the last step
};

#endif

// SPDX-License-Identifier: MIT
// The search of the parameters of each device's kernels.
#ifndef TUNER_KERNEL_TUNING_H
#define TUNER_KERNEL_TUNING_H

#include "tuner/tuning.h"

// Searches the kernels of B doing all the work, then the kernels of A doing as much as A does
// meanwhile. Kernels that are faster for sure enter the tuning's plan; told says of each device
// what was tried. Does nothing unless a search is asked for; NOT_FOUND if it is for a kernel that
// neither device runs.
bool kernel_tuning_run(tuning *t, duet_kernel_search told[2], duet_error *err);

// Whether a tuning with that option `search` varies the kernel.
bool kernel_tuning_is_meant(const char *what, const kernel_space *space);

#endif

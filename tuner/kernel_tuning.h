// SPDX-License-Identifier: MIT
// The search of the parameters of each device's kernels.
#ifndef TUNER_KERNEL_TUNING_H
#define TUNER_KERNEL_TUNING_H

#include "tuner/tuning.h"

// The kernels of B doing all the work, then of A doing as much as it does meanwhile.
// What is faster for sure enters the tuning's plan; told says of each device what was
// tried. Does nothing unless a search is asked for; NOT_FOUND where it is for a kernel
// that neither device runs.
bool kernel_tuning_run(tuning *t, duet_kernel_search told[2], duet_error *err);

#endif

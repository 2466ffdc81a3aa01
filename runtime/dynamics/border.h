// SPDX-License-Identifier: MIT
// What a domain's host looks at of its contacts (domain_border.c, kernels/dynamics/border.cl).
#ifndef RUNTIME_BORDER_H
#define RUNTIME_BORDER_H

#include "runtime/opencl/program.h"

// Rounds of colouring that a step is sent without a look at whether more would colour something.
typedef struct motion_border {
    kernel *mark_border, *choose_inner, *count_border, *list_border; // NULL until a domain asks
    kernel *used_colours;
    uint32_t rounds;
} motion_border;

#endif

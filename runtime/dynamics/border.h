// SPDX-License-Identifier: MIT
// Bodies and contacts of a domain that its host looks at (domain_border.c, domain_near.c,
// kernels/dynamics/border.cl), and those that its device solves for ghosts (domain_closure.c).
#ifndef RUNTIME_BORDER_H
#define RUNTIME_BORDER_H

#include <CL/cl.h>
#include <stdint.h>

typedef struct motion_border {
    uint32_t rounds; // of colouring, that a step is sent without a look at whether more would help
    // what a launch is told besides
    cl_uint n_extents, near_capacity, every, listed, n_border, closing_colour;
    cl_float far_time, far_margin;
} motion_border;

#endif

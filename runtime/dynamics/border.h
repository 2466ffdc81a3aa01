// SPDX-License-Identifier: MIT
// Bodies and contacts of a domain that its host looks at (domain_border.c, domain_near.c,
// kernels/dynamics/border.cl).
#ifndef RUNTIME_BORDER_H
#define RUNTIME_BORDER_H

#include "runtime/opencl/program.h"

typedef struct motion_border {
    // NULL until a domain asks
    kernel *mark_border, *choose_inner, *count_border, *list_border, *used_colours, *list_near,
        *list_meeting, *make_far_boxes, *keep_contacts;
    uint32_t rounds; // of colouring, that a step is sent without a look at whether more would help
    // what a launch is told besides
    cl_uint n_extents, near_capacity;
    cl_float far_time, far_margin;
} motion_border;

#endif

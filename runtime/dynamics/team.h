// SPDX-License-Identifier: MIT
// Launches whose groups go through stages together: on CPUs (kernels/dynamics/team.clh), or on GPUs
// that run all of them at once (kernels/dynamics/meet.clh).
#ifndef RUNTIME_TEAM_H
#define RUNTIME_TEAM_H

#include "runtime/dynamics/motion_kernels.h"

typedef struct motion_team {
    cl_uint stage; // the last one of all launches so far; 0: the words are not there yet
} motion_team;

struct duet_motion;

// Groups of a kernel that run at once: one on each unit of a CPU, or as many as a GPU's units have
// registers for.
uint32_t team_most_groups(const struct duet_motion *m, const kernel *k);

// Launches at most n_stages stages, by as many groups as have `least` of the work each.
bool team_launch(struct duet_motion *m, motion_kernel which, uint64_t work, uint32_t least,
                 uint32_t n_stages, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// Which kernels a motion runs, and with which parameters and arguments.
#ifndef RUNTIME_MOTION_KERNELS_H
#define RUNTIME_MOTION_KERNELS_H

#include "runtime/duet.h"
#include "runtime/opencl/program.h"

typedef enum motion_kernel {
#define KERNEL(which, entry, file, wanted, stage, work) which,
#include "runtime/dynamics/motion_kernels.inl"
    MOTION_KERNELS
} motion_kernel;

typedef struct motion_kernels {
    kernel *of[MOTION_KERNELS]; // NULL: not wanted, or not built yet
} motion_kernels;

// How long the records of kernels/dynamics/records.h are, in floats; bodies in vectors
// of four.
typedef struct motion_layout {
    uint32_t head, point, points, record;
    uint32_t body;
    uint32_t constraint, block; // a block is so many constraints
} motion_layout;

// Sends a kernel over its work, or over so much; one that is not wanted does nothing.
bool motion_launch(duet_motion *m, motion_kernel which, duet_error *err);
bool motion_launch_over(duet_motion *m, motion_kernel which, uint64_t work, duet_error *err);

// Builds a kernel that is built later, before it is launched. After a failure none of its file is
// there.
bool motion_build_ahead(duet_motion *m, motion_kernel which, duet_error *err);

// Fills offers for the kernels, and returns how many they are: what the scene says of their
// parameters, then what the plan does.
enum { MOTION_OFFERS = 48 };
uint32_t motion_offers(duet_motion *m, bool altered, gen_offer offers[MOTION_OFFERS]);

// Whether a kernel is there, and a team's.
bool motion_has_team(const duet_motion *m, motion_kernel which);

// Whether bodies may touch walls, or the ground, that never move.
bool motion_touches_walls(const duet_motion *m);
bool motion_touches_ground(const duet_motion *m);

// Whether contacts are told that closed fast.
bool motion_tells_hits(const duet_motion *m);

// Generates and builds what the effects need; again: for facts or a plan that have changed.
bool motion_prepare(duet_motion *m, duet_error *err);
bool motion_prepare_again(duet_motion *m, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// A motion of a scene as a machine that plans are measured on: a launch is a run from the scene's
// start, and is right if the state after its last step has the right bits.
#ifndef TUNER_MEASURE_MOTION_H
#define TUNER_MEASURE_MOTION_H

#include "runtime/broadphase/kernel_space.h"
#include "tuner/measure.h"

typedef struct measure_motion {
    duet_motion_def def;
    const duet_scene *scene;
    uint32_t steps;      // steps of each run
    duet_motion *motion; // the last run's motion, NULL if it could not begin; at first a motion
                         // that has not moved
    core_watch *cores;   // NULL: nobody looks at other programs
} measure_motion;

// Holds the pair; the scene must live as long. BAD_ARGUMENT for fewer than two steps: the first,
// which builds kernels and makes space, does not count. Closed also after a failure.
bool measure_motion_open(measure_motion *q, duet_device_pair *pair, const duet_scene *scene,
                         uint32_t steps, duet_error *err);
void measure_motion_close(measure_motion *q);

// A launch's times are those of a step in the mean of the run, as an application pays for it: most
// steps of a motion with a skin search no pairs, so that a median would leave the search out.
measure_machine measure_motion_machine(measure_motion *q, uint64_t hash);

// The state's hash after a run by the default plan.
bool measure_motion_right(measure_motion *q, uint64_t *hash, duet_error *err);

// Whether both devices have something to do: pairs are searched, by two devices.
bool measure_motion_is_shared(const measure_motion *q);

// Reads spaces as kernel_spaces_read does: B's kernels of the motion, and both devices' kernels
// that search pairs. Runs the motion unless its last run was by that plan.
bool measure_motion_kernels(measure_motion *q, const duet_plan *plan, int side,
                            kernel_space **spaces, uint32_t *n, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// Whether a box that moves along a straight line meets another one, decided on the host and
// never wrongly, and where it first touches it.
#ifndef RUNTIME_SWEEP_H
#define RUNTIME_SWEEP_H

#include "runtime/duet.h"

// Whether the closed boxes share a point for some 0 <= t <= t_max: in double with an error
// bound, then in exact integers. All is valid.
bool sweep_meets(const duet_sweep *sweep, const duet_pose *box, uint32_t dims);

// The same where the sweep lies `shift` further than it says, as between origin cells.
bool sweep_meets_apart(const duet_sweep *sweep, const duet_pose *box, const double shift[3],
                       uint32_t dims);

// By integers alone.
bool sweep_meets_exactly(const duet_sweep *sweep, const duet_pose *box, uint32_t dims);
bool sweep_meets_bounds(const duet_bounds_sweep *sweep, const duet_bounds *box, uint32_t dims);

// The least of these t, for boxes that meet, and the normal there, towards the one that moves;
// 0 where they share a point at t = 0.
float sweep_enter(const duet_sweep *sweep, const duet_pose *box, uint32_t dims, float normal[3]);
float sweep_enter_apart(const duet_sweep *sweep, const duet_pose *box, const double shift[3],
                        uint32_t dims, float normal[3]);
float sweep_enter_bounds(const duet_bounds_sweep *sweep, const duet_bounds *box, uint32_t dims,
                         float normal[3]);

#endif

// SPDX-License-Identifier: MIT
// Whether a rounded box that moves along a straight line meets another one, and where it first
// touches it: sweep.h with radii.
#ifndef RUNTIME_ROUNDED_SWEEP_H
#define RUNTIME_ROUNDED_SWEEP_H

#include "runtime/duet.h"

// Whether the two share a point for some 0 <= t <= t_max: in double with an error bound, then in
// exact integers. All is valid.
bool rounded_sweep_meets(const duet_rounded_sweep *sweep, const duet_rounded_box *box,
                         uint32_t dims);

// By integers alone.
bool rounded_sweep_meets_exactly(const duet_rounded_sweep *sweep, const duet_rounded_box *box,
                                 uint32_t dims);

// Like sweep_enter, for boxes that meet.
float rounded_sweep_enter(const duet_rounded_sweep *sweep, const duet_rounded_box *box,
                          uint32_t dims, float normal[3]);

#endif

// SPDX-License-Identifier: MIT
// Whether two rounded boxes share a point: whether their cores are as near as both radii.
//
// Pairs that the devices leave open come here, as with boxes: double with a bound, then integers.
// Touching collides, and every answer is the same for (a, b) and (b, a).
#ifndef RUNTIME_ROUNDED_H
#define RUNTIME_ROUNDED_H

#include "runtime/narrowphase/narrow.h"

// Finite, no negative extent or radius, a rotation.
bool rounded_is_sound(const duet_rounded_box *box, uint32_t dims);

duet_rounded_box rounded_of_sphere(const duet_sphere *sphere);

// Without what 2D does not read (narrow_flat).
duet_rounded_box rounded_flat(const duet_rounded_box *box, uint32_t dims);

// Sound ones only. Spheres and boxes along the world's axes whose numbers have few digits, as
// those of a lattice, are decided even where they touch.
narrow_answer rounded_double(const duet_rounded_box *a, const duet_rounded_box *b, uint32_t dims);

// The exact answer by integers: up to some hundred microseconds.
bool rounded_exact(const duet_rounded_box *a, const duet_rounded_box *b, uint32_t dims);

// rounded_double, then rounded_exact where that is undecided.
bool rounded_decide(const duet_rounded_box *a, const duet_rounded_box *b, uint32_t dims);

#endif

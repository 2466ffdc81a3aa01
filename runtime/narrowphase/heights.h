// SPDX-License-Identifier: MIT
// A ground of heights as queries see it: the closed set of all points under its triangles, without
// an end below, with upright walls at its rim.
//
// Its places are doubles, origin + i spacing rounded once. All answers are about these, and made on
// the host: bits are the same on every machine.
#ifndef RUNTIME_HEIGHTS_H
#define RUNTIME_HEIGHTS_H

#include "runtime/narrowphase/ground_piece.h"

// BAD_ARGUMENT for a ground that nothing can have.
bool heights_check(const duet_heights *h, duet_error *err);

// Also for one whose places doubles do not tell apart well.
bool heights_check_places(const duet_heights *h, duet_error *err);

// Bytes of the heights.
size_t heights_bytes(const duet_heights *h);

// Copies a ground, with heights of its own, which are the caller's to free.
bool heights_copy(duet_heights *to, const duet_heights *h, duet_error *err);

void heights_place(const duet_heights *h, uint32_t i, uint32_t j, double at[3]);

ground_piece heights_piece(const duet_heights *h, uint32_t i, uint32_t j, bool upper);

// Whether it meets the ground, touching included: in double with an error bound, then in rational
// numbers; with a radius in double, within 2^-40 of the sizes. Sets entry if it does.
bool heights_meet(const duet_heights *h, const ground_probe *probe, ground_entry *entry);

// How far a point is from the ground, which it is not in.
double heights_distance(const duet_heights *h, const float at[3]);

#endif

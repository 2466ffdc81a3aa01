// SPDX-License-Identifier: MIT
// The one property: whatever the plan, a world on a device pair finds the
// pairs that the reference finds.
#ifndef TESTS_AGREEMENT_H
#define TESTS_AGREEMENT_H

#include "runtime/duet.h"

// Steps n objects (poses or bounds, as def->shape says, or placed poses, as
// def->origin_edge does) under plans of all modes, searches, sorts and grids (every third one, by
// the seed), with shares from nothing to all, and fails with the first pair that differs, or where
// the candidates or the pairs left undecided are not those of the specification in C
// (runtime/narrowphase/sat_frame.h). Returns the number of pairs.
uint64_t agreement_check(const duet_world_def *def, const void *objects, uint32_t n);

#endif

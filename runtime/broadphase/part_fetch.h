// SPDX-License-Identifier: MIT
// What a part found: counters and pairs that come to the host, and undecided pairs that it decides.
#ifndef RUNTIME_PART_FETCH_H
#define RUNTIME_PART_FETCH_H

#include "runtime/broadphase/part.h"

static inline size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

// Reads the counters of the result; waits for all that was launched.
bool part_read_counters(part *p, duet_error *err);

// Reads what a search found: the counters, and the first pairs where they are sent early.
bool part_read_found(part *p, duet_error *err);

// Brings the pairs to the result's span, and decides the undecided ones.
bool part_fetch(part *p, duet_error *err);

#endif

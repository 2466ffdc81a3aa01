// SPDX-License-Identifier: MIT
// Pairs that are counted on the device that found them, and stay there: those of two objects that
// have global ids of 64 bits. Only the others come to the host.
#ifndef RUNTIME_PAIR_COUNT_H
#define RUNTIME_PAIR_COUNT_H

#include "runtime/broadphase/part.h"

// Brings the device's ids up to date; and launches the count of what a search has listed.
bool part_send_ids(part *p, const global_ids *ids, duet_error *err);
bool part_count_pairs(part *p, duet_error *err);

// What was counted joins the part's span, which then has all pairs of the last step.
bool part_bring_counted(part *p, duet_error *err);

#endif

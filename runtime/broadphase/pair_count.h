// SPDX-License-Identifier: MIT
// Pairs that are counted on the device that found them, and stay there: those of two objects that
// have global ids of 64 bits. Only the others come to the host.
#ifndef RUNTIME_PAIR_COUNT_H
#define RUNTIME_PAIR_COUNT_H

#include "runtime/broadphase/part.h"

// What the caller knows of its objects. Places are those in the world's array of objects.
struct global_ids {
    const uint64_t *list;    // [n] of the first n objects; those behind have none
    uint32_t n;              // pairs of two behind are nobody's here: they are left out
    const uint32_t *without; // [n_without] ascending: of the first n these have none either
    uint32_t n_without;
    const uint32_t *changed; // [n_changed] places, in any order, whose id is another than in the
    uint64_t n_changed;      // last step, or who had one and have none, or the other way round
    bool all_changed;
    uint64_t version; // the world's
};

// Brings the device's ids up to date; and launches the count of what a search has listed.
bool part_send_ids(part *p, const global_ids *ids, duet_error *err);
bool part_count_pairs(part *p, duet_error *err);

// What was counted joins the part's span, which then has all pairs of the last step.
bool part_bring_counted(part *p, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// A step's pairs in one ascending list, to be written or compared.
#ifndef SCENE_SORTED_PAIRS_H
#define SCENE_SORTED_PAIRS_H

#include "runtime/duet.h"

// The caller frees it.
duet_pair *sorted_pairs_of(const duet_result *result, duet_error *err);

// Gives the objects of an ascending list other ids, by their old ones; it is ascending again.
void sorted_pairs_rename(duet_pair *pairs, uint64_t n, const uint32_t *ids);

// Called for each pair that is in one list only: missed if it is in the second.
typedef void sorted_pairs_visit(void *context, duet_pair pair, bool missed);

// Both ascending, as a reference is.
void sorted_pairs_compare(const duet_pair *found, uint64_t n_found, const duet_pair *truth,
                          uint64_t n_truth, sorted_pairs_visit *visit, void *context);

// A visit that counts.
typedef struct sorted_pairs_count {
    uint64_t missed;
    uint64_t added;
} sorted_pairs_count;

void sorted_pairs_count_wrong(void *count, duet_pair pair, bool missed);

#endif

// SPDX-License-Identifier: MIT
// A step's pairs in one ascending list, to be written or compared.
#ifndef CLI_PAIR_LIST_H
#define CLI_PAIR_LIST_H

#include "runtime/duet.h"

// As qsort asks, by a and then b.
int pair_list_order(const void *x, const void *y);

// The caller frees it.
duet_pair *pair_list_sorted(const duet_result *result, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// Lists of pairs in order, and what changed from one to the next.
#ifndef RUNTIME_PAIR_LIST_H
#define RUNTIME_PAIR_LIST_H

#include "runtime/duet.h"

typedef struct pair_list {
    duet_pair *pairs;
    size_t n, capacity;
} pair_list;

typedef struct pair_changes {
    duet_event *events; // that begin and end
    size_t n_events, capacity;
    pair_list stays;
} pair_changes;

// Space for n rows of that size.
bool pair_list_grow(void **rows, size_t *capacity, size_t n, size_t size, duet_error *err);
bool pair_list_reserve(pair_list *list, size_t n, duet_error *err);
void pair_list_free(pair_list *list);

// Each pair with its lesser id first, and pairs ascending by a and b.
bool pair_list_sort(pair_list *list, duet_error *err);

// Takes two lists in order.
bool pair_changes_find(pair_changes *changes, const pair_list *before, const pair_list *now,
                       duet_error *err);
void pair_changes_free(pair_changes *changes);

#endif

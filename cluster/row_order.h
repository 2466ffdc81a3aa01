// SPDX-License-Identifier: MIT
// Rows in the order of keys. Those of one sender ascend mostly, so what ascends is merged; keys in
// no order are sorted by their digits.
#ifndef CLUSTER_ROW_ORDER_H
#define CLUSTER_ROW_ORDER_H

#include "cluster/list.h"

// A row by its key, which has so many bits (32 or 64).
typedef struct keyed_row {
    uint64_t key, row;
} keyed_row;

typedef uint64_t row_key(const void *row);

// Sorts n rows, whose memory has space for twice as many; those of one key stay in order.
void keys_order(keyed_row *rows, uint64_t n, int bits);

// Sorts n rows of so many bytes; those of one key stay in order. Returns false without memory; then
// they are as they were.
bool rows_sort(void *rows, uint64_t n, size_t bytes, row_key *key_of);

// The same of a list, which keeps one of those with the same key.
bool row_order(item_list *rows, size_t bytes, row_key *key_of);

#endif

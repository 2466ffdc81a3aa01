// SPDX-License-Identifier: MIT
// Long rows in the order of keys. Those of one sender ascend mostly, so what ascends is merged.
#ifndef CLUSTER_ROW_ORDER_H
#define CLUSTER_ROW_ORDER_H

#include "cluster/list.h"

// A row by its key, which has so many bits (32 or 64).
typedef struct keyed_row {
    uint64_t key, row;
} keyed_row;

// Sorts n rows, whose memory has space for twice as many; those of one key stay in order.
void keys_order(keyed_row *rows, uint64_t n, int bits);

// Sorts rows of so many bytes, and keeps one of those with the same key. Returns false without
// memory; then they are as they were.
bool row_order(item_list *rows, size_t bytes, uint64_t (*key_of)(const void *row));

#endif

// SPDX-License-Identifier: MIT
#ifndef CLUSTER_ROW_LIST_H
#define CLUSTER_ROW_LIST_H

#include <stdbool.h>
#include <stdint.h>

// Places in the rows, as many as there are.
typedef struct row_list {
    uint32_t *rows;
    uint64_t n;
    uint64_t capacity;
    bool failed; // no memory; n counts on
} row_list;

void row_list_add(row_list *l, uint32_t row);

#endif

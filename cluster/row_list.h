// SPDX-License-Identifier: MIT
#ifndef CLUSTER_ROW_LIST_H
#define CLUSTER_ROW_LIST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Places in the rows, as many as there are.
typedef struct row_list {
    uint32_t *rows;
    uint64_t n;
    uint64_t capacity;
    bool failed; // no memory; n counts on
} row_list;

void row_list_add(row_list *l, uint32_t row);
void row_list_append(row_list *l, const row_list *more);
void row_list_clear(row_list *l); // keeps the memory

// Rows [first, first + n) whose objects lie in one domain.
typedef struct row_run {
    uint32_t domain;
    uint32_t first, n;
    uint32_t at; // how many of the domain's rows come before, once runs are sorted by domain
} row_run;

typedef struct run_list {
    row_run *runs;
    uint64_t n;
    uint64_t capacity;
    bool failed; // no memory; n counts on
} run_list;

void run_list_add(run_list *l, row_run run);
void run_list_append(run_list *l, const run_list *more);
void run_list_clear(run_list *l);

// Returns memory for more items than *capacity, and keeps these; NULL without, and they stay.
void *list_grow(void *items, uint64_t *capacity, size_t bytes);

#endif

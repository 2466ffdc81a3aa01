// SPDX-License-Identifier: MIT
#include "cluster/row_list.h"

#include <stdlib.h>

void *list_grow(void *items, uint64_t *capacity, size_t bytes)
{
    uint64_t more = *capacity ? 2 * *capacity : 256;
    void *grown = realloc(items, more * bytes);
    *capacity = grown ? more : *capacity;
    return grown;
}

// Counts what there is no memory for, so that all ranks know of it.
void row_list_add(row_list *l, uint32_t row)
{
    if (!l->failed && l->n == l->capacity) {
        uint32_t *rows = list_grow(l->rows, &l->capacity, sizeof *rows);
        l->failed = !rows;
        l->rows = rows ? rows : l->rows;
    }
    if (!l->failed)
        l->rows[l->n] = row;
    ++l->n;
}

void run_list_add(run_list *l, row_run run)
{
    if (!l->failed && l->n == l->capacity) {
        row_run *runs = list_grow(l->runs, &l->capacity, sizeof *runs);
        l->failed = !runs;
        l->runs = runs ? runs : l->runs;
    }
    if (!l->failed)
        l->runs[l->n] = run;
    ++l->n;
}

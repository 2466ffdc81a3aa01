// SPDX-License-Identifier: MIT
#include "cluster/row_list.h"

#include <stdlib.h>
#include <string.h>

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

void row_list_append(row_list *l, const row_list *more)
{
    uint64_t n = l->n + more->n;
    if (!l->failed && n > l->capacity) {
        uint32_t *rows = realloc(l->rows, n * sizeof *rows);
        l->failed = !rows;
        l->rows = rows ? rows : l->rows;
        l->capacity = rows ? n : l->capacity;
    }
    l->failed = l->failed || more->failed;
    if (!l->failed && more->n > 0)
        memcpy(l->rows + l->n, more->rows, more->n * sizeof *l->rows);
    l->n = n;
}

void run_list_append(run_list *l, const run_list *more)
{
    l->failed = l->failed || more->failed;
    for (uint64_t k = 0; !l->failed && k < more->n; ++k)
        run_list_add(l, more->runs[k]);
}

void row_list_clear(row_list *l)
{
    *l = (row_list){.rows = l->rows, .capacity = l->capacity};
}

void run_list_clear(run_list *l)
{
    *l = (run_list){.runs = l->runs, .capacity = l->capacity};
}

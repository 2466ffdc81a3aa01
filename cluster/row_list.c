// SPDX-License-Identifier: MIT
#include "cluster/row_list.h"

#include <stdlib.h>

void row_list_add(row_list *l, uint32_t row)
{
    if (!l->failed && l->n == l->capacity) {
        uint64_t capacity = l->capacity ? 2 * l->capacity : 256;
        uint32_t *rows = realloc(l->rows, capacity * sizeof *rows);
        l->failed = !rows;
        l->rows = rows ? rows : l->rows;
        l->capacity = rows ? capacity : l->capacity;
    }
    if (!l->failed)
        l->rows[l->n] = row;
    ++l->n; // so that all ranks know that there is one
}

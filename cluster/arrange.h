// SPDX-License-Identifier: MIT
// Rows that lie in ranges, one behind the other, and come to lie in other ones. In no range are
// there gaps, and the order within a range is any.
#ifndef CLUSTER_ARRANGE_H
#define CLUSTER_ARRANGE_H

#include "cluster/objects.h"
#include "cluster/parallel.h"

// A row whose object belongs to another range than the one that it lies in.
typedef struct stray {
    uint32_t row;
    uint32_t to;
} stray;

// Of all rows, range i has those up to ends[i], and the last range has the rest. Brings the strays,
// in any order, to their ranges, and moves as many others as borders between ranges move. *ends
// becomes what it is then. The memory it takes is that of the rows which move.
bool rows_arrange(object_rows *rows, const object_form *form, uint32_t *ends, uint32_t n_ranges,
                  stray *strays, uint64_t n, duet_error *err);

void rows_exchange(object_rows *rows, const object_form *form, uint32_t a, uint32_t b);

// Brings all of the first n rows to their ranges, in place, as range_of says, which is asked
// several times, also by several threads at once; ends becomes [n_ranges].
typedef uint32_t row_range(const void *context, const void *object);
void rows_sort(object_rows *rows, const object_form *form, uint32_t n, uint32_t *ends,
               uint32_t n_ranges, row_range *range_of, const void *context, parallel *threads);

#endif

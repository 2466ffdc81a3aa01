// SPDX-License-Identifier: MIT
// Rows that lie deep inside of a box, passed over in bulk.
#ifndef CLUSTER_INTERIOR_H
#define CLUSTER_INTERIOR_H

#include "cluster/objects.h"
#include "kernels/grid/interior.h"

// Summary of rows that lie deep inside of a box.
typedef struct interior {
    extent centres;
    double square; // the square of the greatest half extent along any axis, however the objects are
                   // turned
} interior;

static const interior interior_none = {
    {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}}, 0};

// Adds the rows from `first` on whose centre lies inside of that, and returns the first row for
// which a glance does not decide, or which is not sound; `end` if there is none.
uint32_t object_rows_add_interior(const object_rows *rows, const object_form *form, uint32_t first,
                                  uint32_t end, const extent *inside, interior *s);
// The same by a device: the box as it takes it, and a block of its answer.
void interior_box(const extent *inside, float lower[3], float upper[3]);
void interior_add_block(interior *s, const interior_block *block);
// Returns no less than the width of any of them.
double interior_widest(const interior *s, const object_form *form);

#endif

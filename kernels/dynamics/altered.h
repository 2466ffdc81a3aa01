// SPDX-License-Identifier: MIT
// What a search about bodies that commands altered counts, for kernels and host alike.
#ifndef KERNELS_DYNAMICS_ALTERED_H
#define KERNELS_DYNAMICS_ALTERED_H

#define ALTERED_CELLS 64 // a body that overlaps more is not in the table

#define ALTERED_PAIRS 0 // found or kept
#define ALTERED_ENTRIES 1
#define ALTERED_WIDE 2 // bodies of too many cells
#define ALTERED_AROUND 3 // the box around those in the table: words (sortable.clh) of its upper corner, and of the lower one times -1
#define ALTERED_COUNTS 9

#endif

// SPDX-License-Identifier: MIT
// A device's answer which objects lie inside a box, for kernels and host alike: a block of words
// for each INTERIOR_ROWS of them.
#ifndef KERNELS_GRID_INTERIOR_H
#define KERNELS_GRID_INTERIOR_H

#define INTERIOR_ROWS 2048
#define INTERIOR_WORDS (INTERIOR_ROWS / 32)

typedef struct interior_block {
    unsigned int odd[INTERIOR_WORDS]; // a bit for each object that the host must look at
    unsigned int n_odd;
    float lower[3], upper[3]; // around the others: poses' centres, or bounds; none: lower > upper
    float square; // no less than any of theirs by more than three roundings, see find_interior.cl
} interior_block;

#endif

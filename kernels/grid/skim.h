// SPDX-License-Identifier: MIT
// What a device says of objects that it skims, for kernels and host alike: a block of words for
// each SKIM_ROWS of them.
#ifndef KERNELS_GRID_SKIM_H
#define KERNELS_GRID_SKIM_H

#define SKIM_ROWS 2048
#define SKIM_WORDS (SKIM_ROWS / 32)

typedef struct skim_block {
    unsigned int odd[SKIM_WORDS]; // a bit for each object that the host must look at
    unsigned int n_odd;
    float lower[3], upper[3]; // around the others: poses' centres, or bounds; none: lower > upper
    float square; // no less than any of theirs by more than three roundings, see skim.cl
} skim_block;

#endif

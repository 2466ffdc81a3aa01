// SPDX-License-Identifier: MIT
// Rows of a tree in origin cells, its objects and what it is asked, as kernels/queries/far.clh
// has them: settled, and in cells that count from the middle of the objects.
#ifndef RUNTIME_FAR_ROWS_H
#define RUNTIME_FAR_ROWS_H

#include "runtime/duet.h"

// A row begins with its offset, and has its cell at a word of its own.
typedef struct far_rows {
    void *rows;
    uint64_t n;
    uint32_t words, cell_word;
} far_rows;

// Layout of a duet_large_pose.
#define FAR_POSE_WORDS 14
#define FAR_POSE_CELL 10

// Brings offsets into their cells. One beyond 2^30 cells is no number afterwards.
void far_rows_settle(const far_rows *far, float edge);

// The cell in the middle of them; what is no number counts for nothing.
void far_rows_middle(const far_rows *far, int32_t middle[3]);

// Their cells are no longer counted from 0. Both are within 2^30, so the difference is a number.
void far_rows_count_from(const far_rows *far, const int32_t middle[3]);

// From a pose's cell to another row's, exactly.
void far_shift(double shift[3], const duet_large_pose *from, const int32_t to[3], float edge);

#endif

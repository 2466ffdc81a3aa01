// SPDX-License-Identifier: MIT
// Positions in cells, as precise far from 0 as near it.
//
// Along an axis a position is a whole number of quanta of 2^-24 of an edge, a
// power of two: its cell has the upper bits, and its offset the lower 24, which a
// float holds. So the difference of two offsets is exact, and that of two
// positions is rounded once, wherever they are.
#ifndef RUNTIME_ORIGIN_H
#define RUNTIME_ORIGIN_H

#include "runtime/duet.h"

// 0, for none, or a power of two from 2^-100 to 2^100.
bool origin_is_edge(float edge);

// The value of the kernels' ORIGIN: the exponent's bits of the edge, or 0.
uint32_t origin_setting(float edge);

// Brings each offset into its cell. False, and a centre that is not a number,
// where that is beyond 2^30 cells.
bool origin_settle(duet_large_pose *large, float edge);
bool origin_settle_at(float offset[3], int32_t cell[3], float edge);

// The nearest position to a centre; false as above.
bool origin_place(duet_large_pose *large, const double centre[3], float edge);

// Rows of objects of a shape, or with an edge above 0 large poses.
size_t origin_row_bytes(duet_shape shape, float edge);
duet_object_kind origin_row_kind(duet_shape shape, float edge);
static inline const duet_pose *origin_pose(const void *rows, float edge, uint32_t id)
{
    return edge > 0.0f ? &((const duet_large_pose *)rows)[id].pose : &((const duet_pose *)rows)[id];
}

// A cell's corner, exactly; 0 without an edge.
static inline void origin_corner(double corner[3], const void *rows, float edge, uint32_t id)
{
    for (int k = 0; k < 3; ++k)
        corner[k] = edge > 0.0f ? (double)((const duet_large_pose *)rows)[id].cell[k] * edge : 0.0;
}

// From the cell of a to that of b, exactly; 0 without an edge.
static inline void origin_shift(double shift[3], const void *rows, float edge, uint32_t a,
                                uint32_t b)
{
    const duet_large_pose *large = rows;
    for (int k = 0; k < 3; ++k)
        shift[k] = edge > 0.0f ? ((double)large[b].cell[k] - large[a].cell[k]) * edge : 0.0;
}

#endif

// SPDX-License-Identifier: MIT
// How the grid and the objects in cell order lie in memory, for kernels and host alike.
// origin: 1 where positions are cells and offsets, else 0.
#ifndef KERNELS_GRID_PLACES_H
#define KERNELS_GRID_PLACES_H

#ifdef __OPENCL_VERSION__
#define CL_TYPE(type) type
#else
#include <CL/cl.h>
#define CL_TYPE(type) cl_##type
#endif

typedef struct grid_level {
    CL_TYPE(float4) lower;    // with origin cells in one, whose xyz is in w of these three
    CL_TYPE(float4) per_cell; // 1 / edge
    CL_TYPE(float4) limit;    // an extent above it does not fit: the edge less its margin
    CL_TYPE(float4) reach;    // how far beyond its point an object's bounds may be, with a margin
    CL_TYPE(int4) cells;      // w: the key of the level's first cell
} grid_level;

// For the search gpu, vectors of four an object: the lower and the upper corner of its
// bounds; the box's centre, half extents and rotation; with origins both end with the cell.
#define BOUNDS_QUADS_OF(origin) ((origin) ? 3 : 2)
#define BOX_QUADS_OF(origin) ((origin) ? 4 : 3)

// For the search simd, columns of bounds: the lower corner, the upper one, where the object
// belongs, and with origins the cell. A column runs past its capacity, for whole vectors of
// eight are read and written at its end.
#define BOUNDS_COLUMNS_OF(dims, origin) (2 * (dims) + 1 + ((origin) ? (dims) : 0))
#define COLUMN(capacity) (((size_t)(capacity) + 15) / 8 * 8)

// And rows of boxes: centre, half extents, `more` numbers for the test, the cell with
// origins, the id. No row crosses a line of the cache.
#define BOX_WORDS_OF(more, origin) ((origin) ? ((more) > 4 ? 24 : 16) : ((more) > 2 ? 16 : 8))
#define MOST_MORE_OF(dims, rotated) ((rotated) ? ((dims) == 3 ? 9 : 2) : 1)

#endif

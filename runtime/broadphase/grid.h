// SPDX-License-Identifier: MIT
// The grid's geometry: where it lies, its levels, their cells.
//
// An object belongs to the cell of its point: a pose's centre, or the lower corner
// of bounds. Both are numbers of the input, so that nothing is rounded on the way.
// Two objects of one level meet in neighbouring cells only if neither is wider
// than a cell. A dense grid has an entry for every cell, level after level. A
// hashed one scatters the cells of all levels over a table of about two
// entries an object, so that worlds of any size take memory for the objects
// alone. Objects outside a dense grid count to its border cells.
//
// Dense cell coordinates are computed in float, which can misplace a point by
// u * cells (u = 2^-24) three times over: the edge is wider than the widest object
// by the margin 2^-16 + cells * 2^-21, and an axis has at most 65 536 cells.
// Hashed ones are computed in double, and an axis has at most 2^30 cells. No edge
// is below 2^-125, so that 1 / edge is a float. docs/notes/accuracy.md has the proof.
#ifndef RUNTIME_GRID_H
#define RUNTIME_GRID_H

#include "kernels/grid/places.h"
#include "runtime/broadphase/grid_objects.h"

typedef enum grid_kind { GRID_DENSE, GRID_HASHED } grid_kind;

enum { GRID_LEVELS = 16 };

typedef struct grid {
    grid_kind kind;
    uint32_t n_levels; // finest first
    grid_level levels[GRID_LEVELS];
    uint32_t n_cells;  // cells of all levels, or entries of the table, a power of two
    uint32_t key_bits; // bits of n_cells, the key of objects that are left out
    float edge;        // the least of any level
    double widest;     // the largest extent of the objects that it was fitted to
    bool varies;       // the world's grid had other cells before
} grid;

// The begin of a level along an axis.
double grid_corner(const grid_level *level, float origin, uint32_t axis);

typedef enum grid_kinds { GRID_ANY, GRID_ONLY_DENSE, GRID_ONLY_HASHED } grid_kinds;

// From this many others in an object's own cell on, a hashed grid with its finer cells is the
// better one. A CPU looks up an object's cells in the time that it tests 100 to 300 others in, as
// lanes do (docs/notes/performance.md).
enum { GRID_CROWD = 128, GRID_CROWD_OF_GPUS = 8 };

// How a grid is to be made; zero if that is open.
typedef struct grid_wish {
    const float *lower, *upper; // the world's; NULL: the objects'
    double edge;                // the least edge of the cells; one level then
    uint32_t n_levels;          // 1, or as the sizes are
    grid_kinds kinds;
    uint32_t crowd; // at most, in a dense grid; 0: GRID_CROWD
} grid_wish;

// The grid for these objects. Dense unless so many objects would share cells
// that a hashed one is far better. Memory for counting them may run out.
bool grid_fit(grid *g, const grid_needs *needs, const grid_wish *wish, const grid_objects *objects,
              duet_error *err);

// An object's cell of the finest level, about as the kernels have it; z is 0 in 2D.
void grid_cell_of(uint32_t cell[3], const grid *g, const grid_objects *objects, uint32_t id);

// Objects whose cells are found at once: with their rows they stay in a processor's cache.
enum { GRID_BLOCK = 1024 };

// The rows of cells of the finest level that n objects from `first` on are in, at most a block of
// them; in the key order of a dense grid of one level each row is cells[0] keys long.
void grid_cell_rows(uint32_t *rows, const grid *g, const grid_objects *objects, uint32_t first,
                    uint32_t n);

#endif

// SPDX-License-Identifier: MIT
// The order of a world's objects by cell.
//
// The cells are those of the grid's finest level, whatever an object's own level is, and of a
// hashed grid the cells themselves, not their entries: objects that follow each other lie side
// by side.
#include "runtime/broadphase/world.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };

typedef struct keyed_id {
    uint64_t key;
    uint32_t id;
} keyed_id;

// How cells are numbered: row after row. Where a world has more cells than keys, neighbours
// share one.
typedef struct numbering {
    uint32_t shift;
    uint64_t cells[3];
} numbering;

static numbering number_cells(const grid *g)
{
    numbering n = {0};
    double keys;
    do {
        keys = 1.0;
        for (int k = 0; k < 3; ++k) {
            n.cells[k] = ((uint64_t)(g->levels[0].cells.s[k] - 1) >> n.shift) + 1;
            keys *= (double)n.cells[k];
        }
    } while (keys > 0x1p63 && ++n.shift);
    return n;
}

static uint64_t key_of(const numbering *n, const uint32_t cell[3])
{
    return ((cell[2] >> n->shift) * n->cells[1] + (cell[1] >> n->shift)) * n->cells[0] +
           (cell[0] >> n->shift);
}

// One pass of a radix sort, which keeps the order of equal digits.
static void sort_by_digit(keyed_id *to, const keyed_id *from, uint32_t n, uint32_t shift)
{
    uint32_t starts[DIGITS + 1] = {0};
    for (uint32_t i = 0; i < n; ++i)
        ++starts[(from[i].key >> shift) % DIGITS + 1];
    for (uint32_t d = 0; d < DIGITS; ++d)
        starts[d + 1] += starts[d];
    for (uint32_t i = 0; i < n; ++i)
        to[starts[(from[i].key >> shift) % DIGITS]++] = from[i];
}

// rows has space for 2 n. Returns the half that is sorted.
static keyed_id *sort_rows(keyed_id *rows, uint32_t n, uint64_t most)
{
    keyed_id *from = rows, *to = rows + n;
    for (uint32_t shift = 0; shift < 64 && most >> shift; shift += DIGIT_BITS) {
        sort_by_digit(to, from, n, shift);
        keyed_id *sorted = to;
        to = from;
        from = sorted;
    }
    return from;
}

static bool order_objects(const duet_world *world, uint32_t *order, duet_error *err)
{
    grid_objects objects = world_objects(world);
    numbering cells = number_cells(&world->grid);
    keyed_id *rows = malloc(2 * (size_t)objects.n * sizeof *rows);
    if (!rows)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory to order %u objects",
                         objects.n);
    uint64_t most = 0;
    for (uint32_t id = 0; id < objects.n; ++id) {
        uint32_t cell[3];
        grid_cell_of(cell, &world->grid, &objects, id);
        rows[id] = (keyed_id){key_of(&cells, cell), id};
        most = rows[id].key > most ? rows[id].key : most;
    }
    const keyed_id *sorted = sort_rows(rows, objects.n, most);
    for (uint32_t i = 0; i < objects.n; ++i)
        order[i] = sorted[i].id;
    free(rows);
    return true;
}

bool duet_world_order(duet_world *world, uint32_t **order, uint32_t *n, duet_error *err)
{
    if (!world_is_idle(world, __func__, err) || !error_given(order, __func__, "order", err) ||
        !error_given(n, __func__, "n", err) || !world_check_sizes(world, err))
        return false;
    uint32_t *list = malloc((size_t)world->n * sizeof *list + 1);
    if (!list)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory to order %u objects",
                         world->n);
    bool ok = world->n == 0 || (world_fit_grid(world, err) && world_see_objects(world, err) &&
                                order_objects(world, list, err));
    world_end_sight(world);
    if (!ok) {
        free(list);
        return false;
    }
    *order = list;
    *n = world->n;
    return true;
}

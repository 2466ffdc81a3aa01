// SPDX-License-Identifier: MIT
#include "runtime/broadphase/split.h"

#include "base/error.h"

#include <stdlib.h>

// What an object costs on the way into the grid, in tests.
static const double object_cost = 8.0;

bool split_count(split *s, const part_task *task, duet_error *err)
{
    uint32_t n_rows = grid_rows(&task->grid);
    uint32_t *rows = calloc(n_rows, sizeof *rows);
    if (!rows)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory to count %u rows of cells",
                         n_rows);
    grid_objects objects = part_objects(task);
    for (uint32_t id = 0; id < task->n; ++id)
        ++rows[grid_row_of(&task->grid, &objects, id)];
    free(s->rows);
    *s = (split){rows, n_rows};
    return true;
}

void split_free(split *s)
{
    free(s->rows);
    *s = (split){0};
}

// Every object meets half the neighbourhood of its cell.
static double work_of(uint32_t objects, const part_task *task)
{
    double neighbourhood = task->dims == 3 ? 13.5 : 4.5;
    double a_cell = (double)objects / task->grid.levels[0].cells.s[0];
    return objects * (object_cost + neighbourhood * a_cell);
}

static uint32_t count(const split *s, uint32_t from, uint32_t to)
{
    uint64_t n = 0;
    for (uint32_t r = from; r < to; ++r)
        n += s->rows[r];
    return (uint32_t)n;
}

// The rows before the cut.
static uint32_t find_cut(const split *s, const part_task *task, uint32_t share)
{
    double total = 0.0;
    for (uint32_t r = 0; r < s->n_rows; ++r)
        total += work_of(s->rows[r], task);
    double wanted = total * share / DUET_SHARE_ONE;
    double before = 0.0;
    uint32_t cut = 0;
    while (cut < s->n_rows && before + 0.5 * work_of(s->rows[cut], task) < wanted)
        before += work_of(s->rows[cut++], task);
    return share == DUET_SHARE_ONE ? s->n_rows : cut;
}

// Objects move between counts, so there is space for some more.
static uint32_t with_reserve(uint32_t n, uint32_t all)
{
    uint64_t capacity = (uint64_t)n + n / 16 + 256;
    return capacity < all ? (uint32_t)capacity : all;
}

static part_range slab(const split *s, const part_task *task, uint32_t from, uint32_t to,
                       uint32_t ghost_to)
{
    if (from == to)
        return (part_range){0};
    uint32_t nx = (uint32_t)task->grid.levels[0].cells.s[0];
    uint32_t homes = with_reserve(count(s, from, to), task->n);
    uint32_t ghosts = with_reserve(count(s, to, ghost_to), task->n);
    uint64_t both = (uint64_t)homes + ghosts;
    return (part_range){
        .key_from = from * nx,
        .home_to = to * nx,
        .key_to = ghost_to * nx,
        .last = UINT32_MAX,
        .expected = both < task->n ? (uint32_t)both : task->n,
        .expected_homes = homes,
        .expected_ghosts = ghosts,
    };
}

void split_cut(const split *s, const part_task *task, uint32_t share, part_range ranges[2])
{
    uint32_t cut = find_cut(s, task, share);
    uint32_t layer = task->dims == 3 ? (uint32_t)task->grid.levels[0].cells.s[1] : 0;
    uint64_t ahead = (uint64_t)cut + layer + 1;
    uint32_t ghost_to = ahead < s->n_rows ? (uint32_t)ahead : s->n_rows;
    ranges[0] = slab(s, task, 0, cut, ghost_to);
    ranges[1] = slab(s, task, cut, s->n_rows, s->n_rows);
}

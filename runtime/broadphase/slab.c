// SPDX-License-Identifier: MIT
#include "runtime/broadphase/slab.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

// The cost of placing an object in the grid, in tests of pairs.
static const double object_cost = 8.0;

void split_free(split *s)
{
    free(s->cell_rows);
    *s = (split){0};
}

void split_forget(split *s)
{
    s->n_rows = 0;
}

bool split_is_stale(const split *s)
{
    return s->n_rows == 0;
}

static bool count_objects(split *s, const grid *g, const grid_objects *objects, duet_error *err)
{
    uint32_t n_rows = g->n_cells / (uint32_t)g->levels[0].cells.s[0];
    uint32_t *rows = calloc(n_rows, sizeof *rows);
    if (!rows)
        return no_memory(err, "the counts of %u rows of cells", n_rows);
    for (uint32_t first = 0, n; first < objects->all.n; first += n) {
        uint32_t of[GRID_BLOCK], left = objects->all.n - first;
        n = left < GRID_BLOCK ? left : GRID_BLOCK;
        grid_cell_rows(of, g, objects, first, n);
        for (uint32_t k = 0; k < n; ++k)
            ++rows[of[k]];
    }
    free(s->cell_rows);
    *s = (split){.cell_rows = rows, .n_rows = n_rows};
    return true;
}

// Every object meets half the neighbourhood of its cell.
static double work_of(uint32_t n, const grid *g, uint32_t dims)
{
    double neighbourhood = dims == 3 ? 13.5 : 4.5;
    double a_cell = (double)n / g->levels[0].cells.s[0];
    return n * (object_cost + neighbourhood * a_cell);
}

static uint32_t sum_rows(const split *s, uint32_t from, uint32_t to)
{
    uint64_t n = 0;
    for (uint32_t r = from; r < to; ++r)
        n += s->cell_rows[r];
    return (uint32_t)n;
}

// The rows before the cut.
static uint32_t find_cut(const split *s, const grid *g, uint32_t dims, uint32_t share)
{
    double total = 0.0;
    for (uint32_t r = 0; r < s->n_rows; ++r)
        total += work_of(s->cell_rows[r], g, dims);
    double wanted = total * share / DUET_SHARE_ONE;
    double before = 0.0;
    uint32_t cut = 0;
    while (cut < s->n_rows && before + 0.5 * work_of(s->cell_rows[cut], g, dims) < wanted)
        before += work_of(s->cell_rows[cut++], g, dims);
    return share == DUET_SHARE_ONE ? s->n_rows : cut;
}

// Objects move between counts: reserves space for some more.
static uint32_t with_reserve(uint32_t n, uint32_t all)
{
    uint64_t capacity = (uint64_t)n + n / 16 + 256;
    return capacity < all ? (uint32_t)capacity : all;
}

static part_range slab_of(const split *s, const grid *g, uint32_t n, uint32_t from, uint32_t to,
                          uint32_t ghost_to)
{
    if (from == to)
        return (part_range){0};
    uint32_t nx = (uint32_t)g->levels[0].cells.s[0];
    uint32_t counted = sum_rows(s, from, to);
    uint32_t homes = with_reserve(counted, n);
    uint32_t ghosts = with_reserve(sum_rows(s, to, ghost_to), n);
    uint64_t both = (uint64_t)homes + ghosts;
    return (part_range){
        .key_from = from * nx,
        .home_to = to * nx,
        .key_to = ghost_to * nx,
        .last = UINT32_MAX,
        .expected = both < n ? (uint32_t)both : n,
        .homes = counted,
        .expected_ghosts = ghosts,
    };
}

static void cut_rows(split *s, const grid *g, const grid_objects *objects)
{
    uint32_t cut = find_cut(s, g, objects->dims, s->share);
    uint32_t layer = objects->dims == 3 ? (uint32_t)g->levels[0].cells.s[1] : 0;
    uint64_t ahead = (uint64_t)cut + layer + 1;
    uint32_t ghost_to = ahead < s->n_rows ? (uint32_t)ahead : s->n_rows;
    s->ranges[0] = slab_of(s, g, objects->all.n, 0, cut, ghost_to);
    s->ranges[1] = slab_of(s, g, objects->all.n, cut, s->n_rows, s->n_rows);
    for (int side = 0; side < 2; ++side) {
        s->ranges[side].other_from = s->ranges[1 - side].key_from;
        s->ranges[side].other_to = s->ranges[1 - side].key_to;
    }
}

bool split_cut(split *s, const grid *g, const grid_objects *objects, uint32_t share,
               part_range ranges[2], duet_error *err)
{
    if (split_is_stale(s) && !count_objects(s, g, objects, err))
        return false;
    if (s->n != objects->all.n || s->share != share) {
        s->share = share;
        s->n = objects->all.n;
        cut_rows(s, g, objects);
    }
    memcpy(ranges, s->ranges, sizeof s->ranges);
    return true;
}

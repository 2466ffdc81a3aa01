// SPDX-License-Identifier: MIT
// Bodies are taken by ascending height. A map has, for each cell of the plane below them, the
// bodies there that a later one can still stand on: what a body stands on is in the cells that it
// covers.
#include "runtime/dynamics/height_map.h"

#include "base/compare.h"
#include "base/list.h"
#include "runtime/dynamics/motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// 1 + places; 0: none.
typedef struct cell {
    int32_t at[2];
    uint64_t first;
    bool used;
} cell;

typedef struct cell_entry {
    uint32_t block;
    uint64_t next;
} cell_entry;

typedef struct cells {
    double edge; // of a cell
    cell *table; // [mask + 1] open addressing, at most half of them used
    uint64_t mask, used;
    cell_entry *entries; // [n_entries] of all cells
    uint64_t n_entries;
} cells;

// ---------------------------------------------------------------- blocks

// Column `axis` of the rotation's transpose: how much each of the body's axes lies along it.
static void axis_in_body(const float q[4], int axis, double along[3])
{
    double x = q[0], y = q[1], z = q[2], w = q[3], norm = x * x + y * y + z * z + w * w;
    const double r[3][3] = {
        {w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
        {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
        {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z},
    };
    for (int k = 0; k < 3; ++k)
        along[k] = fabs(r[axis][k]) / norm;
}

static duet_pose solid_pose(const duet_motion *m, uint32_t id)
{
    duet_pose p = m->poses[id];
    if (m->def.dims == 2) {
        p.rotation[0] = p.rotation[1] = 0.0f;
        p.half_extents[2] = 0.0f;
    }
    return p;
}

// Half of what the box has of the line through its centre.
static double half_chord(const duet_pose *p, int axis, uint32_t dims)
{
    double along[3], least = INFINITY;
    axis_in_body(p->rotation, axis, along);
    for (uint32_t k = 0; k < dims; ++k)
        if (along[k] > 0.0)
            least = fmin(least, p->half_extents[k] / along[k]);
    return least;
}

static double half_bounds(const duet_pose *p, int axis)
{
    double along[3];
    axis_in_body(p->rotation, axis, along);
    return along[0] * p->half_extents[0] + along[1] * p->half_extents[1] +
           along[2] * p->half_extents[2];
}

static double centre_of(const duet_motion *m, uint32_t id, int axis)
{
    double corner = m->cells ? (double)m->cells[id].s[axis] * (double)m->def.origin_edge : 0.0;
    return corner + (double)m->poses[id].centre[axis];
}

static block block_of(const duet_motion *m, uint32_t id, int axis, double up)
{
    const duet_pose p = solid_pose(m, id);
    double radius = m->bodies[id].radius, height = half_chord(&p, axis, m->def.dims) + radius;
    double middle = up * centre_of(m, id, axis), width = INFINITY;
    block b = {.bottom = middle - height,
               .top = middle + height,
               .radius = radius,
               .mass = m->bodies[id].mass,
               .id = id};
    int flat = 0;
    for (int k = 0; k < (int)m->def.dims; ++k) {
        if (k == axis)
            continue;
        b.at[flat] = centre_of(m, id, k);
        b.reach[flat] = half_bounds(&p, k) + radius;
        width = fmin(width, 2.0 * b.reach[flat++]);
    }
    b.edge = width * width / (2.0 * height);
    return b;
}

static int by_bottom(const void *x, const void *y)
{
    const block *a = x, *b = y;
    if (a->bottom != b->bottom)
        return a->bottom < b->bottom ? -1 : 1;
    return a->id < b->id ? -1 : 1;
}

// Bodies that can stand or bear others: not flat ones, on which nothing has a width. Returns the
// mean width of those that move; 0: none does.
static double list_blocks(const duet_motion *m, int axis, height_map *map)
{
    double up = m->def.gravity[axis] > 0.0 ? -1.0 : 1.0, sum = 0.0;
    uint32_t n_moving = 0;
    for (uint32_t id = 0; id < m->n; ++id) {
        if (m->bodies[id].sensor)
            continue;
        block b = block_of(m, id, axis, up);
        double width = m->def.dims == 3 ? fmin(b.reach[0], b.reach[1]) : b.reach[0];
        if (!(b.edge > 0.0) || !isfinite(b.edge))
            continue;
        sum += b.mass > 0.0 ? 2.0 * width : 0.0;
        n_moving += b.mass > 0.0;
        map->blocks[map->n++] = b;
    }
    qsort(map->blocks, map->n, sizeof *map->blocks, by_bottom);
    return n_moving > 0 ? sum / n_moving : 0.0;
}

// ---------------------------------------------------------------- cells

typedef struct cell_range {
    int32_t from[2], to[2];
} cell_range;

// Farther ones share cells.
static int32_t cell_at(const cells *all, double x)
{
    return (int32_t)fmax(-1e9, fmin(1e9, floor(x / all->edge)));
}

// The cells that a block covers; of a wide one those about its centre.
static cell_range cells_of(const cells *all, const block *b)
{
    const double most = 8.0 * all->edge;
    cell_range r;
    for (int k = 0; k < 2; ++k) {
        double reach = fmin(b->reach[k], most);
        r.from[k] = cell_at(all, b->at[k] - reach);
        r.to[k] = cell_at(all, b->at[k] + reach);
    }
    return r;
}

static uint64_t place_of(const cells *all, const int32_t at[2])
{
    uint64_t h = (uint64_t)(uint32_t)at[0] * 0x9e3779b97f4a7c15u ^
                 (uint64_t)(uint32_t)at[1] * 0xc2b2ae3d27d4eb4fu;
    uint64_t i = (h ^ h >> 29) & all->mask;
    while (all->table[i].used && memcmp(all->table[i].at, at, sizeof all->table[i].at) != 0)
        i = (i + 1) & all->mask;
    return i;
}

static bool grow_table(cells *all)
{
    const cells old = *all;
    all->mask = 2 * old.mask + 1;
    all->table = calloc(all->mask + 1, sizeof *all->table);
    for (uint64_t i = 0; all->table && i <= old.mask; ++i)
        if (old.table[i].used)
            all->table[place_of(all, old.table[i].at)] = old.table[i];
    free(old.table);
    return all->table;
}

// Finds a cell, or makes it; NULL: no memory.
static cell *find_cell(cells *all, int32_t x, int32_t y)
{
    const int32_t at[2] = {x, y};
    if (2 * all->used > all->mask && !grow_table(all))
        return NULL;
    cell *c = &all->table[place_of(all, at)];
    all->used += !c->used;
    c->used = true;
    memcpy(c->at, at, sizeof at);
    return c;
}

static bool open_cells(cells *all, const height_map *map, double edge)
{
    uint64_t most = 0;
    *all = (cells){.edge = edge, .mask = 1023};
    for (uint32_t i = 0; i < map->n; ++i) {
        cell_range r = cells_of(all, &map->blocks[i]);
        most += (uint64_t)(r.to[0] - r.from[0] + 1) * (uint64_t)(r.to[1] - r.from[1] + 1);
    }
    all->table = calloc(all->mask + 1, sizeof *all->table);
    all->entries = malloc((most + 1) * sizeof *all->entries);
    return all->table && all->entries;
}

// ---------------------------------------------------------------- supports

// One may be pressed into the other, or lie between others below.
static bool stands_on(const block *b, const block *below, uint32_t n_flat, double margin)
{
    double gap = b->bottom - below->top;
    double overlap = 0.5 * fmin(b->top - b->bottom, below->top - below->bottom);
    bool over = b->mass > 0.0;
    for (uint32_t k = 0; k < n_flat; ++k)
        over = over && fabs(b->at[k] - below->at[k]) < b->reach[k] + below->reach[k];
    return over && gap <= margin && gap >= -overlap;
}

static bool add_support(height_map *map, support s)
{
    support *supports = list_room(map->supports, map->n_supports, sizeof *supports, NULL);
    if (!supports)
        return false;
    map->supports = supports;
    map->supports[map->n_supports++] = s;
    return true;
}

// Lists what a block stands on in a cell. Blocks there that end too low for it end too low for all
// later ones.
static bool look_below(height_map *map, cells *all, uint32_t upper, cell *c, double margin)
{
    const block *b = &map->blocks[upper];
    uint64_t *link = &c->first;
    while (*link) {
        cell_entry *e = &all->entries[*link - 1];
        const block *below = &map->blocks[e->block];
        if (stands_on(b, below, map->n_flat, margin) &&
            !add_support(map, (support){upper, e->block}))
            return false;
        if (b->bottom - below->top > margin)
            *link = e->next;
        else
            link = &e->next;
    }
    return true;
}

static bool put_block(height_map *map, cells *all, uint32_t place, double margin)
{
    cell_range r = cells_of(all, &map->blocks[place]);
    for (int32_t x = r.from[0]; x <= r.to[0]; ++x)
        for (int32_t y = r.from[1]; y <= r.to[1]; ++y) {
            cell *c = find_cell(all, x, y);
            if (!c || !look_below(map, all, place, c, margin))
                return false;
            all->entries[all->n_entries++] = (cell_entry){.block = place, .next = c->first};
            c->first = all->n_entries;
        }
    return true;
}

// Two blocks may share several cells.
static void sort_supports(height_map *map)
{
    uint64_t n = 0;
    if (map->n_supports > 0)
        qsort(map->supports, map->n_supports, sizeof *map->supports, compare_uint32_pair);
    for (uint64_t i = 0; i < map->n_supports; ++i)
        if (i == 0 || compare_uint32_pair(&map->supports[i], &map->supports[n - 1]) != 0)
            map->supports[n++] = map->supports[i];
    map->n_supports = n;
}

static int axis_of(const duet_motion *m)
{
    int axis = 0;
    for (int k = 1; k < (int)m->def.dims; ++k)
        if (fabs(m->def.gravity[k]) > fabs(m->def.gravity[axis]))
            axis = k;
    return axis;
}

static bool find_supports(height_map *map, double edge, double margin)
{
    cells all;
    bool ok = open_cells(&all, map, edge);
    for (uint32_t i = 0; ok && i < map->n; ++i)
        ok = put_block(map, &all, i, margin);
    free(all.entries);
    free(all.table);
    sort_supports(map);
    return ok;
}

bool height_map_open(height_map *map, const duet_motion *m)
{
    *map = (height_map){.n_flat = m->def.dims - 1,
                        .blocks = malloc(((size_t)m->n + 1) * sizeof *map->blocks)};
    if (!map->blocks)
        return false;
    double edge = list_blocks(m, axis_of(m), map);
    return edge == 0.0 || find_supports(map, edge, m->margin);
}

void height_map_close(height_map *map)
{
    free(map->supports);
    free(map->blocks);
    *map = (height_map){0};
}

// SPDX-License-Identifier: MIT
// Bodies are taken by ascending height. A map has, for each cell of the plane below them, the
// bodies there that a later one can still stand on: what a body stands on is in the cells that it
// covers.
#include "runtime/dynamics/column.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A body as the map sees it.
typedef struct block {
    double bottom, top;     // of the line through the centre
    double at[2], reach[2]; // centre and half extents of its bounds in the plane
    uint32_t id;
    column on; // the column that it is the top of
} block;

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

typedef struct height_map {
    block *blocks; // [n] by ascending bottom
    uint32_t n;
    uint32_t n_flat; // axes of the plane
    double edge;     // of a cell
    cell *cells;     // [mask + 1] open addressing, at most half of them used
    uint64_t mask, n_cells;
    cell_entry *entries; // [n_entries] of all cells
    uint64_t n_entries;
} height_map;

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
    block b = {.bottom = middle - height, .top = middle + height, .id = id};
    int flat = 0;
    for (int k = 0; k < (int)m->def.dims; ++k) {
        if (k == axis)
            continue;
        b.at[flat] = centre_of(m, id, k);
        b.reach[flat] = half_bounds(&p, k) + radius;
        width = fmin(width, 2.0 * b.reach[flat++]);
    }
    b.on = (column){.layers = 1, .edge = width * width / (2.0 * height)};
    return b;
}

static int by_bottom(const void *x, const void *y)
{
    const block *a = x, *b = y;
    if (a->bottom != b->bottom)
        return a->bottom < b->bottom ? -1 : 1;
    return a->id < b->id ? -1 : 1;
}

// Bodies that can stand: not flat ones, on which nothing has a width.
static void list_blocks(const duet_motion *m, int axis, height_map *map)
{
    double up = m->def.gravity[axis] > 0.0 ? -1.0 : 1.0, sum = 0.0;
    for (uint32_t id = 0; id < m->n; ++id) {
        if (!(m->bodies[id].mass > 0.0f) || m->bodies[id].sensor)
            continue;
        block b = block_of(m, id, axis, up);
        double width = m->def.dims == 3 ? fmin(b.reach[0], b.reach[1]) : b.reach[0];
        if (!(b.on.edge > 0.0) || !isfinite(b.on.edge))
            continue;
        sum += 2.0 * width;
        map->blocks[map->n++] = b;
    }
    map->edge = map->n > 0 ? sum / map->n : 0.0;
    qsort(map->blocks, map->n, sizeof *map->blocks, by_bottom);
}

// ---------------------------------------------------------------- cells

typedef struct cell_range {
    int32_t from[2], to[2];
} cell_range;

// Farther ones share cells.
static int32_t cell_at(const height_map *map, double x)
{
    return (int32_t)fmax(-1e9, fmin(1e9, floor(x / map->edge)));
}

// The cells that a block covers; of a wide one those about its centre.
static cell_range cells_of(const height_map *map, const block *b)
{
    const double most = 8.0 * map->edge;
    cell_range r = {{0}, {0}};
    for (uint32_t k = 0; k < map->n_flat; ++k) {
        double reach = fmin(b->reach[k], most);
        r.from[k] = cell_at(map, b->at[k] - reach);
        r.to[k] = cell_at(map, b->at[k] + reach);
    }
    return r;
}

static uint64_t place_of(const height_map *map, const int32_t at[2])
{
    uint64_t h = (uint64_t)(uint32_t)at[0] * 0x9e3779b97f4a7c15u ^
                 (uint64_t)(uint32_t)at[1] * 0xc2b2ae3d27d4eb4fu;
    uint64_t i = (h ^ h >> 29) & map->mask;
    while (map->cells[i].used && memcmp(map->cells[i].at, at, sizeof map->cells[i].at) != 0)
        i = (i + 1) & map->mask;
    return i;
}

static bool grow_cells(height_map *map)
{
    const height_map old = *map;
    map->mask = 2 * old.mask + 1;
    map->cells = calloc(map->mask + 1, sizeof *map->cells);
    for (uint64_t i = 0; map->cells && i <= old.mask; ++i)
        if (old.cells[i].used)
            map->cells[place_of(map, old.cells[i].at)] = old.cells[i];
    free(old.cells);
    return map->cells;
}

// Finds a cell, or makes it; NULL: no memory.
static cell *find_cell(height_map *map, int32_t x, int32_t y)
{
    const int32_t at[2] = {x, y};
    if (2 * map->n_cells > map->mask && !grow_cells(map))
        return NULL;
    cell *c = &map->cells[place_of(map, at)];
    map->n_cells += !c->used;
    c->used = true;
    memcpy(c->at, at, sizeof at);
    return c;
}

static bool open_cells(height_map *map)
{
    uint64_t most = 0;
    for (uint32_t i = 0; i < map->n; ++i) {
        cell_range r = cells_of(map, &map->blocks[i]);
        most += (uint64_t)(r.to[0] - r.from[0] + 1) * (uint64_t)(r.to[1] - r.from[1] + 1);
    }
    map->mask = 1023;
    map->cells = calloc(map->mask + 1, sizeof *map->cells);
    map->entries = malloc((most + 1) * sizeof *map->entries);
    return map->cells && map->entries;
}

// ---------------------------------------------------------------- columns

// One may be pressed into the other, or lie between others below.
static bool stands_on(const height_map *map, const block *b, const block *below, double margin)
{
    double gap = b->bottom - below->top;
    double overlap = 0.5 * fmin(b->top - b->bottom, below->top - below->bottom);
    bool over = true;
    for (uint32_t k = 0; k < map->n_flat; ++k)
        over = over && fabs(b->at[k] - below->at[k]) < b->reach[k] + below->reach[k];
    return over && gap <= margin && gap >= -overlap;
}

// Puts a block on the column of the most layers, with the least edge, that it stands on in a cell.
// Blocks there that end too low for it end too low for all later ones.
static void look_below(height_map *map, block *b, cell *c, double margin)
{
    uint64_t *link = &c->first;
    while (*link) {
        cell_entry *e = &map->entries[*link - 1];
        const block *below = &map->blocks[e->block];
        if (stands_on(map, b, below, margin)) {
            if (below->on.layers >= b->on.layers)
                b->on.layers = below->on.layers + 1;
            b->on.edge = fmin(b->on.edge, below->on.edge);
        }
        if (b->bottom - below->top > margin)
            *link = e->next;
        else
            link = &e->next;
    }
}

static bool put_block(height_map *map, uint32_t place, double margin)
{
    block *b = &map->blocks[place];
    cell_range r = cells_of(map, b);
    for (int32_t x = r.from[0]; x <= r.to[0]; ++x)
        for (int32_t y = r.from[1]; y <= r.to[1]; ++y) {
            cell *c = find_cell(map, x, y);
            if (!c)
                return false;
            look_below(map, b, c, margin);
            map->entries[map->n_entries++] = (cell_entry){.block = place, .next = c->first};
            c->first = map->n_entries;
        }
    return true;
}

static int axis_of(const duet_motion *m)
{
    int axis = 0;
    for (int k = 1; k < (int)m->def.dims; ++k)
        if (fabs(m->def.gravity[k]) > fabs(m->def.gravity[axis]))
            axis = k;
    return axis;
}

bool column_find(const duet_motion *m, double (*need)(const duet_motion *m, const column *c),
                 column *found, duet_error *err)
{
    height_map map = {.n_flat = m->def.dims - 1,
                      .blocks = malloc(((size_t)m->n + 1) * sizeof *map.blocks)};
    *found = (column){0};
    if (map.blocks)
        list_blocks(m, axis_of(m), &map);
    bool ok = map.blocks && open_cells(&map);
    for (uint32_t i = 0; ok && i < map.n; ++i) {
        ok = put_block(&map, i, m->margin);
        const column *c = &map.blocks[i].on;
        if (found->layers == 0 || need(m, c) > need(m, found))
            *found = *c;
    }
    free(map.entries);
    free(map.cells);
    free(map.blocks);
    return ok ||
           error_set(err, DUET_STATUS_NO_MEMORY, "no memory to see how %u bodies stand", m->n);
}

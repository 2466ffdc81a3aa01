// pair_search_gpu.DIMS3.SHAPE0.GRID0.LEVELS0.ROTATED1.ACCURACY0.FUSED0.JOINED1.IDS0.WG128.BUF512.PER_ITEM1
#define DIMS 3
#define SHAPE 0
#define GRID 0
#define LEVELS 0
#define LANES 1
#define ROTATED 1
#define ORIGIN 0
#define ACCURACY 0
#define SORTED 1
#define FUSED 0
#define JOINED 1
#define IDS 0
#define CELLS_X 0
#define CELLS_Y 0
#define CELLS_Z 0
#define WG 128
#define BUF 512
#define PER_ITEM 1
#define PAIR_SEARCH_GPU_ARGS \
    __global const float4 *restrict bounds, \
    __global const float4 *restrict boxes, \
    __global const uint *restrict starts, \
    __constant const grid_level *levels, \
    uint n_levels, \
    uint n_cells, \
    uint key_from, \
    uint n_home_cells, \
    uint first, \
    uint last, \
    __global uint2 *restrict found, \
    uint found_capacity, \
    volatile __global uint *restrict counters
#line 1 "kernels/common.clh"
#line 1 "kernels/counters.h"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/narrowphase/object.clh"
#line 1 "kernels/grid/places.h"
#line 1 "kernels/grid/grid.clh"
#line 1 "kernels/narrowphase/sat.clh"
#line 1 "kernels/narrowphase/sat_double.clh"
#line 1 "kernels/narrowphase/boxes.clh"
#line 1 "kernels/grid/pair_search_gpu.cl.in"
// SPDX-License-Identifier: MIT
// Pairs whose bounds overlap, from objects in cell order.
//
// Within a level each pair is found from the object that comes first in that
// order, so half the neighbourhood is enough, and three cells side by side in x
// are one range: what follows in the own row, and the rows that
// gen/emit/stencil.lua gives, one in 2D and four in 3D. Pairs of two levels are
// found from the finer one. Pairs collect in local memory; one atomic takes places
// for many. With FUSED the group tests them there, and only what did not fit is
// listed for the narrow kernel.
//
//   bounds [n][BOUNDS_QUADS] lower xyz and the id, upper xyz and the level
//   boxes  [n][BOX_QUADS]    centre xyz first (poses)
//   starts [n_own_cells + 1] first of each cell from key_from on
//   found  [found_capacity]      pairs of places (IDS 0) or of ids (IDS 1), least id
//                            first: float may see (a, b) other than (b, a)
#define BOUNDS_QUADS BOUNDS_QUADS_OF(ORIGIN)

#if ORIGIN

// Bounds are each from their own cell. Rounding keeps order, so none that
// overlap are apart, and a and b agree on it.
static inline int4 bounds_apart(float4 lower_a, float4 upper_a, float4 lower_b, float4 upper_b, int4 cells)
{
    float4 shift = convert_float4(cells) * ORIGIN_EDGE;
    return (lower_a - upper_b > shift) | (upper_a - lower_b < shift);
}

#else

static inline int4 bounds_apart(float4 lower_a, float4 upper_a, float4 lower_b, float4 upper_b)
{
    return (lower_a > upper_b) | (lower_b > upper_a);
}

#endif

static inline bool none_of(int4 apart)
{
#if DIMS == 3
    return !any(apart.xyz);
#else
    return !any(apart.xy);
#endif
}

// ------------------------------------------------------------ pairs

// What a group has found and not yet given away.
typedef struct {
    __local uint2 *pairs;
    volatile __local uint *used;
    __local uint *base;
    __global uint2 *found; // where candidates are listed
    uint capacity;
    volatile __global uint *counters;
} pair_sink;

#define COUNT_FOUND (IDS ? COUNT_PAIRS : COUNT_CANDIDATES)

static inline void add_pair(pair_sink *sink, uint2 pair)
{
    uint slot = atomic_inc(sink->used);
    if (slot < BUF) {
        sink->pairs[slot] = pair;
    } else { // the buffer is full until the group gives it away
        uint to = reserve(sink->counters + COUNT_FOUND, 1);
        if (to < sink->capacity)
            sink->found[to] = pair;
    }
}

// Moves n pairs from local memory to a list; one atomic takes places for all.
static inline void list_pairs(const pair_sink *sink, __local const uint2 *pairs, uint n, __global uint2 *list,
                              uint capacity, volatile __global uint *counter)
{
    if (get_local_id(0) == 0)
        *sink->base = reserve(counter, n);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = get_local_id(0); k < n; k += WG) {
        uint to = *sink->base + k;
        if (to < capacity)
            list[to] = pairs[k];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

#if FUSED
// What a group does with its candidates where it found them.
typedef struct {
    __global const float4 *boxes;
    __local uint2 *colliding;
    volatile __local uint *n_colliding;
    __global uint2 *pairs;
    uint capacity;
    __global uint2 *undecided;
    uint undecided_capacity;
} tester;

static inline void test_pair(const tester *to, uint2 candidate, volatile __global uint *counters)
{
    uint id_a, id_b;
    box a = box_at(to->boxes, candidate.x, &id_a);
    box b = box_at(to->boxes, candidate.y, &id_b);
    decided v = answer(&a, &b);
    if (v.colliding) {
        to->colliding[atomic_inc(to->n_colliding)] = ordered(id_a, id_b);
    } else if (!v.separated) {
        uint slot = reserve(counters + COUNT_UNDECIDED, 1);
        if (slot < to->undecided_capacity)
            to->undecided[slot] = ordered(id_a, id_b);
    }
}

static inline void give_away(pair_sink *sink, const tester *to)
{
    uint n = min(*sink->used, (uint)BUF);
    if (get_local_id(0) == 0) { // behind the loop PoCL 3.1 would count nothing
        *to->n_colliding = 0;
        reserve(sink->counters + COUNT_TESTED, n);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = get_local_id(0); k < n; k += WG)
        test_pair(to, sink->pairs[k], sink->counters);
    barrier(CLK_LOCAL_MEM_FENCE);
    uint n_colliding = *to->n_colliding; // read behind the reset, PoCL 3.1 would drop that: docs/generation.md
    if (get_local_id(0) == 0)
        *sink->used = 0;
    list_pairs(sink, to->colliding, n_colliding, to->pairs, to->capacity, sink->counters + COUNT_PAIRS);
}
#else
static inline void give_away(pair_sink *sink)
{
    uint n = min(*sink->used, (uint)BUF);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0)
        *sink->used = 0;
    list_pairs(sink, sink->pairs, n, sink->found, sink->capacity, sink->counters + COUNT_FOUND);
}
#endif

// ------------------------------------------------------------ search

// The sorted objects, and how to find those of a cell.
typedef struct {
    __global const float4 *bounds;
#if SHAPE == SHAPE_POSES
    __global const float4 *boxes;
#endif
    __global const uint *starts;
    __constant const grid_level *levels;
    uint n_levels;
    uint key_from;
    uint n_cells; // entries of a hashed grid
} sorted;

// Whose neighbours are sought.
typedef struct {
    uint place;
    float4 lower;
    float4 upper;
#if ORIGIN
    int4 cell;
#endif
} seeker;

// Cells side by side.
typedef struct {
    uint level;
    uint y, z;
    uint left, right;
} row;

// The point that decides an object's cell.
static inline void set_point(const sorted *in, uint place, coord point[3])
{
#if ORIGIN
    float4 at = in->boxes[BOX_QUADS * (size_t)place];
    int4 cell = as_int4(in->boxes[BOX_QUADS * (size_t)place + 3]);
    const float offset[3] = {at.x, at.y, at.z};
    const int origin[3] = {cell.x, cell.y, cell.z};
    coords_of(offset, origin, in->levels, point);
#elif SHAPE == SHAPE_POSES
    float4 at = in->boxes[BOX_QUADS * (size_t)place];
    point[0] = at.x;
    point[1] = at.y;
    point[2] = at.z;
#else
    float4 at = in->bounds[2 * (size_t)place];
    point[0] = at.x;
    point[1] = at.y;
    point[2] = at.z;
#endif
}

// In a hashed grid other cells share the entries of those that are meant; in a
// dense one the cells need not be known.
static inline bool is_in(const sorted *in, uint place, const row *cells)
{
#if GRID == GRID_HASHED
    if (as_uint(in->bounds[BOUNDS_QUADS * (size_t)place + 1].w) != cells->level)
        return false;
    coord point[3];
    uint cell[3];
    set_point(in, place, point);
    cell_of(point, in->levels + cells->level, cell);
    return cell[0] >= cells->left && cell[0] <= cells->right && cell[1] == cells->y && cell[2] == cells->z;
#else
    return true;
#endif
}

// Whether the bounds of what lies there overlap.
static inline bool meets(const sorted *in, const seeker *me, uint place)
{
    float4 lower = in->bounds[BOUNDS_QUADS * (size_t)place];
    float4 upper = in->bounds[BOUNDS_QUADS * (size_t)place + 1];
#if ORIGIN
    int4 between = as_int4(in->bounds[BOUNDS_QUADS * (size_t)place + 2]) - me->cell;
    return none_of(bounds_apart(me->lower, me->upper, lower, upper, between));
#else
    return none_of(bounds_apart(me->lower, me->upper, lower, upper));
#endif
}

static inline void add_met(pair_sink *sink, const sorted *in, const seeker *me, uint place)
{
    uint mine = as_uint(me->lower.w), other = as_uint(in->bounds[BOUNDS_QUADS * (size_t)place].w);
#if IDS
    add_pair(sink, ordered(mine, other));
#else
    uint2 pair = (uint2)(me->place, place);
    add_pair(sink, mine < other ? pair : pair.yx);
#endif
}

static inline void search_range(pair_sink *sink, const sorted *in, const seeker *me, const row *cells, uint from,
                                uint to)
{
    for (uint place = from; place < to; ++place)
        if (meets(in, me, place) && is_in(in, place, cells))
            add_met(sink, in, me, place);
}

static inline void search_row(pair_sink *sink, const sorted *in, const seeker *me, const row *cells)
{
    uint key = row_key(cells->y, cells->z, in->levels + cells->level, cells->level) - in->key_from;
    uint first = key + cells->left, last = key + cells->right;
#if GRID == GRID_HASHED
    first &= in->n_cells - 1;
    last &= in->n_cells - 1;
    if (first > last) { // the row goes on at the table's begin
        search_range(sink, in, me, cells, in->starts[first], in->starts[in->n_cells]);
        first = 0;
    }
#endif
    search_range(sink, in, me, cells, in->starts[first], in->starts[last + 1]);
}

#if GRID == GRID_HASHED
// What follows in the own cell and the one to its right.
static inline void search_own_row(pair_sink *sink, const sorted *in, const seeker *me, const row *cells)
{
    uint key = row_key(cells->y, cells->z, in->levels + cells->level, cells->level);
    uint own = (key + cells->left) & (in->n_cells - 1);
    row rest = *cells;
    rest.right = cells->left;
    search_range(sink, in, me, &rest, me->place + 1, in->starts[own + 1]);
    rest.left = rest.right = cells->right;
    if (cells->left < cells->right)
        search_row(sink, in, me, &rest);
}
#endif

static inline void search_level(pair_sink *sink, const sorted *in, const seeker *me, uint level)
{
    __constant const grid_level *grid = in->levels + level;
    coord point[3];
    uint cell[3];
    set_point(in, me->place, point);
    cell_of(point, grid, cell);
    uint x = cell[0], y = cell[1], z = cell[2];
    int4 n = cells_of(grid);
    uint nx = (uint)n.x, ny = (uint)n.y, nz = (uint)n.z;
    uint left = x > 0 ? x - 1 : 0, right = x + 1 < nx ? x + 1 : x;
#if GRID == GRID_HASHED
    row cells = {level, y, z, x, right};
    search_own_row(sink, in, me, &cells);
    cells.left = left;
#line 291 "kernels/grid/pair_search_gpu.cl.in"
    if (y + 1 < ny) {
        cells.y = y + 1;
        cells.z = z;
        search_row(sink, in, me, &cells);
    }
#line 291 "kernels/grid/pair_search_gpu.cl.in"
    if (y > 0 && z + 1 < nz) {
        cells.y = y - 1;
        cells.z = z + 1;
        search_row(sink, in, me, &cells);
    }
#line 291 "kernels/grid/pair_search_gpu.cl.in"
    if (z + 1 < nz) {
        cells.y = y;
        cells.z = z + 1;
        search_row(sink, in, me, &cells);
    }
#line 291 "kernels/grid/pair_search_gpu.cl.in"
    if (y + 1 < ny && z + 1 < nz) {
        cells.y = y + 1;
        cells.z = z + 1;
        search_row(sink, in, me, &cells);
    }
#line 297 "kernels/grid/pair_search_gpu.cl.in"
#else
    // All look-ups are under way before the first range is searched.
    uint key = row_key(y, z, grid, level) - in->key_from;
    uint from_0 = me->place + 1, to_0 = in->starts[key + right + 1];
#line 303 "kernels/grid/pair_search_gpu.cl.in"
    uint from_1 = 0, to_1 = 0;
    if (y + 1 < ny) {
        key = row_key(y + 1, z, grid, level) - in->key_from;
        from_1 = in->starts[key + left];
        to_1 = in->starts[key + right + 1];
    }
#line 303 "kernels/grid/pair_search_gpu.cl.in"
    uint from_2 = 0, to_2 = 0;
    if (y > 0 && z + 1 < nz) {
        key = row_key(y - 1, z + 1, grid, level) - in->key_from;
        from_2 = in->starts[key + left];
        to_2 = in->starts[key + right + 1];
    }
#line 303 "kernels/grid/pair_search_gpu.cl.in"
    uint from_3 = 0, to_3 = 0;
    if (z + 1 < nz) {
        key = row_key(y, z + 1, grid, level) - in->key_from;
        from_3 = in->starts[key + left];
        to_3 = in->starts[key + right + 1];
    }
#line 303 "kernels/grid/pair_search_gpu.cl.in"
    uint from_4 = 0, to_4 = 0;
    if (y + 1 < ny && z + 1 < nz) {
        key = row_key(y + 1, z + 1, grid, level) - in->key_from;
        from_4 = in->starts[key + left];
        to_4 = in->starts[key + right + 1];
    }
#line 310 "kernels/grid/pair_search_gpu.cl.in"
#if JOINED
    // One loop over all ranges: lanes that run in step wait for the longest sum,
    // not for the longest of each. Who meets is a bit at first: what is done about it
    // would stop all lanes for each.
    uint shift_0 = from_0, end_0 = to_0 - from_0;
#line 316 "kernels/grid/pair_search_gpu.cl.in"
    uint shift_1 = from_1 - end_0, end_1 = end_0 + to_1 - from_1;
#line 316 "kernels/grid/pair_search_gpu.cl.in"
    uint shift_2 = from_2 - end_1, end_2 = end_1 + to_2 - from_2;
#line 316 "kernels/grid/pair_search_gpu.cl.in"
    uint shift_3 = from_3 - end_2, end_3 = end_2 + to_3 - from_3;
#line 316 "kernels/grid/pair_search_gpu.cl.in"
    uint shift_4 = from_4 - end_3, end_4 = end_3 + to_4 - from_4;
#line 323 "kernels/grid/pair_search_gpu.cl.in"
    uint end = end_4;
    for (uint from = 0; from < end; from += 32) {
        uint n = min(end - from, 32u), met = 0;
        for (uint i = 0; i < n; ++i) {
            uint k = from + i;
            met |= (uint)meets(in, me, k + (k >= end_3 ? shift_4 : (k >= end_2 ? shift_3 : (k >= end_1 ? shift_2 : (k >= end_0 ? shift_1 : shift_0))))) << i;
        }
        for (; met; met &= met - 1) {
            uint k = from + 31 - clz(met & -met);
            add_met(sink, in, me, k + (k >= end_3 ? shift_4 : (k >= end_2 ? shift_3 : (k >= end_1 ? shift_2 : (k >= end_0 ? shift_1 : shift_0)))));
        }
    }
#else
#line 337 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_0, to_0);
#line 337 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_1, to_1);
#line 337 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_2, to_2);
#line 337 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_3, to_3);
#line 337 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_4, to_4);
#line 339 "kernels/grid/pair_search_gpu.cl.in"
#endif
#endif
}

#if LEVELS
static inline void set_corners(const sorted *in, const seeker *me, coord lower[3], coord upper[3])
{
    const float from[3] = {me->lower.x, me->lower.y, me->lower.z}, to[3] = {me->upper.x, me->upper.y, me->upper.z};
#if ORIGIN
    const int cell[3] = {me->cell.x, me->cell.y, me->cell.z};
    coords_of(from, cell, in->levels, lower);
    coords_of(to, cell, in->levels, upper);
#else
    for (int k = 0; k < 3; ++k) {
        lower[k] = from[k];
        upper[k] = to[k];
    }
#endif
}

static inline void search_coarser(pair_sink *sink, const sorted *in, const seeker *me, uint level)
{
    __constant const grid_level *grid = in->levels + level;
    row cells = {level, 0, 0, 0, 0};
    coord lower[3], upper[3];
    set_corners(in, me, lower, upper);
    uint y_from, y_to, z_from = 0, z_to = 0;
    cells_along(lower[0], upper[0], grid->reach.x, LOWER(grid, x), grid->per_cell.x, grid->cells.x, &cells.left,
                &cells.right);
    cells_along(lower[1], upper[1], grid->reach.y, LOWER(grid, y), grid->per_cell.y, grid->cells.y, &y_from, &y_to);
#if DIMS == 3
    cells_along(lower[2], upper[2], grid->reach.z, LOWER(grid, z), grid->per_cell.z, grid->cells.z, &z_from, &z_to);
#endif
    for (cells.z = z_from; cells.z <= z_to; ++cells.z)
        for (cells.y = y_from; cells.y <= y_to; ++cells.y)
            search_row(sink, in, me, &cells);
}
#endif

static inline void search_around(pair_sink *sink, const sorted *in, uint place)
{
    seeker me = {place, in->bounds[BOUNDS_QUADS * (size_t)place], in->bounds[BOUNDS_QUADS * (size_t)place + 1]};
#if ORIGIN
    me.cell = as_int4(in->bounds[BOUNDS_QUADS * (size_t)place + 2]);
#endif
    uint level = LEVELS ? as_uint(me.upper.w) : 0;
    search_level(sink, in, &me, level);
#if LEVELS
    while (++level < in->n_levels)
        search_coarser(sink, in, &me, level);
#endif
}

// Where the entry of a place begins: parts that each sorted for themselves
// agree on it, though not on the order inside a cell.
static inline uint entry_begin(const sorted *in, uint place, uint end)
{
    if (place == 0 || place >= end)
        return min(place, end);
    uint level = as_uint(in->bounds[BOUNDS_QUADS * (size_t)place + 1].w);
    coord point[3];
    set_point(in, place, point);
    return in->starts[key_in(point, in->levels + level, level, in->n_cells) - in->key_from];
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
pair_search_gpu(PAIR_SEARCH_GPU_ARGS)
{
    __local uint2 collected[BUF];
    __local uint used;
    __local uint base;
    pair_sink sink = {collected, &used, &base, found, found_capacity, counters};
#if FUSED
    __local uint2 colliding[BUF];
    __local uint n_colliding;
    tester to = {boxes, colliding, &n_colliding, pairs, pair_capacity, undecided, undecided_capacity};
#endif
#if SHAPE == SHAPE_POSES
    sorted in = {bounds, boxes, starts, levels, n_levels, key_from, n_cells};
#else
    sorted in = {bounds, starts, levels, n_levels, key_from, n_cells};
#endif
    if (get_local_id(0) == 0)
        used = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    uint home = starts[n_home_cells];
    uint end = entry_begin(&in, last, home);
    uint tile = entry_begin(&in, first, home) + get_group_id(0) * WG * PER_ITEM;
    for (; tile < end; tile += get_num_groups(0) * WG * PER_ITEM) {
        for (uint round = 0; round < PER_ITEM; ++round) {
            uint place = tile + round * WG + get_local_id(0);
            if (place < end)
                search_around(&sink, &in, place);
            barrier(CLK_LOCAL_MEM_FENCE);
            if (used > BUF / 2 || round + 1 == PER_ITEM)
#if FUSED
                give_away(&sink, &to);
#else
                give_away(&sink);
#endif
            barrier(CLK_LOCAL_MEM_FENCE);
        }
    }
}

// pair_search_simd.DIMS3.SHAPE0.ROTATED1.ACCURACY0.GRID0.LEVELS0.ROOMY0.FUSED1.BUF512.AHEAD0.PER_ITEM1024
#define DIMS 3
#define SHAPE 0
#define ROTATED 1
#define ORIGIN 0
#define ACCURACY 0
#define GRID 0
#define LEVELS 0
#define ROOMY 0
#define FUSED 1
#define LANES 8
#define WG 1
#define BUF 512
#define AHEAD 0
#define PER_ITEM 1024
#define PAIR_SEARCH_SIMD_ARGS \
    __global const float *restrict bounds, \
    uint place_capacity, \
    __global const float *restrict boxes, \
    __global const uint *restrict starts, \
    __constant const grid_level *levels, \
    uint n_levels, \
    uint n_cells, \
    uint key_from, \
    uint n_home_cells, \
    uint n_own_cells, \
    uint first, \
    uint last, \
    __global uint2 *restrict found, \
    uint found_capacity, \
    __global uint2 *restrict undecided, \
    uint undecided_capacity, \
    volatile __global uint *restrict counters
#line 1 "kernels/common.clh"
#line 1 "kernels/counters.h"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/narrowphase/object.clh"
#line 1 "kernels/grid/places.h"
#line 1 "kernels/grid/grid.clh"
#line 1 "kernels/narrowphase/sat.clh"
#line 1 "kernels/narrowphase/sat_double.clh"
#line 1 "kernels/narrowphase/box_rows.clh"
#line 1 "kernels/narrowphase/collide.clh"
#line 1 "kernels/grid/corners.clh"
#line 1 "kernels/grid/pair_search_simd.cl.in"
// SPDX-License-Identifier: MIT
// Objects in cell order to pairs, eight at a time.
//
// What is to be found, and from which of two objects, is as in
// pair_search_gpu.cl.in. Ranges of places collect until there are several, for
// most are shorter than a vector; the overlapping ones wait in private memory
// until there are enough of them, and are tested there (FUSED) or listed.
// Nothing is atomic but the taking of places for many pairs at once.
//
//   bounds    as reorder_simd leaves them
//   starts    [n_own_cells + 1] first of each cell from key_from on
//   boxes     as reorder_simd leaves them, or ids [n] for bounds
//   found     [found_capacity]     FUSED: pairs by id; else candidates, which are
//                              places, or for bounds ids
//   undecided [undecided_capacity] ids (FUSED)
#if ROOMY
#define RANGES 5
#define USED_RANGES(r) RANGES
#else
#define RANGES 8
#define USED_RANGES(r) (r)->n
#endif
#define LISTS_PAIRS (SHAPE == SHAPE_BOUNDS || ACCURACY == AABB) // overlapping bounds are the answer
#define ROUND (RANGES * LANES) // most candidates that come at once
#define WAITING_CAPACITY (BUF + ROUND + AHEAD + LANES)

// Cells side by side.
typedef struct {
    uint level;
    uint y, z;
    uint left, right;
} row;

// Whose neighbours are sought.
typedef struct {
    uint place;
    float lower[DIMS];
    float upper[DIMS];
#if ORIGIN
    int cell[DIMS];
#endif
} seeker;

// Places that may hold neighbours.
typedef struct {
    uint n;
    uint from[RANGES];
    uint to[RANGES];
#if GRID == GRID_HASHED
    row cells[RANGES];
#endif
} ranges;

typedef struct {
    __global const float *bounds;
    size_t column;
    __global const uint *where;
    __global const uint *starts;
#if SHAPE == SHAPE_POSES
    __global const float *boxes;
#else
    __global const uint *ids;
#endif
    __constant const grid_level *levels;
    uint n_levels;
    uint n_cells;
    uint key_from;
    uint n_own_cells;
} sorted;

typedef struct {
    uint2 *waiting; // candidates: places, or ids for bounds
    uint n_waiting;
    uint n_tested;
#if FUSED
    collider to;
#else
    __global uint2 *found;
    uint capacity;
    volatile __global uint *counter;
#endif
} search;

// ------------------------------------------------------------ pairs

// Tests the first n of those waiting, or lists them.
static inline void give_away(search *s, uint n)
{
#if FUSED
    uint2 found[BUF + ROUND + LANES];
    collide(&s->to, s->waiting, n, found);
    s->n_tested += n;
#else
    write_list(s->found, s->capacity, s->counter, s->waiting, n);
#endif
}

// Whole eights only; the rest go on waiting.
static inline void give_away_eights(search *s)
{
    uint n = s->n_waiting / LANES * LANES;
    give_away(s, n);
    for (uint k = n; k < s->n_waiting; ++k)
        s->waiting[k - n] = s->waiting[k];
    s->n_waiting -= n;
}

// ------------------------------------------------------------ candidates

// The point that decides an object's cell, in every lane.
static inline void set_point(const sorted *in, uint place, coord point[3])
{
#if ORIGIN
    __global const float *box = in->boxes + (size_t)place * BOX_WORDS;
    real offset[3];
    whole cell[3];
    for (int k = 0; k < 3; ++k) {
        offset[k] = ALL(k < DIMS ? box[k] : 0.0f);
        cell[k] = (whole)(k < DIMS ? as_int(box[CELL_WORD + k]) : 0);
    }
    coords_of(offset, cell, in->levels, point);
#elif SHAPE == SHAPE_POSES
    __global const float *box = in->boxes + (size_t)place * BOX_WORDS;
    for (int k = 0; k < 3; ++k)
        point[k] = ALL(k < DIMS ? box[k] : 0.0f);
#else
    for (int k = 0; k < 3; ++k)
        point[k] = ALL(k < DIMS ? in->bounds[k * in->column + place] : 0.0f);
#endif
}

// In a hashed grid other cells share the entries of those that are meant.
static inline bool is_in(const sorted *in, uint place, const ranges *r, uint range)
{
#if GRID == GRID_HASHED
    const row *cells = r->cells + range;
    if (in->where[place] != cells->level)
        return false;
    coord point[3];
    word cell[3];
    set_point(in, place, point);
    cell_of(point, in->levels + cells->level, cell);
    uint x = cell[0].s0;
    return x >= cells->left && x <= cells->right && cell[1].s0 == cells->y && cell[2].s0 == cells->z;
#else
    return true;
#endif
}

// Which of eight places overlap along an axis. With ORIGIN bounds are each from
// their own cell; rounding keeps order, so that none is lost.
static inline mask overlap_along(const sorted *in, const seeker *me, __global const float *at, int k)
{
    real lower = vload8(0, at + k * in->column), upper = vload8(0, at + (DIMS + k) * in->column);
#if ORIGIN
    whole cells = as_whole(vload8(0, at + (2 * DIMS + 1 + k) * in->column)) - me->cell[k];
    real shift = to_real(cells) * ORIGIN_EDGE;
    return ~((me->lower[k] - upper > shift) | (me->upper[k] - lower < shift));
#else
    return (lower <= me->upper[k]) & (upper >= me->lower[k]);
#endif
}

// Bit 8 k + r: lane k of range r overlaps.
static inline ulong overlapping(const sorted *in, const seeker *me, const ranges *r)
{
    ulong bits = 0;
#if ROOMY
#pragma unroll
#endif
    for (uint range = 0; range < USED_RANGES(r); ++range) {
        __global const float *at = in->bounds + r->from[range];
        mask m = (mask)(-1);
#pragma unroll
        for (int k = 0; k < DIMS; ++k)
            m &= overlap_along(in, me, at, k);
        bits |= (lane_bits(m) & first_lanes(r->to[range] - r->from[range])) << range;
    }
    return bits;
}

// Moves each range to its next eight places; false once all are at their end.
static inline bool next_places(ranges *r)
{
    bool more = false;
#if ROOMY
#pragma unroll
#endif
    for (uint range = 0; range < USED_RANGES(r); ++range) {
        r->from[range] = min(r->from[range] + LANES, r->to[range]);
        more |= r->from[range] < r->to[range];
    }
    return more;
}

static inline void search_ranges(search *s, const sorted *in, const seeker *me, ranges *r)
{
    do {
        ulong bits = overlapping(in, me, r);
        while (bits) {
            uint bit = 63 - (uint)clz(bits);
            bits ^= 1ul << bit;
            uint place = r->from[bit % 8] + bit / 8;
            if (!is_in(in, place, r, bit % 8))
                continue;
#if SHAPE == SHAPE_POSES && ACCURACY != AABB
            s->waiting[s->n_waiting++] = (uint2)(me->place, place);
#elif SHAPE == SHAPE_POSES
            s->waiting[s->n_waiting++] = ordered(id_at(in->boxes, me->place), id_at(in->boxes, place));
#else
            s->waiting[s->n_waiting++] = ordered(in->ids[me->place], in->ids[place]);
#endif
        }
        if (s->n_waiting > BUF)
            give_away_eights(s);
    } while (next_places(r));
}

// ------------------------------------------------------------ neighbours

#if ROOMY

// The entry that an object belongs to.
static inline uint entry_of(const sorted *in, uint place)
{
    return in->where[place];
}

// The places of three cells side by side, the middle one given. Behind the last
// entry of the grid there is nothing, and three more that say so.
static inline void set_range(const sorted *in, ranges *r, uint i, uint middle)
{
    uint4 begins = vload4(0, in->starts + min(middle, in->n_own_cells + 1) - 1);
    r->from[i] = begins.s0;
    r->to[i] = begins.s3;
}

// What follows in the own row, and the rows after it, by their entries alone.
//
// A roomy grid needs no border case: a row that leaves the grid goes on in one
// so far away that nothing overlaps, and no cell comes twice.
static inline void search_around(search *s, const sorted *in, const seeker *me)
{
    uint entry = in->where[me->place];
    uint nx = (uint)in->levels->cells.x, ny = (uint)in->levels->cells.y;
    ranges r = {.n = RANGES};
    r.from[0] = me->place + 1;
    r.to[0] = in->starts[entry + 2];
    const uint y = 0, z = 0; // relative to the own cell
#line 251 "kernels/grid/pair_search_simd.cl.in"
    set_range(in, &r, 1, entry + ((z) * ny + (y + 1)) * nx);
#line 251 "kernels/grid/pair_search_simd.cl.in"
    set_range(in, &r, 2, entry + ((z + 1) * ny + (y - 1)) * nx);
#line 251 "kernels/grid/pair_search_simd.cl.in"
    set_range(in, &r, 3, entry + ((z + 1) * ny + (y)) * nx);
#line 251 "kernels/grid/pair_search_simd.cl.in"
    set_range(in, &r, 4, entry + ((z + 1) * ny + (y + 1)) * nx);
#line 253 "kernels/grid/pair_search_simd.cl.in"
    search_ranges(s, in, me, &r);
}

#else

static inline uint entry_of(const sorted *in, uint place)
{
    uint level = in->where[place];
    coord point[3];
    set_point(in, place, point);
    return key_in(point, in->levels + level, level, in->n_cells).s0 - in->key_from;
}

static inline void add_range(search *s, const sorted *in, const seeker *me, ranges *r, const row *cells, uint from,
                             uint to)
{
    if (from >= to)
        return;
    r->from[r->n] = from;
    r->to[r->n] = to;
#if GRID == GRID_HASHED
    r->cells[r->n] = *cells;
#endif
    if (++r->n == RANGES) {
        search_ranges(s, in, me, r);
        r->n = 0;
    }
}

static inline uint row_entry(const sorted *in, const row *cells)
{
    return row_key((word)(cells->y), (word)(cells->z), in->levels + cells->level, cells->level).s0 - in->key_from;
}

static inline void add_row(search *s, const sorted *in, const seeker *me, ranges *r, const row *cells)
{
    uint entry = row_entry(in, cells);
    uint first = entry + cells->left, last = entry + cells->right;
#if GRID == GRID_HASHED
    first &= in->n_cells - 1;
    last &= in->n_cells - 1;
    if (first > last) { // the row goes on at the table's begin
        add_range(s, in, me, r, cells, in->starts[first], in->starts[in->n_cells]);
        first = 0;
    }
#endif
    add_range(s, in, me, r, cells, in->starts[first], in->starts[last + 1]);
}

// What follows in the own cell and the one to its right.
static inline void add_own_row(search *s, const sorted *in, const seeker *me, ranges *r, const row *cells)
{
    uint entry = row_entry(in, cells);
#if GRID == GRID_HASHED
    uint own = (entry + cells->left) & (in->n_cells - 1);
    row rest = *cells;
    rest.right = cells->left;
    add_range(s, in, me, r, &rest, me->place + 1, in->starts[own + 1]);
    rest.left = rest.right = cells->right;
    if (cells->left < cells->right)
        add_row(s, in, me, r, &rest);
#else
    add_range(s, in, me, r, cells, me->place + 1, in->starts[entry + cells->right + 1]);
#endif
}

static inline void add_level(search *s, const sorted *in, const seeker *me, ranges *r, uint level)
{
    __constant const grid_level *grid = in->levels + level;
    coord point[3];
    word cell[3];
    set_point(in, me->place, point);
    cell_of(point, grid, cell);
    uint x = cell[0].s0, y = cell[1].s0, z = cell[2].s0;
    uint nx = (uint)grid->cells.x, ny = (uint)grid->cells.y, nz = (uint)grid->cells.z;
    row cells = {level, y, z, x, x + 1 < nx ? x + 1 : x};
    add_own_row(s, in, me, r, &cells);
    cells.left = x > 0 ? x - 1 : 0;
#line 332 "kernels/grid/pair_search_simd.cl.in"
    if (y + 1 < ny) {
        cells.y = y + 1;
        cells.z = z;
        add_row(s, in, me, r, &cells);
    }
#line 332 "kernels/grid/pair_search_simd.cl.in"
    if (y > 0 && z + 1 < nz) {
        cells.y = y - 1;
        cells.z = z + 1;
        add_row(s, in, me, r, &cells);
    }
#line 332 "kernels/grid/pair_search_simd.cl.in"
    if (z + 1 < nz) {
        cells.y = y;
        cells.z = z + 1;
        add_row(s, in, me, r, &cells);
    }
#line 332 "kernels/grid/pair_search_simd.cl.in"
    if (y + 1 < ny && z + 1 < nz) {
        cells.y = y + 1;
        cells.z = z + 1;
        add_row(s, in, me, r, &cells);
    }
#line 338 "kernels/grid/pair_search_simd.cl.in"
}

#if LEVELS

static inline void set_corners(const sorted *in, const seeker *me, coord lower[3], coord upper[3])
{
#if ORIGIN
    real from[3], to[3];
    whole cell[3];
    for (int k = 0; k < 3; ++k) {
        from[k] = ALL(k < DIMS ? me->lower[k] : 0.0f);
        to[k] = ALL(k < DIMS ? me->upper[k] : 0.0f);
        cell[k] = (whole)(k < DIMS ? me->cell[k] : 0);
    }
    coords_of(from, cell, in->levels, lower);
    coords_of(to, cell, in->levels, upper);
#else
    for (int k = 0; k < DIMS; ++k) {
        lower[k] = ALL(me->lower[k]);
        upper[k] = ALL(me->upper[k]);
    }
#endif
}

static inline void add_coarser(search *s, const sorted *in, const seeker *me, ranges *r, uint level)
{
    __constant const grid_level *grid = in->levels + level;
    row cells = {level, 0, 0, 0, 0};
    uint y_from, y_to, z_from = 0, z_to = 0;
    coord lower[3], upper[3];
    set_corners(in, me, lower, upper);
    cells_along(lower[0], upper[0], grid->reach.x, LOWER(grid, x), grid->per_cell.x, grid->cells.x, &cells.left,
                &cells.right);
    cells_along(lower[1], upper[1], grid->reach.y, LOWER(grid, y), grid->per_cell.y, grid->cells.y, &y_from, &y_to);
#if DIMS == 3
    cells_along(lower[2], upper[2], grid->reach.z, LOWER(grid, z), grid->per_cell.z, grid->cells.z, &z_from, &z_to);
#endif
    for (cells.z = z_from; cells.z <= z_to; ++cells.z)
        for (cells.y = y_from; cells.y <= y_to; ++cells.y)
            add_row(s, in, me, r, &cells);
}

#endif

static inline void search_around(search *s, const sorted *in, const seeker *me)
{
    ranges r = {.n = 0};
    uint level = LEVELS ? in->where[me->place] : 0;
    add_level(s, in, me, &r, level);
#if LEVELS
    while (++level < in->n_levels)
        add_coarser(s, in, me, &r, level);
#endif
    search_ranges(s, in, me, &r);
}

#endif

static inline seeker seeker_at(const sorted *in, uint place)
{
    seeker me = {.place = place};
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        me.lower[k] = in->bounds[k * in->column + place];
        me.upper[k] = in->bounds[(DIMS + k) * in->column + place];
#if ORIGIN
        me.cell[k] = as_int(in->bounds[(2 * DIMS + 1 + k) * in->column + place]);
#endif
    }
    return me;
}

// Where the entry of a place begins: parts that each sorted for themselves
// agree on it, though not on the order inside a cell.
static inline uint entry_begin(const sorted *in, uint place, uint end)
{
    return place < end ? in->starts[entry_of(in, place)] : end;
}

__kernel void pair_search_simd(PAIR_SEARCH_SIMD_ARGS)
{
    size_t column = COLUMN(place_capacity);
    sorted in = {bounds, column, (__global const uint *)bounds + 2 * DIMS * column, starts,
#if SHAPE == SHAPE_POSES
                 boxes,
#else
                 ids,
#endif
                 levels, n_levels, n_cells, key_from, n_own_cells};
    if (starts[n_own_cells] > place_capacity)
        return; // objects without a place: the grid is built again with a larger buffer
    uint2 waiting[WAITING_CAPACITY];
    for (uint k = 0; k < WAITING_CAPACITY; ++k)
        waiting[k] = (uint2)(0, 0); // what lies behind the last one is read
#if FUSED
    search s = {waiting, 0, 0, {boxes, found, found_capacity, undecided, undecided_capacity, counters}};
#else
    search s = {waiting, 0, 0, found, found_capacity, counters + (LISTS_PAIRS ? COUNT_PAIRS : COUNT_CANDIDATES)};
#endif
    uint home = starts[n_home_cells];
    uint end = entry_begin(&in, last, home);
    uint tile = entry_begin(&in, first, home) + get_global_id(0) * PER_ITEM;
    for (; tile < end; tile += get_global_size(0) * PER_ITEM) {
        for (uint place = tile; place < min(tile + PER_ITEM, end); ++place) {
            seeker me = seeker_at(&in, place);
            search_around(&s, &in, &me);
        }
    }
    give_away(&s, s.n_waiting);
#if FUSED
    reserve(counters + COUNT_TESTED, s.n_tested);
#endif
}

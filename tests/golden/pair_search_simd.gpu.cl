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
// pair_search_gpu.cl.in. In a roomy grid eight objects that follow each other look
// for neighbours together: for an object alone, most ranges of places are shorter
// than a vector. Else ranges collect until there are several. Candidates wait in
// private memory until there are enough of them, and are tested there (FUSED) or
// listed. Nothing is atomic but the taking of places for many pairs at once.
//
//   bounds    as reorder_simd leaves them
//   starts    [n_own_cells + 1] first of each cell from key_from on
//   boxes     as reorder_simd leaves them, or ids [n] for bounds
//   found     [found_capacity]     FUSED: pairs by id; else candidates, which are
//                              places, or for bounds ids
//   undecided [undecided_capacity] ids (FUSED)
#if ROOMY
#define BLOCKS 16
#define ROUND (BLOCKS * LANES * LANES) // most candidates that come at once
#define FAR 64 // places asked for before they are needed
#else
#define RANGES 8
#define ROUND (RANGES * LANES)
#endif
#define LISTS_PAIRS (SHAPE == SHAPE_BOUNDS || ACCURACY == AABB) // overlapping bounds are the answer
#define WAITING_CAPACITY (BUF + ROUND + AHEAD + LANES)

// Bounds of eight objects.
typedef struct {
    real lower[DIMS];
    real upper[DIMS];
#if ORIGIN
    whole cell[DIMS];
#endif
} corners;

#if ROOMY

// Whose neighbours are sought: up to eight places side by side.
typedef struct {
    uint place; // the first
    uint n;
} seekers;

// Places that may hold neighbours, eight by eight. Bit 8 k + i of wanted: place k of them may be
// a neighbour of seeker i.
typedef struct {
    uint n;
    uint from[BLOCKS + 2];
    ulong wanted[BLOCKS + 2];
} blocks;

#else

// Cells side by side.
typedef struct {
    uint level;
    uint y, z;
    uint left, right;
} row;

// Whose neighbours are sought, in every lane.
typedef struct {
    uint place;
    corners at;
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

#endif

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
    for (uint k = 0; k < AHEAD + LANES; ++k)
        s->waiting[s->n_waiting + k] = (uint2)(0, 0); // what lies behind the last one is read
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

// The bounds of one place, the i-th from `from`, in every lane.
static inline corners corners_of(const sorted *in, uint from, uint i)
{
    corners c;
    __global const float *at = in->bounds + from;
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        c.lower[k] = ALL(at[k * in->column + i]);
        c.upper[k] = ALL(at[(DIMS + k) * in->column + i]);
#if ORIGIN
        c.cell[k] = (whole)(as_int(at[(2 * DIMS + 1 + k) * in->column + i]));
#endif
    }
    return c;
}

// The bounds of eight places.
static inline corners corners_from(const sorted *in, uint place)
{
    corners c;
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        c.lower[k] = vload8(0, in->bounds + k * in->column + place);
        c.upper[k] = vload8(0, in->bounds + (DIMS + k) * in->column + place);
#if ORIGIN
        c.cell[k] = as_whole(vload8(0, in->bounds + (2 * DIMS + 1 + k) * in->column + place));
#endif
    }
    return c;
}

// The highest bit of a lane says that bounds are apart. With ORIGIN they are each from their own
// cell; rounding keeps order, so that no overlap is lost. Else a difference has the sign of what it
// is rounded from: only outer bounds can be infinite, and no upper one is -0.
static inline word apart(const corners *a, const corners *b)
{
    word m = (word)(0);
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
#if ORIGIN
        real shift = to_real(b->cell[k] - a->cell[k]) * ORIGIN_EDGE;
        m |= as_word((a->lower[k] - b->upper[k] > shift) | (a->upper[k] - b->lower[k] < shift));
#else
        m |= as_word(a->upper[k] - b->lower[k]) | as_word(b->upper[k] - a->lower[k]);
#endif
    }
    return m;
}

static inline uint2 candidate(const sorted *in, uint first, uint second)
{
#if SHAPE == SHAPE_POSES && ACCURACY != AABB
    return (uint2)(first, second);
#elif SHAPE == SHAPE_POSES
    return ordered(id_at(in->boxes, first), id_at(in->boxes, second));
#else
    return ordered(in->ids[first], in->ids[second]);
#endif
}

// ------------------------------------------------------------ neighbours

#if ROOMY

// Rows of cells around them must not meet: all are in fewer cells than a row has, less three.
static inline seekers seekers_at(const sorted *in, uint place, uint end)
{
    word beyond = as_word(vload8(0, in->where + place)) - in->where[place];
    ulong near = lane_bits(beyond <= (word)((uint)in->levels->cells.x - 3)) & first_lanes(end - place);
    return (seekers){place, (uint)popcount(near)};
}

// Bit 8 k + i: the object k places after `from` overlaps seeker i.
static inline ulong overlapping(const sorted *in, uint first, uint from)
{
    const corners theirs = corners_from(in, from);
    word bits = (word)(0);
#pragma unroll
    for (uint i = 0; i < 8; ++i) {
        corners mine = corners_of(in, first, i);
        bits |= apart(&mine, &theirs) >> (31 - i) & (word)(1 << i);
    }
    return ~as_ulong(convert_uchar8(bits));
}

// No processor foresees how many bits a block has, so those of all blocks are taken in one loop. Each
// word is read before it is known to be needed, and volatile, lest a compiler do so in a branch.
static inline void search_blocks(search *s, const sorted *in, const seekers *me, blocks *b)
{
    uint n = 0, n_found = 0;
    for (uint i = 0; i < b->n; ++i) {
        uint from = b->from[i];
        ulong bits = overlapping(in, me->place, from) & b->wanted[i];
        b->from[n] = from;
        b->wanted[n] = bits;
        n += bits != 0;
        n_found += (uint)popcount(bits);
    }
    uint2 *to = s->waiting + s->n_waiting;
    s->n_waiting += n_found;
    b->wanted[n] = 0;
    volatile const ulong *left = b->wanted;
    ulong bits = left[0], next = left[1];
    uint at = 0;
    for (uint i = 0; i < n_found; ++i) {
        uint bit = 63 - (uint)clz(bits & -bits);
        to[i] = candidate(in, me->place + bit % 8, b->from[at] + bit / 8);
        bits &= bits - 1;
        at += bits == 0;
        bits = bits ? bits : next;
        next = left[at + 1];
    }
    b->n = 0;
    if (s->n_waiting > BUF)
        give_away_eights(s);
}

static inline void add_block(blocks *b, ulong wanted, uint from, uint to)
{
    b->from[b->n] = from;
    b->wanted[b->n] = wanted & ~0ul >> (64 - 8 * min(to - from, (uint)LANES)) % 64;
    b->n += from < to;
}

// Mostly two blocks hold a row.
static inline void add_places(search *s, const sorted *in, const seekers *me, blocks *b, ulong wanted, uint from,
                              uint to)
{
    for (; from < to; from += 2 * LANES) {
        if (b->n > BLOCKS - 2)
            search_blocks(s, in, me, b);
        add_block(b, wanted, from, to);
        add_block(b, wanted, from + LANES, to);
    }
}

#if AHEAD
static inline void ask_for_places(const sorted *in, uint place)
{
    for (uint k = 0; k < BOUNDS_COLUMNS_OF(DIMS, ORIGIN); ++k)
        ask_for(in->bounds + k * in->column + place);
#if SHAPE == SHAPE_POSES
    for (uint k = 0; k < LANES; ++k)
        ask_for(in->boxes + ((size_t)place + k) * BOX_WORDS);
#endif
}
#endif

// What follows in the own row, and the rows after it, by their entries alone. Behind the
// last entry of the grid there is nothing, and three more that say so.
//
// A roomy grid needs no border case: a row that leaves the grid goes on in one
// so far away that nothing overlaps, and no cell comes twice.
static inline void search_around(search *s, const sorted *in, const seekers *me)
{
    uint first = in->where[me->place], last = in->where[me->place + me->n - 1];
    uint nx = (uint)in->levels->cells.x, ny = (uint)in->levels->cells.y;
    ulong all = 0x0101010101010101ul * ((1u << me->n) - 1);
    uint behind = in->n_own_cells + 1;
    uint step, from, to = in->starts[last + 2];
    blocks b = {.n = 0};
    add_block(&b, all & 0xff7f3f1f0f070301ul, me->place + 1, to); // places that follow a seeker
    add_places(s, in, me, &b, all, me->place + 1 + LANES, to);
    const uint y = 0, z = 0; // relative to the own cell
#line 303 "kernels/grid/pair_search_simd.cl.in"
    step = ((z) * ny + (y + 1)) * nx;
    from = in->starts[min(first + step, behind) - 1];
    to = in->starts[min(last + step, behind) + 2];
    add_places(s, in, me, &b, all, from, to);
#line 303 "kernels/grid/pair_search_simd.cl.in"
    step = ((z + 1) * ny + (y - 1)) * nx;
    from = in->starts[min(first + step, behind) - 1];
    to = in->starts[min(last + step, behind) + 2];
    add_places(s, in, me, &b, all, from, to);
#line 303 "kernels/grid/pair_search_simd.cl.in"
    step = ((z + 1) * ny + (y)) * nx;
    from = in->starts[min(first + step, behind) - 1];
    to = in->starts[min(last + step, behind) + 2];
    add_places(s, in, me, &b, all, from, to);
#line 303 "kernels/grid/pair_search_simd.cl.in"
    step = ((z + 1) * ny + (y + 1)) * nx;
    from = in->starts[min(first + step, behind) - 1];
    to = in->starts[min(last + step, behind) + 2];
    add_places(s, in, me, &b, all, from, to);
#line 308 "kernels/grid/pair_search_simd.cl.in"
#if AHEAD
    ask_for_places(in, to + FAR); // the last row is the first to come there
#endif
    search_blocks(s, in, me, &b);
}

// The entry that an object belongs to.
static inline uint entry_of(const sorted *in, uint place)
{
    return in->where[place];
}

#else

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

// Bit 8 k + r: lane k of range r overlaps.
static inline ulong overlapping(const sorted *in, const seeker *me, const ranges *r)
{
    ulong bits = 0;
    for (uint range = 0; range < r->n; ++range) {
        corners at = corners_from(in, r->from[range]);
        bits |= (lane_bits(!(as_whole(apart(&me->at, &at)) < 0)) & first_lanes(r->to[range] - r->from[range])) << range;
    }
    return bits;
}

// Moves each range to its next eight places; false once all are at their end.
static inline bool next_places(ranges *r)
{
    bool more = false;
    for (uint range = 0; range < r->n; ++range) {
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
            s->waiting[s->n_waiting++] = candidate(in, me->place, place);
        }
        if (s->n_waiting > BUF)
            give_away_eights(s);
    } while (next_places(r));
}

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
#line 475 "kernels/grid/pair_search_simd.cl.in"
    if (y + 1 < ny) {
        cells.y = y + 1;
        cells.z = z;
        add_row(s, in, me, r, &cells);
    }
#line 475 "kernels/grid/pair_search_simd.cl.in"
    if (y > 0 && z + 1 < nz) {
        cells.y = y - 1;
        cells.z = z + 1;
        add_row(s, in, me, r, &cells);
    }
#line 475 "kernels/grid/pair_search_simd.cl.in"
    if (z + 1 < nz) {
        cells.y = y;
        cells.z = z + 1;
        add_row(s, in, me, r, &cells);
    }
#line 475 "kernels/grid/pair_search_simd.cl.in"
    if (y + 1 < ny && z + 1 < nz) {
        cells.y = y + 1;
        cells.z = z + 1;
        add_row(s, in, me, r, &cells);
    }
#line 481 "kernels/grid/pair_search_simd.cl.in"
}

#if LEVELS

static inline void set_corners(const sorted *in, const seeker *me, coord lower[3], coord upper[3])
{
#if ORIGIN
    real from[3], to[3];
    whole cell[3];
    for (int k = 0; k < 3; ++k) {
        from[k] = k < DIMS ? me->at.lower[k] : ALL(0.0f);
        to[k] = k < DIMS ? me->at.upper[k] : ALL(0.0f);
        cell[k] = k < DIMS ? me->at.cell[k] : (whole)(0);
    }
    coords_of(from, cell, in->levels, lower);
    coords_of(to, cell, in->levels, upper);
#else
    for (int k = 0; k < DIMS; ++k) {
        lower[k] = me->at.lower[k];
        upper[k] = me->at.upper[k];
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
#if FUSED
    search s = {waiting, 0, 0, {boxes, found, found_capacity, undecided, undecided_capacity, counters}};
#else
    search s = {waiting, 0, 0, found, found_capacity, counters + (LISTS_PAIRS ? COUNT_PAIRS : COUNT_CANDIDATES)};
#endif
    uint home = starts[n_home_cells];
    uint end = entry_begin(&in, last, home);
    uint tile = entry_begin(&in, first, home) + get_global_id(0) * PER_ITEM;
    for (; tile < end; tile += get_global_size(0) * PER_ITEM) {
#if ROOMY
        uint tile_end = min(tile + PER_ITEM, end);
        for (uint place = tile; place < tile_end;) {
            seekers me = seekers_at(&in, place, tile_end);
            search_around(&s, &in, &me);
            place += me.n;
        }
#else
        for (uint place = tile; place < min(tile + PER_ITEM, end); ++place) {
            seeker me = {place, corners_of(&in, place, 0)};
            search_around(&s, &in, &me);
        }
#endif
    }
    give_away(&s, s.n_waiting);
#if FUSED
    reserve(counters + COUNT_TESTED, s.n_tested);
#endif
}

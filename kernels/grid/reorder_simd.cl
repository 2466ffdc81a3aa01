// SPDX-License-Identifier: MIT
// Moves the objects into cell order as a search over lanes reads them. Objects
// outside the grid come last in that order and stay away.
//
//   sizes  [n + 1] of the objects, where those are transforms (APART)
//@ if TO_PLACES == 1 then
//   keys   [n]  cell, or NOWHERE
//   ranks  [n]  place in the cell
//@ else
//   ids    [n]  sorted by cell
//@ end
//   starts [n_own_cells + 1] the last one: how many are in the grid
//   next_counters [COUNTERS] become zero, for the next step
//   bounds [2 DIMS + 1][COLUMN(place_capacity)], with ORIGIN DIMS more
//   boxes  [COLUMN(place_capacity)][BOX_WORDS] (poses)

//@ if TO_PLACES == 1 then
// The next objects from *id on that have a place: eight, or those that are left, the last one
// again. False where there are none.
static inline bool next_eight(__global const uint *keys, __global const uint *ranks, __global const uint *starts,
                              uint place_capacity, uint *id, uint last, uint ids[LANES], uint places[LANES])
{
    uint n = 0;
    for (; *id < last && n < LANES; ++*id) {
        uint key = keys[*id];
        ids[n] = *id;
        places[n] = key == NOWHERE ? place_capacity : starts[key] + ranks[*id];
        n += places[n] < place_capacity;
    }
    for (uint k = n; k > 0 && k < LANES; ++k) {
        ids[k] = ids[n - 1];
        places[k] = places[n - 1];
    }
    return n > 0;
}

// Objects that are in the order of cells already have places side by side.
static inline void store_column(__global float *column, const uint places[LANES], real numbers)
{
    uint gaps = 0;
    for (uint k = 1; k < LANES; ++k)
        gaps |= places[k] ^ (places[0] + k);
    if (gaps == 0) {
        vstore8(numbers, 0, column + places[0]);
    } else {
        float each[LANES];
        vstore8(numbers, 0, each);
        for (uint k = 0; k < LANES; ++k)
            column[places[k]] = each[k];
    }
}

static inline void store_bounds(__global float *columns, size_t column, const uint places[LANES], const bounds *b,
                                word where)
{
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        store_column(columns + k * column, places, b->lower[k]);
        store_column(columns + (DIMS + k) * column, places, b->upper[k]);
    }
    store_column(columns + 2 * DIMS * column, places, as_real(where));
}
//@ else
// Places past the end are the last one again.
static inline void ids_from(__global const uint *ids, uint place, uint end, uint to[LANES])
{
    if (place + LANES <= end) {
        spread(vload8(0, ids + place), to);
    } else {
#pragma unroll
        for (uint k = 0; k < LANES; ++k)
            to[k] = ids[min(place + k, end - 1)];
    }
}

static inline void store_bounds(__global float *columns, size_t column, uint place, const bounds *b, word where)
{
#pragma unroll
    for (int k = 0; k < DIMS; ++k) {
        vstore8(b->lower[k], 0, columns + k * column + place);
        vstore8(b->upper[k], 0, columns + (DIMS + k) * column + place);
    }
    vstore8(as_real(where), 0, columns + 2 * DIMS * column + place);
}

// Asks for the rows of objects: half of them lie across two cache lines.
static inline void ask_for_rows(object_rows rows, const uint ids[LANES])
{
#pragma unroll
    for (uint k = 0; k < LANES; ++k) {
#if APART
        __global const float *from = rows.transforms + (size_t)ids[k] * OBJECT_STRIDE;
        ask_for(rows.sizes + (size_t)ids[k] * 3);
#else
        __global const float *from = rows + (size_t)ids[k] * OBJECT_STRIDE;
#endif
        ask_for(from);
        ask_for(from + OBJECT_STRIDE - 1);
    }
}
//@ end

typedef struct {
    ARG_FIELDS
} order;

// place: the places of the objects, or the first of them side by side.
//@ if TO_PLACES == 1 then
static inline void store_objects(const order *to, object_rows rows, const uint sources[LANES], const uint place[LANES])
//@ else
static inline void store_objects(const order *to, object_rows rows, const uint sources[LANES], uint place)
//@ end
{
    size_t column = COLUMN(to->place_capacity);
    object o = object_at(rows, sources);
    bounds b = object_bounds(&o);
#if SHAPE == SHAPE_BOUNDS
#pragma unroll
    for (int k = 0; k < DIMS; ++k)
        b.upper[k] += 0.0f; // never -0, from which 0 is taken: the search looks at a difference's sign
#endif
    check_extent(&o, to->levels, to->n_levels, to->counters);
#if ROOMY
    word where = object_key(&o, to->levels, to->n_levels, to->n_cells) - to->key_from;
#else
    word where = level_of(&o, to->levels, to->n_levels);
#endif
    store_bounds(to->sorted_bounds, column, place, &b, where);
#if ORIGIN
#pragma unroll
    for (int k = 0; k < DIMS; ++k)
//@ if TO_PLACES == 1 then
        store_column(to->sorted_bounds + (2 * DIMS + 1 + k) * column, place, as_real(o.cell[k]));
//@ else
        vstore8(as_real(o.cell[k]), 0, to->sorted_bounds + (2 * DIMS + 1 + k) * column + place);
//@ end
#endif
#if SHAPE == SHAPE_POSES
    box stored = box_of(&o);
    store_boxes(to->sorted_boxes, place, &stored, vload8(0, sources));
#endif
}

__kernel void reorder_simd(REORDER_SIMD_ARGS)
{
    const order to = {REORDER_SIMD_VALUES};
    object_rows rows = OBJECT_ROWS();
    uint placed = starts[n_own_cells];
    if (get_global_id(0) == 0) {
        counters[COUNT_PLACED] = placed;
        for (uint k = 0; k < COUNTERS; ++k)
            next_counters[k] = 0;
    }
//@ if TO_PLACES == 1 then
    uint id = get_global_id(0) * PER_ITEM;
//@ if STRETCH == 1 then
    id += n_hashed;
//@ end
    uint last = min(id + PER_ITEM, n);
    uint sources[LANES], place[LANES];
    while (next_eight(keys, ranks, starts, place_capacity, &id, last, sources, place)) {
//@ else
    uint end = min(placed, place_capacity);
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, end);
    for (uint place = first; place < last; place += LANES) {
        uint sources[LANES];
#if AHEAD
        ids_from(ids, place + AHEAD, end, sources);
        ask_for_rows(rows, sources);
#endif
        ids_from(ids, place, end, sources);
//@ end
        store_objects(&to, rows, sources, place);
    }
}

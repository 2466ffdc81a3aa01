// SPDX-License-Identifier: MIT
// Moves the objects into cell order, so that what is searched together lies
// together. Objects outside the grid have no place.
//
// FROM_IDS 1 reads the objects by the sorted ids, all over the input, and writes
// them one after the other; 0 reads one after the other and writes each to its
// place, which its cell's start and its rank there give.
//
//   sizes  [n + 1]           of the objects, where those are transforms (APART)
//   names  [n]               ids of the objects, where they are not all (PACKED)
//   ids    [n]               sorted by cell (FROM_IDS 1)
//   keys   [n]               cell, or NOWHERE (FROM_IDS 0)
//   ranks  [n]               (FROM_IDS 0)
//   starts [n_own_cells + 1] first of each cell; the last one: how many are in the grid
//   next_counters [COUNTERS]           become zero, for the next step
//   bounds [place_capacity][2]         lower xyz and the id, upper xyz and the level
//   boxes  [place_capacity][3]         centre xyz and the id, half extents, rotation (poses)
//
// With ORIGIN the rows of both end with the cell.
#define BOUNDS_QUADS BOUNDS_QUADS_OF(ORIGIN)
#define BOX_QUADS BOX_QUADS_OF(ORIGIN)

typedef struct {
    __constant const grid_level *levels;
    uint n_levels;
    __global float4 *bounds;
//@ if UNBOXED == 0 then
#if SHAPE == SHAPE_POSES
    __global float4 *boxes;
#endif
//@ end
    volatile __global uint *counters;
} order;

static inline void put(const order *to, size_t place, const object *o, uint id)
{
    bounds b = object_bounds(o);
    uint level = level_of(o, to->levels, to->n_levels);
    check_extent(o, to->levels, to->n_levels, to->counters);
    to->bounds[BOUNDS_QUADS * place] = (float4)(b.lower[0], b.lower[1], b.lower[2], as_float(id));
    to->bounds[BOUNDS_QUADS * place + 1] = (float4)(b.upper[0], b.upper[1], b.upper[2], as_float(level));
//@ if UNBOXED == 0 then
#if SHAPE == SHAPE_POSES
    to->boxes[BOX_QUADS * place] = (float4)(o->centre[0], o->centre[1], o->centre[2], as_float(id));
//@ if SHAPE >= 2 then
    to->boxes[BOX_QUADS * place + 1] = (float4)(o->halves[0], o->halves[1], o->halves[2], o->radius);
//@ else
    to->boxes[BOX_QUADS * place + 1] = (float4)(o->halves[0], o->halves[1], o->halves[2], 0.0f);
//@ end
    to->boxes[BOX_QUADS * place + 2] = (float4)(o->rotation[0], o->rotation[1], o->rotation[2], o->rotation[3]);
#endif
//@ end
#if ORIGIN
    float4 cell = as_float4((int4)(o->cell[0], o->cell[1], o->cell[2], 0));
    to->bounds[BOUNDS_QUADS * place + 2] = cell;
    to->boxes[BOX_QUADS * place + 3] = cell;
#endif
}

#if PACKED
#define ID_OF(object) names[object]
#else
#define ID_OF(object) (object)
#endif

__kernel void reorder(REORDER_ARGS)
{
//@ if UNBOXED == 1 then
    order to = {levels, n_levels, sorted_bounds, counters};
//@ else
#if SHAPE == SHAPE_POSES
    order to = {levels, n_levels, sorted_bounds, sorted_boxes, counters};
#else
    order to = {levels, n_levels, sorted_bounds, counters};
#endif
//@ end
    object_rows rows = OBJECT_ROWS();
    uint placed = starts[n_own_cells];
    if (get_global_id(0) == 0) {
        counters[COUNT_PLACED] = placed;
        for (uint k = 0; k < COUNTERS; ++k)
            next_counters[k] = 0;
    }
    uint first = get_global_id(0) * PER_ITEM;
#if FROM_IDS
    uint last = min(min(first + PER_ITEM, placed), place_capacity);
    for (uint base = first; base < last; base += BATCH) {
        // All reads of a batch are under way before the first is needed.
        object batch[BATCH];
        uint size = min(last - base, (uint)BATCH);
        for (uint k = 0; k < size; ++k) {
            uint id[1] = {ids[base + k]};
            batch[k] = object_at(rows, id);
        }
        for (uint k = 0; k < size; ++k)
            put(&to, base + k, &batch[k], ID_OF(ids[base + k]));
    }
#else
//@ if STRETCH == 1 then
    first += n_hashed;
//@ end
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        uint key = keys[id];
        uint place = key == NOWHERE ? place_capacity : starts[key] + ranks[id];
        if (place < place_capacity) {
            uint one[1] = {id};
            object o = object_at(rows, one);
            put(&to, place, &o, ID_OF(id));
        }
    }
#endif
}

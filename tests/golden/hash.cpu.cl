// hash.DIMS2.SHAPE0.ROTATED1.RANK1.WG1.PER_ITEM1024
#define DIMS 2
#define SHAPE 0
#define ROTATED 1
#define RANK 1
#define WG 1
#define PER_ITEM 1024
#line 1 "kernels/common.clh"
#line 1 "kernels/object.clh"
#line 1 "kernels/hash.cl"
// SPDX-License-Identifier: MIT
// The cell of each object (equation 2), and with RANK its place among those
// that came to the cell before it, for the counting sort.
//
//   objects  [n]          poses or bounds
//   keys     [n]          cell; a bad object gets the cell after the last
//   counts   [n_cells + 1] zeroed before; objects a cell (RANK)
//   ranks    [n]          (RANK)
__kernel void hash(__global const float *restrict objects, uint n, float4 lower, float4 per_cell,
                   int4 cells, uint n_cells, __global uint *restrict keys,
#if RANK
                   volatile __global uint *restrict counts, __global uint *restrict ranks,
#endif
                   volatile __global uint *restrict counters)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        object o = object_at(objects, id);
        uint key = n_cells;
        if (!object_is_bad(o)) {
            key = cell_key(object_centre(o), lower, per_cell, cells);
        } else {
            atomic_inc(counters + COUNT_BAD);
            atomic_max(counters + FIRST_BAD, ~id);
        }
        keys[id] = key;
#if RANK
        ranks[id] = atomic_inc(counts + key);
#endif
    }
}

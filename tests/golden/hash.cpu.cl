// hash.DIMS2.SHAPE0.ROTATED1.RANK1.LANES8.WG1.PER_ITEM1024
#define DIMS 2
#define SHAPE 0
#define ROTATED 1
#define RANK 1
#define LANES 8
#define WG 1
#define PER_ITEM 1024
#line 1 "kernels/common.clh"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/object.clh"
#line 1 "kernels/grid.clh"
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
    grid g = {lower, per_cell, cells};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint from = first; from < last; from += LANES) {
        uint ids[LANES], found[LANES];
        for (uint k = 0; k < LANES; ++k)
            ids[k] = min(from + k, last - 1);
        object o = object_at(objects, ids);
        spread(object_key(&o, object_is_bad(&o), g, n_cells), found);
        for (uint k = 0; k < LANES && from + k < last; ++k) {
            keys[from + k] = found[k];
#if RANK
            ranks[from + k] = atomic_inc(counts + found[k]);
#endif
            if (found[k] == n_cells) {
                atomic_inc(counters + COUNT_BAD);
                atomic_max(counters + FIRST_BAD, ~ids[k]);
            }
        }
    }
}

// hash.DIMS2.SHAPE0.ROTATED1.GRID0.LEVELS0.RANK1.LANES8.WG1.PER_ITEM1024
#define DIMS 2
#define SHAPE 0
#define ROTATED 1
#define GRID 0
#define LEVELS 0
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
// Only keys from key_from to key_to are of interest, the others' objects belong
// to the other device; keys are written relative to key_from.
//
//   objects  [n]  poses or bounds
//   levels   [n_levels]
//   keys     [n]  NOWHERE for an object that is bad or elsewhere
//   counts   [key_to - key_from] zeroed before; objects a cell (RANK)
//   ranks    [n]  (RANK)
__kernel void hash(__global const float *restrict objects, uint n, __constant const grid_level *levels, uint n_levels,
                   uint n_cells, uint key_from, uint key_to, __global uint *restrict keys,
#if RANK
                   volatile __global uint *restrict counts, __global uint *restrict ranks,
#endif
                   volatile __global uint *restrict counters)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint from = first; from < last; from += LANES) {
        uint ids[LANES], found[LANES], bad[LANES];
        for (uint k = 0; k < LANES; ++k)
            ids[k] = min(from + k, last - 1);
        object o = object_at(objects, ids);
        spread(object_key(&o, levels, n_levels, n_cells), found);
        mask is_bad = object_is_bad(&o);
        spread(as_word(is_bad), bad);
        for (uint k = 0; k < LANES && from + k < last; ++k) {
            uint key = NOWHERE;
            if (bad[k]) {
                atomic_inc(counters + COUNT_BAD);
                atomic_max(counters + FIRST_BAD, ~ids[k]);
            } else if (found[k] >= key_from && found[k] < key_to) {
                key = found[k] - key_from;
#if RANK
                ranks[from + k] = atomic_inc(counts + key);
#endif
            }
            keys[from + k] = key;
        }
    }
}

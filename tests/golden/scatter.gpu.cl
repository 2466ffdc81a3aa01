// scatter.WG256.PER_ITEM1
#define WG 256
#define PER_ITEM 1
#line 1 "kernels/common.clh"
#line 1 "kernels/grid/scatter.cl"
// SPDX-License-Identifier: MIT
// The last step of the counting sort: each id to its place.
//
//   starts [n_cells + 1] exclusive sums of the counts
//   ids    [starts[n_cells]] in cell order
#define NOWHERE 0xffffffffu

__kernel void scatter(__global const uint *restrict keys, __global const uint *restrict ranks,
                      uint n, __global const uint *restrict starts, __global uint *restrict ids)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id)
        if (keys[id] != NOWHERE)
            ids[starts[keys[id]] + ranks[id]] = id;
}

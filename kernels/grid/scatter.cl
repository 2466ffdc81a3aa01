// SPDX-License-Identifier: MIT
// The last step of the counting sort: each id to its place.
//
//   starts [n_cells + 1] exclusive sums of the counts
//   ids    [starts[n_cells]] in cell order
#define NOWHERE 0xffffffffu

__kernel void scatter(SCATTER_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
//@ if STRETCH == 1 then
    first += n_hashed;
//@ end
    uint last = min(first + PER_ITEM, n);
#ifdef POCL_DEVICE_ADDRESS_BITS // its compiler would gather and scatter eight, which takes twice as long
#pragma clang loop vectorize(disable)
#endif
    for (uint id = first; id < last; ++id)
        if (keys[id] != NOWHERE)
            ids[starts[keys[id]] + ranks[id]] = id;
}

// SPDX-License-Identifier: MIT
// The last step of the counting sort: each id to its place.
//
//   starts [n_cells + 1] exclusive sums of the counts
//   ids    [starts[n_cells]] in cell order
#define NOWHERE 0xffffffffu
//@ if SLAB == 1 then
#define BATCH 64
//@ end

__kernel void scatter(SCATTER_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
//@ if STRETCH == 1 then
    first += n_hashed;
//@ end
    uint last = min(first + PER_ITEM, n);
//@ if SLAB == 1 then
#if PER_ITEM > 1
    // Which half of all objects has a place is not to be foreseen: they are picked without a branch.
    for (uint from = first; from < last; from += BATCH) {
        uint picked[BATCH], n_picked = 0, to = min(from + BATCH, last);
        for (uint id = from; id < to; ++id) {
            picked[n_picked] = id;
            n_picked += keys[id] != NOWHERE;
        }
#ifdef POCL_DEVICE_ADDRESS_BITS // see below
#pragma clang loop vectorize(disable)
#endif
        for (uint k = 0; k < n_picked; ++k)
            ids[starts[keys[picked[k]]] + ranks[picked[k]]] = picked[k];
    }
    return;
#endif
//@ end
#ifdef POCL_DEVICE_ADDRESS_BITS // its compiler would gather and scatter eight, which takes twice as long
#pragma clang loop vectorize(disable)
#endif
    for (uint id = first; id < last; ++id)
        if (keys[id] != NOWHERE)
            ids[starts[keys[id]] + ranks[id]] = id;
}

// SPDX-License-Identifier: MIT
// Listed candidates to pairs (section 3), eight side by side.
//
//   boxes      as reorder_simd leaves them
//   candidates [*count]         pairs of places
//   pairs      [pair_capacity]      ids
//   undecided  [undecided_capacity] ids
__kernel void narrow_simd(NARROW_SIMD_ARGS)
{
    collider to = {boxes, pairs, pair_capacity, undecided, undecided_capacity, counters};
    uint2 waiting[PER_ITEM + AHEAD + LANES];
    uint2 found[PER_ITEM + LANES];
    for (uint k = 0; k < PER_ITEM + AHEAD + LANES; ++k)
        waiting[k] = (uint2)(0, 0); // what lies behind the last one is read
    uint n = counters[COUNT_CANDIDATES + 1] ? candidate_capacity : min(counters[COUNT_CANDIDATES], candidate_capacity);
    for (uint from = get_global_id(0) * PER_ITEM; from < n; from += get_global_size(0) * PER_ITEM) {
        uint size = min((uint)PER_ITEM, n - from);
        for (uint k = 0; k < size; ++k)
            waiting[k] = candidates[from + k];
        collide(&to, waiting, size, found);
    }
}

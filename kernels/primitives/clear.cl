// SPDX-License-Identifier: MIT
// Zeroes the counters, and of the counting sort the objects a cell, at once.
//
//   counters [n_counters]
//   counts   [n_counts]
__kernel void clear(CLEAR_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    for (uint i = first; i < min(first + PER_ITEM, n_counters); ++i)
        counters[i] = 0;
    for (uint i = first; i < min(first + PER_ITEM, n_counts); ++i)
        counts[i] = 0;
}

// SPDX-License-Identifier: MIT
// A group counts in local memory first, so that few counts meet in global memory.
__kernel void histogram(HISTOGRAM_ARGS)
{
    __local uint own[256];
    uint k = get_local_id(0);
    for (uint i = k; i < 256; i += WG)
        own[i] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    ulong from = first + (get_global_id(0) - k) * PER_ITEM;
    for (uint j = 0; j < PER_ITEM; ++j) {
        ulong i = from + j * WG + k;
        if (i < last)
            atomic_inc(&own[bytes[i]]);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = k; i < 256; i += WG)
        if (own[i] > 0)
            atomic_add(&counts[i], own[i]);
}

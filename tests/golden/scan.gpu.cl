// scan.WG256.PER_ITEM4
#define WG 256
#define PER_ITEM 4
#line 1 "kernels/common.clh"
#line 1 "kernels/scan.cl"
// SPDX-License-Identifier: MIT
// Exclusive prefix sum in place, in three launches: the sum of each block, the
// sums scanned by one group, then each block from its sum.
//
//   values [n]
//   sums   [n_blocks], a block being WG * PER_ITEM values
#define BLOCK (WG * PER_ITEM)

// Exclusive sum of one value a work-item over the group; *total is the whole.
static inline uint group_scan(uint value, __local uint *shared_sums, uint *total)
{
#if WG == 1
    *total = value;
    return 0;
#else
    uint me = get_local_id(0);
    shared_sums[me] = value;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint step = 1; step < WG; step <<= 1) {
        uint before = me >= step ? shared_sums[me - step] : 0;
        barrier(CLK_LOCAL_MEM_FENCE);
        shared_sums[me] += before;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    *total = shared_sums[WG - 1];
    uint inclusive = shared_sums[me];
    barrier(CLK_LOCAL_MEM_FENCE);
    return inclusive - value;
#endif
}

static inline uint sum_of(__global const uint *values, uint first, uint n)
{
    uint sum = 0;
    for (uint i = 0; i < PER_ITEM; ++i)
        if (first + i < n)
            sum += values[first + i];
    return sum;
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
scan_sums(__global const uint *restrict values, uint n, __global uint *restrict sums)
{
    __local uint shared_sums[WG];
    uint first = get_global_id(0) * PER_ITEM;
    uint total;
    group_scan(sum_of(values, first, n), shared_sums, &total);
    if (get_local_id(0) == 0)
        sums[get_group_id(0)] = total;
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
scan_tops(__global uint *restrict sums, uint n_blocks)
{
    __local uint shared_sums[WG];
    uint carry = 0;
    for (uint base = 0; base < n_blocks; base += WG) {
        uint at = base + get_local_id(0);
        uint total;
        uint before = group_scan(at < n_blocks ? sums[at] : 0, shared_sums, &total);
        if (at < n_blocks)
            sums[at] = carry + before;
        carry += total;
    }
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
scan_blocks(__global uint *restrict values, uint n, __global const uint *restrict sums)
{
    __local uint shared_sums[WG];
    uint first = get_global_id(0) * PER_ITEM;
    uint total;
    uint running = group_scan(sum_of(values, first, n), shared_sums, &total);
    running += sums[get_group_id(0)];
    for (uint i = 0; i < PER_ITEM; ++i) {
        if (first + i < n) {
            uint value = values[first + i];
            values[first + i] = running;
            running += value;
        }
    }
}

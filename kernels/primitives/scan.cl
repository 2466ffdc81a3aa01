// SPDX-License-Identifier: MIT
// Exclusive prefix sum in place, in three launches: the sum of each block, the
// sums scanned by one group, then each block from its sum.
//
//   values [n]
//   sums   [n_blocks], a block being WG * PER_ITEM values
//@ if EMPTIES == 1 then
//   to     [n] where the sums go; the values are zero then, so that they can be counted anew
//@ end
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

// Four at a time: n and first are multiples of four as long as PER_ITEM is, but
// for the end.
static inline uint sum_of(__global const uint *values, uint first, uint n)
{
    uint sum = 0;
    if (first + PER_ITEM <= n) {
        __global const uint4 *fours = (__global const uint4 *)(values + first);
        for (uint i = 0; i < PER_ITEM / 4; ++i)
            sum += fours[i].x + fours[i].y + fours[i].z + fours[i].w;
    } else {
        for (uint i = first; i < n; ++i)
            sum += values[i];
    }
    return sum;
}

// The sum of one value a work-item over the group, for all of it.
static inline uint group_sum(uint value, __local uint *shared_sums)
{
    uint total;
    group_scan(value, shared_sums, &total);
    return total;
}

// Replaces a work-item's values by their exclusive sums; `running` is that of all before. In a
// group four at a time, so that neighbours write whole sectors.
//@ if EMPTIES == 1 then
static inline void put_sums(__global uint *values, __global uint *to, uint first, uint n, uint running)
//@ else
static inline void put_sums(__global uint *values, uint first, uint n, uint running)
//@ end
{
    uint last = min(first + PER_ITEM, n), i = first;
//@ if WG > 1 then
    for (; i + 4 <= last; i += 4) {
        __global uint4 *four = (__global uint4 *)(values + i);
        uint4 of = *four;
        uint4 before = (uint4)(0, of.x, of.x + of.y, of.x + of.y + of.z) + running;
        running = before.w + of.w;
//@ if EMPTIES == 1 then
        *four = (uint4)(0);
        *(__global uint4 *)(to + i) = before;
//@ else
        *four = before;
//@ end
    }
//@ end
    for (; i < last; ++i) {
        uint value = values[i];
//@ if EMPTIES == 1 then
        values[i] = 0;
        to[i] = running;
//@ else
        values[i] = running;
//@ end
        running += value;
    }
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
scan_sums(SCAN_SUMS_ARGS)
{
    __local uint shared_sums[WG];
    uint total = group_sum(sum_of(values, get_global_id(0) * PER_ITEM, n), shared_sums);
    if (get_local_id(0) == 0)
        sums[get_group_id(0)] = total;
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
scan_tops(SCAN_TOPS_ARGS)
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

// What comes before this block: scanned already (use_tops 1), or to be added up
// here, which spares a launch where the blocks are few. All work-items meet at
// the sum's barriers whichever it is: LLVM 18 in PoCL 6.0 ends the process on a
// barrier behind an early return of a function that it inlines.
static inline uint before_block(__global const uint *sums, uint use_tops, __local uint *shared_sums)
{
    uint block = get_group_id(0);
    uint sum = 0;
    for (uint i = get_local_id(0); !use_tops && i < block; i += WG)
        sum += sums[i];
    uint total = group_sum(sum, shared_sums);
    return use_tops ? sums[block] : total;
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
scan_blocks(SCAN_BLOCKS_ARGS)
{
    __local uint shared_sums[WG];
    uint first = get_global_id(0) * PER_ITEM;
    uint total;
    uint running = before_block(sums, use_tops, shared_sums);
    running += group_scan(sum_of(values, first, n), shared_sums, &total);
//@ if EMPTIES == 1 then
    put_sums(values, to, first, n, running);
//@ else
    put_sums(values, first, n, running);
//@ end
}

// SPDX-License-Identifier: MIT
// Exclusive prefix sum in place. On a GPU in three launches: the sum of each block, the
// sums scanned by one group, then each block from its sum. On a CPU in one (scan_at_once).
//
//   values [n]
//   sums   [n_blocks], a block being WG * PER_ITEM values
//   told   [parts][2] a part's sum, and the stamp of its scan
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

// Four at a time: first is a multiple of four.
static inline uint sum_between(__global const uint *values, uint first, uint last)
{
    uint sum = 0, i = first;
    for (; i + 4 <= last; i += 4) {
        const uint4 four = *(__global const uint4 *)(values + i);
        sum += four.x + four.y + four.z + four.w;
    }
    for (; i < last; ++i)
        sum += values[i];
    return sum;
}

static inline uint sum_of(__global const uint *values, uint first, uint n)
{
    return sum_between(values, first, min(first + PER_ITEM, n));
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
static inline void put_sums(__global uint *values, __global uint *to, uint first, uint last, uint running)
//@ else
static inline void put_sums(__global uint *values, uint first, uint last, uint running)
//@ end
{
    uint i = first;
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
    const uint last = min(first + PER_ITEM, n);
//@ if EMPTIES == 1 then
    put_sums(values, to, first, last, running);
//@ else
    put_sums(values, first, last, running);
//@ end
}

// ------------------------------------------------------------ at once

// Looks at another's part before its values are added up again: it mostly is told within these.
#define LOOKS 1024

// Invariant: a part is told before its values are overwritten. So who finds it untold after reading its
// values has read them all as they were, and nobody waits.
static inline uint sum_of_part(__global const uint *values, volatile __global const uint *told, uint2 part, uint stamp)
{
    for (uint looks = 0; looks < LOOKS && told[1] != stamp; ++looks)
        ;
    if (told[1] != stamp) {
        order_memory();
        const uint sum = sum_between(values, part.x, part.y);
        order_memory();
        if (told[1] != stamp)
            return sum;
    }
    order_memory();
    return told[0];
}

static inline void tell(volatile __global uint *told, uint sum, uint stamp)
{
    told[0] = sum;
    order_memory();
    told[1] = stamp;
    order_memory();
}

static inline uint2 part_of(uint i, uint n)
{
    const uint parts = (uint)get_global_size(0), each = ((n - 1) / parts / 4 + 1) * 4, first = min(i * each, n);
    return (uint2)(first, min(first + each, n));
}

// Each work-item has a part.
__kernel void scan_at_once(SCAN_AT_ONCE_ARGS)
{
    const uint own = (uint)get_global_id(0);
    const uint2 part = part_of(own, n);
    uint running = 0;
    tell(told + 2 * own, sum_between(values, part.x, part.y), stamp);
    for (uint i = 0; i < own; ++i)
        running += sum_of_part(values, told + 2 * i, part_of(i, n), stamp);
//@ if EMPTIES == 1 then
    put_sums(values, to, part.x, part.y, running);
//@ else
    put_sums(values, part.x, part.y, running);
//@ end
}

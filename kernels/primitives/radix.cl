// SPDX-License-Identifier: MIT
// One pass of a stable radix sort of (key, id) by the BITS bits from `shift`.
//
// Each group owns a tile of WG * PER_ITEM consecutive elements and each
// work-item PER_ITEM consecutive ones of it, so that order within a digit is
// kept. radix_count writes how many of each digit a tile has, [digit][tile];
// their exclusive sum (scan.cl) is where the tile's first of that digit goes.
#define DIGITS (1u << BITS)
#define TILE (WG * PER_ITEM)

static inline uint digit_of(uint key, uint shift)
{
    return (key >> shift) & (DIGITS - 1);
}

// counts[digit * WG + me]: how many of the digit this work-item owns.
static inline void count_mine(__global const uint *keys, uint first, uint last, uint shift,
                              __local uint *counts)
{
    uint me = get_local_id(0);
    for (uint digit = 0; digit < DIGITS; ++digit)
        counts[digit * WG + me] = 0;
    for (uint i = first; i < last; ++i)
        counts[digit_of(keys[i], shift) * WG + me] += 1;
    barrier(CLK_LOCAL_MEM_FENCE);
}

__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
radix_count(RADIX_COUNT_ARGS)
{
    __local uint counts[DIGITS * WG];
    uint first = min((uint)get_global_id(0) * PER_ITEM, n);
    uint last = min(first + PER_ITEM, n);
    count_mine(keys_in, first, last, shift, counts);
    for (uint digit = get_local_id(0); digit < DIGITS; digit += WG) {
        uint sum = 0;
        for (uint i = 0; i < WG; ++i)
            sum += counts[digit * WG + i];
        tiles[digit * get_num_groups(0) + get_group_id(0)] = sum;
    }
}

// In the first pass the ids are the places themselves and ids_in is not read.
__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
radix_move(RADIX_MOVE_ARGS)
{
    __local uint counts[DIGITS * WG];
    uint first = min((uint)get_global_id(0) * PER_ITEM, n);
    uint last = min(first + PER_ITEM, n);
    uint me = get_local_id(0);
    count_mine(keys_in, first, last, shift, counts);
    for (uint digit = me; digit < DIGITS; digit += WG) {
        uint running = tiles[digit * get_num_groups(0) + get_group_id(0)];
        for (uint i = 0; i < WG; ++i) {
            uint count = counts[digit * WG + i];
            counts[digit * WG + i] = running;
            running += count;
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = first; i < last; ++i) {
        uint key = keys_in[i];
        uint slot = digit_of(key, shift) * WG + me;
        uint to = counts[slot];
        counts[slot] = to + 1;
        keys_out[to] = key;
        ids_out[to] = first_pass ? i : ids_in[i];
    }
}

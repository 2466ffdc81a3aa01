// SPDX-License-Identifier: MIT
// Counts the pairs that a search found, and adds up their hash (duet_pairs_hash) by global ids of
// 64 bits, which the first n_owned objects have, but for a few of them. Pairs with other objects
// are left to the host, which knows whose they are; but those of two objects behind the owned objects are
// nobody's here.
//
//   pairs       [as many as the counters say, pair_capacity at most]
//   global_ids  [n_owned]  low word, high word
//   id_changes  [n_id_changes]  an object and its id: low word, high word
//   left        [left_capacity]

__kernel void change_ids(CHANGE_IDS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n_id_changes);
    for (uint i = first; i < last; ++i)
        global_ids[id_changes[i].x] = id_changes[i].yz;
}

// A key of a pair, mixed.
static inline ulong mixed(ulong key)
{
    key *= 0x9E3779B97F4A7C15ul;
    key ^= key >> 29;
    key *= 0xBF58476D1CE4E5B9ul;
    return key ^ key >> 32;
}

static inline bool is_before(uint2 a, uint2 b)
{
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

static inline ulong hash_of(uint2 a, uint2 b)
{
    uint2 first = is_before(a, b) ? a : b, second = is_before(a, b) ? b : a;
    ulong low = (ulong)first.x << 32 | second.x;
    ulong high = (ulong)first.y << 32 | second.y;
    return mixed(low ^ mixed(high)); // that of 0 is 0
}

static inline bool has_none(uint2 id)
{
    return id.x == NO_GLOBAL_ID && id.y == NO_GLOBAL_ID;
}

// To two words that any number of work-items add to.
static inline void add_wide(volatile __global uint *to, ulong value)
{
    uint low = (uint)value;
    uint before = atomic_add(to, low);
    atomic_add(to + 1, (uint)(value >> 32) + (before + low < before ? 1u : 0u));
}

// A group's sums, of its first work-item alone.
static inline ulong2 sums_of_group(ulong2 own, __local ulong2 *sums)
{
#if WG > 1
    uint me = get_local_id(0);
    sums[me] = own;
    for (uint width = WG / 2; width > 0; width /= 2) {
        barrier(CLK_LOCAL_MEM_FENCE);
        if (me < width)
            sums[me] += sums[me + width];
    }
    return sums[0];
#else
    return own;
#endif
}

// A group's width apart, so that work-items side by side read pairs side by side.
__kernel __attribute__((reqd_work_group_size(WG, 1, 1))) void
count_pairs(COUNT_PAIRS_ARGS)
{
    __local ulong2 sums[WG];
    uint n = counters[COUNT_PAIRS + 1] ? pair_capacity : min(counters[COUNT_PAIRS], pair_capacity);
    uint first = get_group_id(0) * (WG * PER_ITEM);
    uint n_own = min(n - min(n, first), (uint)(WG * PER_ITEM));
    ulong2 own = (ulong2)(0, 0); // how many, and their hash
    for (uint i = get_local_id(0); i < n_own; i += WG) {
        uint2 pair = pairs[first + i];
        bool a_is_owned = pair.x < n_owned, b_is_owned = pair.y < n_owned;
        uint2 none = (uint2)(NO_GLOBAL_ID, NO_GLOBAL_ID);
        uint2 a = a_is_owned ? global_ids[pair.x] : none, b = b_is_owned ? global_ids[pair.y] : none;
        if (!has_none(a) && !has_none(b)) {
            own += (ulong2)(1, hash_of(a, b));
        } else if (a_is_owned || b_is_owned) {
            uint at = reserve(pair_counts + COUNT_LEFT, 1);
            if (at < left_capacity)
                left[at] = pair;
        }
    }
    own = sums_of_group(own, sums);
    if (get_local_id(0) == 0 && own.x > 0) {
        add_wide(pair_counts + COUNT_COUNTED, own.x);
        add_wide(pair_counts + COUNTED_HASH, own.y);
    }
}

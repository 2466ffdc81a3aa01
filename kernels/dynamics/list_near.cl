// SPDX-License-Identifier: MIT
// Own bodies of a domain whose bounds leave the first extent, or meet one of the others.
//
//   boxes    [n][6] lower xyz, upper xyz
//   places   [n] id, and bits of border.h
//   extents  [n_extents][6] likewise
//   near     a row of NEAR_WORDS with the number of bodies, and one for each of the first near_capacity:
//            place and bounds, in any order
static inline bool is_within(float3 lower, float3 upper, __global const float *extent)
{
    return all(lower >= vload3(0, extent)) && all(upper <= vload3(1, extent));
}

static inline bool do_meet(float3 lower, float3 upper, __global const float *extent)
{
    return all(lower <= vload3(1, extent)) && all(upper >= vload3(0, extent));
}

__kernel void list_near(LIST_NEAR_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        float3 lower = vload3(2 * (size_t)id, boxes), upper = vload3(2 * (size_t)id + 1, boxes);
        bool is_far = is_within(lower, upper, extents);
        for (uint k = 1; k < n_extents; ++k)
            is_far = is_far && !do_meet(lower, upper, extents + 6 * k);
        if (is_far || !(places[id].y & PLACE_OWN))
            continue;
        uint at = atomic_inc(near);
        if (at >= near_capacity)
            continue;
        __global uint *row = (__global uint *)near + NEAR_WORDS * ((size_t)at + 1);
        row[0] = id;
        vstore3(as_uint3(lower), 0, row + 1);
        vstore3(as_uint3(upper), 1, row + 1);
    }
}

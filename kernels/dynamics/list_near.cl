// SPDX-License-Identifier: MIT
// Own bodies of a domain that its host is told of: some travel, and others may be ghosts elsewhere.
//
//   boxes      [n][6] lower xyz, upper xyz
//   far_boxes  [n][6] likewise: further by far_margin, and by a body's way in far_time
//   places     [n] id, and bits of border.h
//   extents    [n_extents][6] likewise
//   near       a row of NEAR_WORDS with the number of bodies, and one for each of the first near_capacity: place
//              and bounds, in any order
//
//   list_near       those whose boxes leave the first extent, or meet one of the others
//   make_far_boxes  makes them, and lists bodies whose boxes leave the only extent; the first row then also has
//                   what all far boxes of others lie in that act, as sortable words: lower ones negated
//   list_meeting    those whose far boxes meet one of the extents
static inline bool is_within(float3 lower, float3 upper, __global const float *extent)
{
    return all(lower >= vload3(0, extent)) && all(upper <= vload3(1, extent));
}

static inline bool do_meet(float3 lower, float3 upper, __global const float *extent)
{
    return all(lower <= vload3(1, extent)) && all(upper >= vload3(0, extent));
}

static inline void tell_near(uint id, float3 lower, float3 upper, uint near_capacity, __global volatile uint *near)
{
    uint at = atomic_inc(near);
    if (at >= near_capacity)
        return;
    __global uint *row = (__global uint *)near + NEAR_WORDS * ((size_t)at + 1);
    row[0] = id;
    vstore3(as_uint3(lower), 0, row + 1);
    vstore3(as_uint3(upper), 1, row + 1);
}

__kernel void list_near(LIST_NEAR_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        float3 lower = vload3(2 * (size_t)id, boxes), upper = vload3(2 * (size_t)id + 1, boxes);
        bool is_far = is_within(lower, upper, extents);
        for (uint k = 1; k < n_extents; ++k)
            is_far = is_far && !do_meet(lower, upper, extents + 6 * k);
        if (!is_far && (places[id].y & PLACE_OWN))
            tell_near(id, lower, upper, near_capacity, near);
    }
}

__kernel void list_meeting(LIST_MEETING_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        float3 lower = vload3(2 * (size_t)id, far_boxes), upper = vload3(2 * (size_t)id + 1, far_boxes);
        bool meets = false;
        for (uint k = 0; k < n_extents; ++k)
            meets = meets || do_meet(lower, upper, extents + 6 * k);
        if (meets && (places[id].y & PLACE_OWN))
            tell_near(id, lower, upper, near_capacity, near);
    }
}

__kernel void make_far_boxes(MAKE_FAR_BOXES_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM, last = min(first + PER_ITEM, n);
    float3 least = (float3)(INFINITY), greatest = (float3)(-INFINITY);
    for (uint id = first; id < last; ++id) {
        float3 lower = vload3(2 * (size_t)id, boxes), upper = vload3(2 * (size_t)id + 1, boxes);
        uint kind = places[id].y;
        bool stays = is_within(lower, upper, extents);
        if (!stays && (kind & PLACE_OWN))
            tell_near(id, lower, upper, near_capacity, near);
        float3 way = convert_float3(velocities[id].xyz) * far_time;
        lower -= far_margin + fmax(-way, (float3)(0));
        upper += far_margin + fmax(way, (float3)(0));
        if (DIMS == 2)
            lower.z = upper.z = 0;
        vstore3(lower, 2 * (size_t)id, far_boxes);
        vstore3(upper, 2 * (size_t)id + 1, far_boxes);
        least = stays && decides(kind) ? fmin(least, lower) : least;
        greatest = stays && decides(kind) ? fmax(greatest, upper) : greatest;
    }
    raise_words(near + 1, -least);
    raise_words(near + 4, greatest);
}

// SPDX-License-Identifier: MIT
// The bounds of each object in the order of the input, as the paper's kernels
// read them, through the sorted ids.
//
//   objects      [n]    poses or bounds
//   bounds_by_id [n][2] lower and upper corner, rounded outward
__kernel void find_bounds(FIND_BOUNDS_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        uint ids[1] = {id};
        object o = object_at(objects, ids);
        if (object_is_bad(&o))
            continue;
        bounds b = object_bounds(&o);
        check_extent(&o, levels, n_levels, counters);
        bounds_by_id[2 * (size_t)id] = (float4)(b.lower[0], b.lower[1], b.lower[2], 0.0f);
        bounds_by_id[2 * (size_t)id + 1] = (float4)(b.upper[0], b.upper[1], b.upper[2], 0.0f);
    }
}

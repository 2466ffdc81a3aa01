// bounds.DIMS2.SHAPE0.ROTATED1.WG1.PER_ITEM1024
#define DIMS 2
#define SHAPE 0
#define ROTATED 1
#define WG 1
#define PER_ITEM 1024
#line 1 "kernels/common.clh"
#line 1 "kernels/object.clh"
#line 1 "kernels/bounds.cl"
// SPDX-License-Identifier: MIT
// The bounds of each object in the order of the input, as the paper's kernels
// read them, through the sorted ids.
//
//   objects [n]    poses or bounds
//   boxes   [n][2] lower and upper corner, rounded outward
__kernel void find_bounds(__global const float *restrict objects, uint n, float4 limit,
                          __global float4 *restrict boxes, volatile __global uint *restrict counters)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
        object o = object_at(objects, id);
        bounds b = no_bounds();
        if (!object_is_bad(o)) {
            b = object_bounds(o);
            check_extent(o, limit, counters);
        }
        boxes[2 * (size_t)id] = b.lower;
        boxes[2 * (size_t)id + 1] = b.upper;
    }
}

// reorder.DIMS2.SHAPE0.ROTATED1.WG1.PER_ITEM1024.BATCH16
#define DIMS 2
#define SHAPE 0
#define ROTATED 1
#define WG 1
#define PER_ITEM 1024
#define BATCH 16
#line 1 "kernels/common.clh"
#line 1 "kernels/object.clh"
#line 1 "kernels/reorder.cl"
// SPDX-License-Identifier: MIT
// Moves the objects into cell order, so that what is searched together lies
// together.
//
//   ids    [n]          sorted by cell
//   bounds [n][2]       lower xyz and the id, upper xyz and the cell
//   boxes  [n][3]       centre xyz and the id, half extents, rotation (poses)
__kernel void reorder(__global const float *restrict objects, __global const uint *restrict ids,
                      uint from, uint n, float4 lower, float4 per_cell, int4 cells, uint n_cells,
                      float4 limit, __global float4 *restrict sorted_bounds,
#if SHAPE == SHAPE_POSES
                      __global float4 *restrict sorted_boxes,
#endif
                      volatile __global uint *restrict counters)
{
    uint first = from + get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint base = first; base < last; base += BATCH) {
        // All reads of a batch are under way before the first is needed.
        object batch[BATCH];
        uint size = min(last - base, (uint)BATCH);
        for (uint k = 0; k < size; ++k)
            batch[k] = object_at(objects, ids[base + k]);
        for (uint k = 0; k < size; ++k) {
            uint id = ids[base + k];
            size_t i = base + k;
            object o = batch[k];
            bounds b = no_bounds();
            uint key = n_cells;
            if (!object_is_bad(o)) {
                b = object_bounds(o);
                key = cell_key(object_centre(o), lower, per_cell, cells);
                check_extent(o, limit, counters);
            }
            b.lower.w = as_float(id);
            b.upper.w = as_float(key);
            sorted_bounds[2 * i] = b.lower;
            sorted_bounds[2 * i + 1] = b.upper;
#if SHAPE == SHAPE_POSES
            o.centre.w = as_float(id);
            sorted_boxes[3 * i] = o.centre;
            sorted_boxes[3 * i + 1] = o.halves;
            sorted_boxes[3 * i + 2] = o.rotation;
#endif
        }
    }
}

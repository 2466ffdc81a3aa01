// reorder.DIMS3.SHAPE0.ROTATED1.GRID0.LEVELS0.WG256.PER_ITEM1.BATCH1
#define DIMS 3
#define SHAPE 0
#define ROTATED 1
#define GRID 0
#define LEVELS 0
#define LANES 1
#define WG 256
#define PER_ITEM 1
#define BATCH 1
#line 1 "kernels/common.clh"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/object.clh"
#line 1 "kernels/grid.clh"
#line 1 "kernels/reorder.cl"
// SPDX-License-Identifier: MIT
// Moves the objects into cell order, so that what is searched together lies
// together. What is not in the grid comes last in that order and stays away.
//
//   ids    [n]        sorted by cell
//   starts [n_own_cells + 1] the last one: how many are in the grid
//   bounds [room][2]  lower xyz and the id, upper xyz and the level
//   boxes  [room][3]  centre xyz and the id, half extents, rotation (poses)
__kernel void reorder(__global const float *restrict objects, __global const uint *restrict ids,
                      __global const uint *restrict starts, uint n_own_cells, uint room,
                      __constant const grid_level *levels, uint n_levels, __global float4 *restrict sorted_bounds,
#if SHAPE == SHAPE_POSES
                      __global float4 *restrict sorted_boxes,
#endif
                      volatile __global uint *restrict counters)
{
    uint placed = starts[n_own_cells];
    if (get_global_id(0) == 0)
        counters[COUNT_PLACED] = placed;
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(min(first + PER_ITEM, placed), room);
    for (uint base = first; base < last; base += BATCH) {
        // All reads of a batch are under way before the first is needed.
        object batch[BATCH];
        uint size = min(last - base, (uint)BATCH);
        for (uint k = 0; k < size; ++k) {
            uint id[1] = {ids[base + k]};
            batch[k] = object_at(objects, id);
        }
        for (uint k = 0; k < size; ++k) {
            float id = as_float(ids[base + k]);
            size_t i = base + k;
            object o = batch[k];
            bounds b = object_bounds(&o);
            uint level = level_of(&o, levels, n_levels);
            check_extent(&o, levels, n_levels, counters);
            sorted_bounds[2 * i] = (float4)(b.lower[0], b.lower[1], b.lower[2], id);
            sorted_bounds[2 * i + 1] = (float4)(b.upper[0], b.upper[1], b.upper[2], as_float(level));
#if SHAPE == SHAPE_POSES
            sorted_boxes[3 * i] = (float4)(o.centre[0], o.centre[1], o.centre[2], id);
            sorted_boxes[3 * i + 1] = (float4)(o.halves[0], o.halves[1], o.halves[2], 0.0f);
            sorted_boxes[3 * i + 2] = (float4)(o.rotation[0], o.rotation[1], o.rotation[2], o.rotation[3]);
#endif
        }
    }
}

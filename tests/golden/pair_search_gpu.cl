#ifndef GPU
// pair_search_gpu.DIMS2.SHAPE0.GRID0.LEVELS0.ROTATED1.ACCURACY0.FUSED0.JOINED0.IDS0.WG1.BUF512.PER_ITEM256
#define DIMS 2
#else /* GPU */
// pair_search_gpu.DIMS3.SHAPE0.GRID0.LEVELS0.ROTATED1.ACCURACY0.FUSED0.JOINED1.IDS0.WG128.BUF512.PER_ITEM1
#define DIMS 3
#endif /* GPU */
#define SHAPE 0
#define GRID 0
#define LEVELS 0
#define LANES 1
#define ROTATED 1
#define ORIGIN 0
#define ACCURACY 0
#define SORTED 1
#define FUSED 0
#ifndef GPU
#define JOINED 0
#else /* GPU */
#define JOINED 1
#endif /* GPU */
#define IDS 0
#define CELLS_X 0
#define CELLS_Y 0
#define CELLS_Z 0
#ifndef GPU
#define WG 1
#else /* GPU */
#define WG 128
#endif /* GPU */
#define BUF 512
#ifndef GPU
#define PER_ITEM 256
#else /* GPU */
#define PER_ITEM 1
#endif /* GPU */
#define PAIR_SEARCH_GPU_ARGS \
    __global const float4 *restrict bounds, \
    __global const float4 *restrict boxes, \
    __global const uint *restrict starts, \
    __constant const grid_level *levels, \
    uint n_levels, \
    uint n_cells, \
    uint key_from, \
    uint n_home_cells, \
    uint first, \
    uint last, \
    __global uint2 *restrict found, \
    uint found_capacity, \
    volatile __global uint *restrict counters
#line 1 "kernels/common.clh"
#line 1 "kernels/counters.h"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/narrowphase/object.clh"
#line 1 "kernels/grid/places.h"
#line 1 "kernels/grid/grid.clh"
#line 1 "kernels/narrowphase/sat.clh"
#line 1 "kernels/narrowphase/sat_double.clh"
#line 1 "kernels/narrowphase/boxes.clh"
#line 1 "kernels/grid/pair_search_gpu.cl.in"
// as in the template: 12
//   boxes  [n][BOX_QUADS]    centre xyz first (poses)
// as in the template: 1
//   found  [found_capacity]      pairs of places (IDS 0) or of ids (IDS 1), least id
// as in the template: 75
    __global const float4 *boxes;
// as in the template: 57
    __global const float4 *boxes;
// as in the template: 35
    float4 at = in->boxes[BOX_QUADS * (size_t)place];
// as in the template: 44
#if IDS
// as in the template: 67
#line 299 "kernels/grid/pair_search_gpu.cl.in"
    if (y + 1 < ny) {
        cells.y = y + 1;
#ifndef GPU
        cells.z = 0;
#else /* GPU */
        cells.z = z;
// as in the template: 2
#line 299 "kernels/grid/pair_search_gpu.cl.in"
    if (y > 0 && z + 1 < nz) {
        cells.y = y - 1;
        cells.z = z + 1;
// as in the template: 2
#line 299 "kernels/grid/pair_search_gpu.cl.in"
    if (z + 1 < nz) {
        cells.y = y;
        cells.z = z + 1;
// as in the template: 2
#line 299 "kernels/grid/pair_search_gpu.cl.in"
    if (y + 1 < ny && z + 1 < nz) {
        cells.y = y + 1;
        cells.z = z + 1;
#endif /* GPU */
// as in the template: 2
#line 305 "kernels/grid/pair_search_gpu.cl.in"
// as in the template: 15
#line 322 "kernels/grid/pair_search_gpu.cl.in"
    uint from_1 = 0, to_1 = 0;
    if (y + 1 < ny) {
#ifndef GPU
        key = row_key(y + 1, 0, grid, level) - in->key_from;
#else /* GPU */
        key = row_key(y + 1, z, grid, level) - in->key_from;
#endif /* GPU */
        from_1 = in->starts[key + left];
        to_1 = in->starts[key + right + 1];
// as in the template: 1
#ifdef GPU
#line 322 "kernels/grid/pair_search_gpu.cl.in"
    uint from_2 = 0, to_2 = 0;
    if (y > 0 && z + 1 < nz) {
        key = row_key(y - 1, z + 1, grid, level) - in->key_from;
        from_2 = in->starts[key + left];
        to_2 = in->starts[key + right + 1];
// as in the template: 1
#line 322 "kernels/grid/pair_search_gpu.cl.in"
    uint from_3 = 0, to_3 = 0;
    if (z + 1 < nz) {
        key = row_key(y, z + 1, grid, level) - in->key_from;
        from_3 = in->starts[key + left];
        to_3 = in->starts[key + right + 1];
// as in the template: 1
#line 322 "kernels/grid/pair_search_gpu.cl.in"
    uint from_4 = 0, to_4 = 0;
    if (y + 1 < ny && z + 1 < nz) {
        key = row_key(y + 1, z + 1, grid, level) - in->key_from;
        from_4 = in->starts[key + left];
        to_4 = in->starts[key + right + 1];
// as in the template: 1
#endif /* GPU */
#line 329 "kernels/grid/pair_search_gpu.cl.in"
// as in the template: 5
#line 335 "kernels/grid/pair_search_gpu.cl.in"
    uint shift_1 = from_1 - end_0, end_1 = end_0 + to_1 - from_1;
#ifdef GPU
#line 335 "kernels/grid/pair_search_gpu.cl.in"
    uint shift_2 = from_2 - end_1, end_2 = end_1 + to_2 - from_2;
#line 335 "kernels/grid/pair_search_gpu.cl.in"
    uint shift_3 = from_3 - end_2, end_3 = end_2 + to_3 - from_3;
#line 335 "kernels/grid/pair_search_gpu.cl.in"
    uint shift_4 = from_4 - end_3, end_4 = end_3 + to_4 - from_4;
#endif /* GPU */
#line 342 "kernels/grid/pair_search_gpu.cl.in"
#ifndef GPU
    uint end = end_1;
#else /* GPU */
    uint end = end_4;
#endif /* GPU */
// as in the template: 4
#ifndef GPU
            met |= (uint)meets(in, me, k + (k >= end_0 ? shift_1 : shift_0)) << i;
#else /* GPU */
            met |= (uint)meets(in, me, k + (k >= end_3 ? shift_4 : (k >= end_2 ? shift_3 : (k >= end_1 ? shift_2 : (k >= end_0 ? shift_1 : shift_0))))) << i;
#endif /* GPU */
// as in the template: 3
#ifndef GPU
            add_met(sink, in, me, k + (k >= end_0 ? shift_1 : shift_0));
#else /* GPU */
            add_met(sink, in, me, k + (k >= end_3 ? shift_4 : (k >= end_2 ? shift_3 : (k >= end_1 ? shift_2 : (k >= end_0 ? shift_1 : shift_0)))));
#endif /* GPU */
// as in the template: 3
#line 356 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_0, to_0);
#line 356 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_1, to_1);
#ifdef GPU
#line 356 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_2, to_2);
#line 356 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_3, to_3);
#line 356 "kernels/grid/pair_search_gpu.cl.in"
    search_range(sink, in, me, 0, from_4, to_4);
#endif /* GPU */
#line 358 "kernels/grid/pair_search_gpu.cl.in"
// as in the template: 76
    tester to = {boxes, colliding, &n_colliding, pairs, pair_capacity, undecided, undecided_capacity};
// as in the template: 2
    sorted in = {bounds, boxes, starts, levels, n_levels, key_from, n_cells};
// as in the template: 6
    uint home = starts[n_home_cells];
// as in the template: 18

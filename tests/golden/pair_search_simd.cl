#ifndef GPU
// pair_search_simd.DIMS2.SHAPE0.ROTATED1.ACCURACY0.GRID0.LEVELS0.ROOMY0.FUSED1.BUF512.AHEAD32.PER_ITEM1024
#define DIMS 2
#else /* GPU */
// pair_search_simd.DIMS3.SHAPE0.ROTATED1.ACCURACY0.GRID0.LEVELS0.ROOMY0.FUSED1.BUF512.AHEAD0.PER_ITEM1024
#define DIMS 3
#endif /* GPU */
#define SHAPE 0
#define ROTATED 1
#define ORIGIN 0
#define ACCURACY 0
#define GRID 0
#define LEVELS 0
#define ROOMY 0
#define FUSED 1
#define LANES 8
#define WG 1
#define BUF 512
#ifndef GPU
#define AHEAD 32
#else /* GPU */
#define AHEAD 0
#endif /* GPU */
#define PER_ITEM 1024
#define PAIR_SEARCH_SIMD_ARGS \
    __global const float *restrict bounds, \
    uint place_capacity, \
    __global const float *restrict boxes, \
    __global const uint *restrict starts, \
    __constant const grid_level *levels, \
    uint n_levels, \
    uint n_cells, \
    uint key_from, \
    uint n_home_cells, \
    uint n_own_cells, \
    uint first, \
    uint last, \
    __global uint2 *restrict found, \
    uint found_capacity, \
    __global uint2 *restrict undecided, \
    uint undecided_capacity, \
    volatile __global uint *restrict counters
#line 1 "kernels/common.clh"
#line 1 "kernels/counters.h"
#line 1 "kernels/lanes.clh"
#line 1 "kernels/narrowphase/object.clh"
#line 1 "kernels/grid/places.h"
#line 1 "kernels/grid/grid.clh"
#line 1 "kernels/narrowphase/sat.clh"
#line 1 "kernels/narrowphase/sat_double.clh"
#line 1 "kernels/narrowphase/box_rows.clh"
#line 1 "kernels/narrowphase/collide.clh"
#line 1 "kernels/grid/corners.clh"
#line 1 "kernels/grid/pair_search_simd.cl.in"
// as in the template: 301
#line 303 "kernels/grid/pair_search_simd.cl.in"
#ifndef GPU
    step = ((0) * ny + (y + 1)) * nx;
#else /* GPU */
    step = ((z) * ny + (y + 1)) * nx;
// as in the template: 3
#line 303 "kernels/grid/pair_search_simd.cl.in"
    step = ((z + 1) * ny + (y - 1)) * nx;
// as in the template: 3
#line 303 "kernels/grid/pair_search_simd.cl.in"
    step = ((z + 1) * ny + (y)) * nx;
// as in the template: 3
#line 303 "kernels/grid/pair_search_simd.cl.in"
    step = ((z + 1) * ny + (y + 1)) * nx;
#endif /* GPU */
// as in the template: 3
#line 308 "kernels/grid/pair_search_simd.cl.in"
// as in the template: 166
#line 475 "kernels/grid/pair_search_simd.cl.in"
    if (y + 1 < ny) {
        cells.y = y + 1;
#ifndef GPU
        cells.z = 0;
#else /* GPU */
        cells.z = z;
// as in the template: 2
#line 475 "kernels/grid/pair_search_simd.cl.in"
    if (y > 0 && z + 1 < nz) {
        cells.y = y - 1;
        cells.z = z + 1;
// as in the template: 2
#line 475 "kernels/grid/pair_search_simd.cl.in"
    if (z + 1 < nz) {
        cells.y = y;
        cells.z = z + 1;
// as in the template: 2
#line 475 "kernels/grid/pair_search_simd.cl.in"
    if (y + 1 < ny && z + 1 < nz) {
        cells.y = y + 1;
        cells.z = z + 1;
#endif /* GPU */
// as in the template: 2
#line 481 "kernels/grid/pair_search_simd.cl.in"
// as in the template: 106

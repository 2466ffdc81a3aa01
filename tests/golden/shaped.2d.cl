// shaped.DIMS2
#define DIMS 2
#line 1 "kernels/common.clh"
// What all test kernels share.
#line 1 "kernels/shaped.cl.in"
// Sums the rows of a neighbourhood, in 2 dimensions.
__kernel void shaped(__global const int *restrict starts, __global int *restrict sums, int4 cells)
{
    uint key = get_global_id(0);
    uint nx = (uint)cells.x;
#line 7 "kernels/shaped.cl.in"
    uint ny = (uint)cells.y, row_y = nx;
    uint y = key / row_y;
#line 10 "kernels/shaped.cl.in"
    int sum = starts[key];
#line 12 "kernels/shaped.cl.in"
    if (y + 1 < ny) // row 1
        sum += starts[key + row_y];
#line 15 "kernels/shaped.cl.in"
    sums[key] = sum;
}

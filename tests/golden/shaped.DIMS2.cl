// shaped.DIMS2
#define DIMS 2
#line 1 "kernels/common.clh"
// What all test kernels share.
#line 1 "kernels/shaped.cl.in"
// Sums the cells of a neighbourhood, in 2 dimensions.
__kernel void shaped(__global const int *restrict starts, __global int *restrict sums, uint nx,
                     uint ny, uint nz)
{
    uint key = get_global_id(0);
    uint row_y = nx, row_z = nx * ny;
    uint y = key / row_y % ny, z = key / row_z;
    int sum = starts[key];
#line 10 "kernels/shaped.cl.in"
    if (y + 1 < ny) // row 1
        sum += starts[key + row_y];
#line 13 "kernels/shaped.cl.in"
    sums[key] = sum;
}

// shaped.DIMS2
#define DIMS 2
#line 1 "kernels/common.clh"
// What all test kernels share.
#line 1 "kernels/shaped.cl.in"
// Sums the rows of a neighbourhood, in 2 dimensions.
__kernel void shaped(__global const int *restrict starts, __global int *restrict sums, int4 cells)
{
    uint key = get_global_id(0);
    uint nx = (uint)cells.x, ny = (uint)cells.y, nz = (uint)cells.z;
    uint y = key / nx % ny, z = key / nx / ny;
    int sum = starts[key];
#line 9 "kernels/shaped.cl.in"
    if (y + 1 < ny) // row 1
        sum += starts[((0) * ny + y + 1) * nx + key % nx];
#line 12 "kernels/shaped.cl.in"
    sums[key] = sum;
}

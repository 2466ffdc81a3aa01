// shaped.DIMS3
#define DIMS 3
#line 1 "kernels/common.clh"
// What all test kernels share.
#line 1 "kernels/shaped.cl.in"
// Sums the cells of a neighbourhood, in 3 dimensions.
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
#line 10 "kernels/shaped.cl.in"
    if (y > 0 && z + 1 < nz) // row 2
        sum += starts[key - row_y + row_z];
#line 10 "kernels/shaped.cl.in"
    if (z + 1 < nz) // row 3
        sum += starts[key + row_z];
#line 10 "kernels/shaped.cl.in"
    if (y + 1 < ny && z + 1 < nz) // row 4
        sum += starts[key + row_y + row_z];
#line 13 "kernels/shaped.cl.in"
    sums[key] = sum;
}

// shaped.DIMS3
#define DIMS 3
#line 1 "kernels/common.clh"
// What all test kernels share.
#line 1 "kernels/shaped.cl.in"
// Sums the rows of a neighbourhood, in 3 dimensions.
__kernel void shaped(__global const int *restrict starts, __global int *restrict sums, int4 cells)
{
    uint key = get_global_id(0);
    uint nx = (uint)cells.x;
#line 7 "kernels/shaped.cl.in"
    uint ny = (uint)cells.y, row_y = nx;
    uint y = key / row_y % ny;
#line 7 "kernels/shaped.cl.in"
    uint nz = (uint)cells.z, row_z = row_y * ny;
    uint z = key / row_z;
#line 10 "kernels/shaped.cl.in"
    int sum = starts[key];
#line 12 "kernels/shaped.cl.in"
    if (y + 1 < ny) // row 1
        sum += starts[key + row_y];
#line 12 "kernels/shaped.cl.in"
    if (y > 0 && z + 1 < nz) // row 2
        sum += starts[key - row_y + row_z];
#line 12 "kernels/shaped.cl.in"
    if (z + 1 < nz) // row 3
        sum += starts[key + row_z];
#line 12 "kernels/shaped.cl.in"
    if (y + 1 < ny && z + 1 < nz) // row 4
        sum += starts[key + row_y + row_z];
#line 15 "kernels/shaped.cl.in"
    sums[key] = sum;
}

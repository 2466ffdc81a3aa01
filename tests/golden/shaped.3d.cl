// shaped.DIMS3
#define DIMS 3
#line 1 "kernels/common.clh"
// What all test kernels share.
#line 1 "kernels/shaped.cl.in"
// Sums the rows of a neighbourhood, in 3 dimensions.
__kernel void shaped(__global const int *restrict starts, __global int *restrict sums, int4 cells)
{
    uint key = get_global_id(0);
    uint nx = (uint)cells.x, ny = (uint)cells.y, nz = (uint)cells.z;
    uint y = key / nx % ny, z = key / nx / ny;
    int sum = starts[key];
#line 9 "kernels/shaped.cl.in"
    if (y + 1 < ny) // row 1
        sum += starts[((z) * ny + y + 1) * nx + key % nx];
#line 9 "kernels/shaped.cl.in"
    if (y > 0 && z + 1 < nz) // row 2
        sum += starts[((z + 1) * ny + y - 1) * nx + key % nx];
#line 9 "kernels/shaped.cl.in"
    if (z + 1 < nz) // row 3
        sum += starts[((z + 1) * ny + y) * nx + key % nx];
#line 9 "kernels/shaped.cl.in"
    if (y + 1 < ny && z + 1 < nz) // row 4
        sum += starts[((z + 1) * ny + y + 1) * nx + key % nx];
#line 12 "kernels/shaped.cl.in"
    sums[key] = sum;
}

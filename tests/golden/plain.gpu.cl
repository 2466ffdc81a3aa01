// plain.FACTOR1.WG64.PER_ITEM4
#define FACTOR 1
#define SHIFT (-1)
#define WG 64
#define PER_ITEM 4
#line 1 "kernels/common.clh"
// What all test kernels share.
#line 1 "kernels/twice.clh"
#define TWICE(x) (2 * (x))
#line 1 "kernels/plain.cl"
// y = FACTOR x + SHIFT, PER_ITEM values a work-item.
__kernel void plain(__global const int *restrict x, __global int *restrict y, uint n)
{
    uint first = get_global_id(0) * PER_ITEM;
    for (uint i = first; i < min(first + PER_ITEM, n); ++i)
        y[i] = TWICE(x[i]) * FACTOR + SHIFT;
}

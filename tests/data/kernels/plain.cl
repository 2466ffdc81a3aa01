// y = FACTOR x + SHIFT, PER_ITEM values a work-item.
__kernel void plain(__global const int *restrict x, __global int *restrict y, uint n)
{
    uint first = get_global_id(0) * PER_ITEM;
    for (uint i = first; i < min(first + PER_ITEM, n); ++i)
        y[i] = TWICE(x[i]) * FACTOR + SHIFT;
}

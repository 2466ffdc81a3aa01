// SPDX-License-Identifier: MIT
__kernel void saxpy(SAXPY_ARGS)
{
    ulong from = first + get_global_id(0) * PER_ITEM;
    for (ulong i = from; i < from + PER_ITEM && i < last; ++i)
        y[i] = a * x[i] + y[i];
}

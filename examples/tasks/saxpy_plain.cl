// SPDX-License-Identifier: MIT
__kernel void saxpy_plain(SAXPY_PLAIN_ARGS)
{
    ulong i = first + get_global_id(0);
    if (i < last)
        y[i] = a * x[i] + y[i];
}

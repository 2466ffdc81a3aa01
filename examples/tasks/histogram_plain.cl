// SPDX-License-Identifier: MIT
__kernel void histogram_plain(HISTOGRAM_PLAIN_ARGS)
{
    ulong i = first + get_global_id(0);
    if (i < last)
        atomic_inc(&counts[bytes[i]]);
}

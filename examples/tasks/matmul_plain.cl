// SPDX-License-Identifier: MIT
__kernel void matmul_plain(MATMUL_PLAIN_ARGS)
{
    ulong u = first * n + get_global_id(0);
    if (u >= last * n)
        return;
    float sum = 0.0f;
    for (uint k = 0; k < n; ++k)
        sum += a[u / n * n + k] * b[(ulong)k * n + u % n];
    c[u] = sum;
}

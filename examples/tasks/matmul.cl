// SPDX-License-Identifier: MIT
// An item is a row of c, and a work-unit an element of it.
static inline float element(__global const float *a, __global const float *b, uint n, ulong u)
{
    ulong row = u / n * n, column = u % n;
    float sum = 0.0f;
    for (uint k = 0; k < n; ++k)
        sum = fma(a[row + k], b[(ulong)k * n + column], sum);
    return sum;
}

__kernel void matmul(MATMUL_ARGS)
{
    ulong u = first * n + get_global_id(0) * COLUMNS, end = last * n;
    ulong row = u / n * n, column = u % n;
    if (column + COLUMNS > n || u + COLUMNS > end) {
        for (ulong v = u; v < u + COLUMNS && v < end; ++v)
            c[v] = element(a, b, n, v);
        return;
    }
    float sums[COLUMNS];
    for (uint j = 0; j < COLUMNS; ++j)
        sums[j] = 0.0f;
    for (uint k = 0; k < n; ++k) {
        float left = a[row + k];
        __global const float *from = b + (ulong)k * n + column;
        for (uint j = 0; j < COLUMNS; ++j)
            sums[j] = fma(left, from[j], sums[j]);
    }
    for (uint j = 0; j < COLUMNS; ++j)
        c[u + j] = sums[j];
}

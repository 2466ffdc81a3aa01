// SPDX-License-Identifier: MIT
// An item is a row, and a work-unit a cell. No heat passes the borders.
__kernel void stencil(STENCIL_ARGS)
{
    ulong from = first * width + get_global_id(0) * PER_ITEM;
    for (ulong u = from; u < from + PER_ITEM && u < last * width; ++u) {
        uint x = (uint)(u % width);
        ulong y = u / width;
        float own = before[u];
        float left = x > 0 ? before[u - 1] : own;
        float right = x + 1 < width ? before[u + 1] : own;
        float above = y > 0 ? before[u - width] : own;
        float below = y + 1 < rows ? before[u + width] : own;
        after[u] = own + rate * (left + right + above + below - 4.0f * own);
    }
}

// SPDX-License-Identifier: MIT
// Each neighbour that lies on the grid brings its difference.
__kernel void stencil_plain(STENCIL_PLAIN_ARGS)
{
    ulong u = first * width + get_global_id(0);
    if (u >= last * width)
        return;
    ulong x = u % width, y = u / width;
    float flow = 0.0f;
    if (x > 0)
        flow += before[u - 1] - before[u];
    if (x + 1 < width)
        flow += before[u + 1] - before[u];
    if (y > 0)
        flow += before[u - width] - before[u];
    if (y + 1 < rows)
        flow += before[u + width] - before[u];
    after[u] = before[u] + rate * flow;
}

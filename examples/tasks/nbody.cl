// SPDX-License-Identifier: MIT
// A body is its position and, in w, its mass.
static inline float4 pull(float4 at, float4 other, float softening)
{
    float4 d = (float4)(other.xyz - at.xyz, 0.0f);
    float by = rsqrt(dot(d, d) + softening);
    return d * (other.w * by * by * by);
}

__kernel void nbody(NBODY_ARGS)
{
    ulong i = first + get_global_id(0);
    float4 at = bodies[min(i, (ulong)n - 1)];
    float4 sum = (float4)(0.0f);
#if TILE
    __local float4 tile[WG];
    uint k = get_local_id(0);
    for (uint from = 0; from < n; from += WG) {
        tile[k] = bodies[min(from + k, n - 1)];
        barrier(CLK_LOCAL_MEM_FENCE);
        uint most = min((uint)WG, n - from);
        for (uint j = 0; j < most; ++j)
            sum += pull(at, tile[j], softening);
        barrier(CLK_LOCAL_MEM_FENCE);
    }
#else
    for (uint j = 0; j < n; ++j)
        sum += pull(at, bodies[j], softening);
#endif
    if (i < last)
        acceleration[i] = sum;
}

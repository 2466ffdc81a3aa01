// SPDX-License-Identifier: MIT
// A body is its position and, in w, its mass.
#define BLOCK 256 // bodies that are summed by themselves, so that fewer roundings follow each other

static inline float4 pull(float4 at, float4 other, float softening)
{
    float4 d = (float4)(other.xyz - at.xyz, 0.0f);
    float by = rsqrt(d.x * d.x + d.y * d.y + d.z * d.z + softening);
    return d * (other.w * by * by * by);
}

__kernel void nbody(NBODY_ARGS)
{
    ulong i = first + get_global_id(0);
    float4 at = bodies[min(i, (ulong)n - 1)];
    float4 sum = (float4)(0.0f);
#if TILE
    __local float4 tile[BLOCK];
#endif
    for (uint from = 0; from < n; from += BLOCK) {
        float4 part = (float4)(0.0f);
        uint most = min((uint)BLOCK, n - from);
#if TILE
        for (uint j = get_local_id(0); j < most; j += WG)
            tile[j] = bodies[from + j];
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint j = 0; j < most; ++j)
            part += pull(at, tile[j], softening);
        barrier(CLK_LOCAL_MEM_FENCE);
#else
        for (uint j = 0; j < most; ++j)
            part += pull(at, bodies[from + j], softening);
#endif
        sum += part;
    }
    if (i < last)
        acceleration[i] = gravity * sum;
}

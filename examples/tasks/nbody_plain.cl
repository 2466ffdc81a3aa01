// SPDX-License-Identifier: MIT
__kernel void nbody_plain(NBODY_PLAIN_ARGS)
{
    ulong i = first + get_global_id(0);
    if (i >= last)
        return;
    float x = 0.0f, y = 0.0f, z = 0.0f;
    for (uint j = 0; j < n; ++j) {
        float dx = bodies[j].x - bodies[i].x;
        float dy = bodies[j].y - bodies[i].y;
        float dz = bodies[j].z - bodies[i].z;
        float squared = dx * dx + dy * dy + dz * dz + softening;
        float by = bodies[j].w / (squared * sqrt(squared));
        x += dx * by;
        y += dy * by;
        z += dz * by;
    }
    acceleration[i] = (float4)(x, y, z, 0.0f);
}

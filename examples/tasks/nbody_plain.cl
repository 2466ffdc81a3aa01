// SPDX-License-Identifier: MIT
// Adds with what was lost before (Kahan's sum), whose error does not grow with the number of terms.
static void add(float *sum, float *lost, float term)
{
    float more = term - *lost;
    float to = *sum + more;
    *lost = (to - *sum) - more;
    *sum = to;
}

__kernel void nbody_plain(NBODY_PLAIN_ARGS)
{
    ulong i = first + get_global_id(0);
    if (i >= last)
        return;
    float sum[3] = {0.0f, 0.0f, 0.0f}, lost[3] = {0.0f, 0.0f, 0.0f};
    for (uint j = 0; j < n; ++j) {
        float dx = bodies[j].x - bodies[i].x;
        float dy = bodies[j].y - bodies[i].y;
        float dz = bodies[j].z - bodies[i].z;
        float squared = dx * dx + dy * dy + dz * dz + softening;
        float by = bodies[j].w / (squared * sqrt(squared));
        add(&sum[0], &lost[0], dx * by);
        add(&sum[1], &lost[1], dy * by);
        add(&sum[2], &lost[2], dz * by);
    }
    acceleration[i] = gravity * (float4)(sum[0], sum[1], sum[2], 0.0f);
}

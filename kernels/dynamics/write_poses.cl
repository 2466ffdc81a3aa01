// SPDX-License-Identifier: MIT
// Where bodies are, as poses (narrowphase/object.clh) for a tree; what is hidden keeps its negative
// half extents.
//
//   poses [n][10] centre xyz, half extents xyz, quaternion xyzw
//@ if ROUNDED == 1 then
//   or    [n][11] the radius besides; row_words says which
//@ end
__kernel void write_poses(WRITE_POSES_ARGS)
{
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    for (uint id = first; id < last; ++id) {
//@ if ROUNDED == 1 then
        __global float *pose = poses + (size_t)id * row_words;
        if (row_words > 10)
            pose[10] = halves[id].w;
//@ else
        __global float *pose = poses + (size_t)id * 10;
//@ end
#if ROTATED
        float4 rotation = convert_float4(rotations[id]);
#else
        float4 rotation = (float4)(0.0f, 0.0f, 0.0f, 1.0f);
#endif
        vstore3(convert_float4(centres[id]).xyz, 0, pose);
        vstore3(halves[id].xyz, 0, pose + 3);
        vstore4(rotation, 0, pose + 6);
    }
}

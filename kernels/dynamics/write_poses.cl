// SPDX-License-Identifier: MIT
// Where bodies are, as poses (narrowphase/object.clh) for a tree; what is hidden keeps its negative
// half extents.
//
//   poses [n][10] centre xyz, half extents xyz, quaternion xyzw
//   or    [n][11] the radius besides; row_words says which

typedef struct {
    ARG_FIELDS
} state;

__kernel void write_poses(WRITE_POSES_ARGS)
{
    const state s = {WRITE_POSES_VALUES};
    uint first = get_global_id(0) * PER_ITEM;
    uint last = min(first + PER_ITEM, n);
    uint words = ROUNDED ? s.row_words : 10;
    for (uint id = first; id < last; ++id) {
        __global float *pose = poses + (size_t)id * words;
        float4 rotation = ROTATED ? convert_float4(s.rotations[id]) : (float4)(0.0f, 0.0f, 0.0f, 1.0f);
        vstore3(convert_float4(centres[id]).xyz, 0, pose);
        vstore3(halves[id].xyz, 0, pose + 3);
        vstore4(rotation, 0, pose + 6);
        if (words > 10)
            pose[10] = halves[id].w;
    }
}

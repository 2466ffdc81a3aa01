// SPDX-License-Identifier: MIT
// What a box is: whether its numbers make one, what of them 2D reads, and where its edges point.
#include "runtime/narrowphase/rounded.h"

#include <math.h>

const double narrow_here[3] = {0, 0, 0};

double narrow_axes(double axis[3][3], const float q[4])
{
    double x = q[0], y = q[1], z = q[2], w = q[3];
    double norm = (w * w + x * x) + (y * y + z * z);
    double scale = 1.0 / norm;
    double twice = 2.0 * scale;
    axis[0][0] = scale * ((w * w + x * x) - (y * y + z * z));
    axis[0][1] = twice * (x * y + w * z);
    axis[0][2] = twice * (x * z - w * y);
    axis[1][0] = twice * (x * y - w * z);
    axis[1][1] = scale * ((w * w + y * y) - (x * x + z * z));
    axis[1][2] = twice * (y * z + w * x);
    axis[2][0] = twice * (x * z + w * y);
    axis[2][1] = twice * (y * z - w * x);
    axis[2][2] = scale * ((w * w + z * z) - (x * x + y * y));
    return norm;
}

duet_pose narrow_flat(const duet_pose *pose, uint32_t dims)
{
    duet_pose flat = *pose;
    if (dims == 2)
        flat.centre[2] = flat.half_extents[2] = flat.rotation[0] = flat.rotation[1] = 0;
    return flat;
}

bool narrow_is_box(const duet_pose *pose, uint32_t dims)
{
    duet_pose p = narrow_flat(pose, dims);
    bool turned = false;
    for (int i = 0; i < 4; ++i) {
        if (!isfinite(p.rotation[i]))
            return false;
        turned = turned || p.rotation[i] != 0;
    }
    for (int i = 0; i < 3; ++i)
        if (!isfinite(p.centre[i]) || !isfinite(p.half_extents[i]) || p.half_extents[i] < 0)
            return false;
    return turned;
}

duet_rounded_box rounded_flat(const duet_rounded_box *box, uint32_t dims)
{
    return (duet_rounded_box){narrow_flat(&box->pose, dims), box->radius};
}

bool rounded_is_sound(const duet_rounded_box *box, uint32_t dims)
{
    return narrow_is_box(&box->pose, dims) && isfinite(box->radius) && box->radius >= 0;
}

duet_rounded_box rounded_of_sphere(const duet_sphere *sphere)
{
    return (duet_rounded_box){
        .pose = {.centre = {sphere->centre[0], sphere->centre[1], sphere->centre[2]},
                 .rotation = {0, 0, 0, 1}},
        .radius = sphere->radius};
}

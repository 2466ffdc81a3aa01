// SPDX-License-Identifier: MIT
// Separating axes in float: what kernels/sat.clh computes, operation for
// operation, so that a device can be checked bit by bit.
//
// Products reach a sum only through fmaf and nothing is divided: then every
// device that rounds as IEEE asks gives the same verdict. The structure and
// the bound are those of narrow.c, with u = 2^-24.
#include "runtime/narrow.h"

#include <math.h>
#include <string.h>

#define SLACK (NARROW_SLACK * 0x1p-24f)
#define PARALLEL 0.5f
// Outside of these what underflows could count, or a sum overflow.
#define LEAST_SIZE 0x1p-70f
#define GREATEST_SIZE 0x1p100f

static const int next[3] = {1, 2, 0};
static const int last[3] = {2, 0, 1};

static uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// 1 / x within an ulp, for x in 2^-100 .. 2^100. Turning the exponent's sign
// in the bits guesses within 5.1 %; each step squares the error.
static float reciprocal(float x)
{
    float r = float_of(0x7EF311C3u - bits_of(x));
    for (int step = 0; step < 3; ++step)
        r = fmaf(fmaf(-x, r, 1.0f), r, r);
    return r;
}

// A quaternion's length does not count, but its squares must neither vanish nor
// overflow. A power of two takes the length away and nothing else.
static duet_pose without_length(duet_pose pose)
{
    float *q = pose.rotation;
    float greatest = fmaxf(fmaxf(fabsf(q[0]), fabsf(q[1])), fmaxf(fabsf(q[2]), fabsf(q[3])));
    uint32_t exponent = bits_of(greatest) & 0x7F800000u;
    float scale = float_of(0x7F000000u - (exponent < 0x7E800000u ? exponent : 0x7E800000u));
    for (int i = 0; i < 4; ++i)
        q[i] *= scale;
    return pose;
}

static float squared_length(const float q[4])
{
    return fmaf(q[0], q[0], fmaf(q[1], q[1], fmaf(q[2], q[2], q[3] * q[3])));
}

static float dot(const float u[3], const float v[3])
{
    return fmaf(u[0], v[0], fmaf(u[1], v[1], u[2] * v[2]));
}

// [i]: the direction of edge i
static void set_axes(float axis[3][3], const float q[4])
{
    float x = q[0], y = q[1], z = q[2], w = q[3];
    float scale = reciprocal(squared_length(q));
    float twice = 2.0f * scale;
    float xx = x * x, yy = y * y, zz = z * z, ww = w * w;
    float wx = w * x, wy = w * y, wz = w * z;
    axis[0][0] = scale * ((ww + xx) - (yy + zz));
    axis[0][1] = twice * fmaf(x, y, wz);
    axis[0][2] = twice * fmaf(x, z, -wy);
    axis[1][0] = twice * fmaf(x, y, -wz);
    axis[1][1] = scale * ((ww + yy) - (xx + zz));
    axis[1][2] = twice * fmaf(y, z, wx);
    axis[2][0] = twice * fmaf(x, z, wy);
    axis[2][1] = twice * fmaf(y, z, -wx);
    axis[2][2] = scale * ((ww + zz) - (xx + yy));
}

static float sum_of_sizes(const float t[3], const float a[3], const float b[3])
{
    float distance = fabsf(t[0]) + fabsf(t[1]) + fabsf(t[2]);
    return distance + ((a[0] + a[1] + a[2]) + (b[0] + b[1] + b[2]));
}

static float largest(const float v[3])
{
    return fmaxf(v[0], fmaxf(v[1], v[2]));
}

static narrow_verdict test_in_3d(const duet_pose *pose_a, const duet_pose *pose_b)
{
    const float *a = pose_a->half, *b = pose_b->half;
    float axes_a[3][3], axes_b[3][3], t[3], ta[3], tb[3], c[3][3], size_c[3][3];
    set_axes(axes_a, pose_a->rotation);
    set_axes(axes_b, pose_b->rotation);
    for (int i = 0; i < 3; ++i)
        t[i] = pose_b->centre[i] - pose_a->centre[i];
    for (int i = 0; i < 3; ++i) {
        ta[i] = dot(axes_a[i], t);
        tb[i] = dot(axes_b[i], t);
        for (int j = 0; j < 3; ++j) {
            c[i][j] = dot(axes_a[i], axes_b[j]);
            size_c[i][j] = fabsf(c[i][j]);
        }
    }
    float size = sum_of_sizes(t, a, b);
    float slack = SLACK * size;
    bool trusted = size >= LEAST_SIZE && size <= GREATEST_SIZE;

    float needed = -INFINITY;
    for (int i = 0; i < 3; ++i) {
        float rb = fmaf(b[0], size_c[i][0], fmaf(b[1], size_c[i][1], b[2] * size_c[i][2]));
        float ra = fmaf(a[0], size_c[0][i], fmaf(a[1], size_c[1][i], a[2] * size_c[2][i]));
        needed = fmaxf(needed, fabsf(ta[i]) - (a[i] + rb));
        needed = fmaxf(needed, fabsf(tb[i]) - (b[i] + ra));
    }
    float greatest = needed;
    float tilt = 0.0f;
    for (int i = 0; i < 3; ++i) {
        int i1 = next[i], i2 = last[i];
        for (int j = 0; j < 3; ++j) {
            int j1 = next[j], j2 = last[j];
            float ra = fmaf(a[i1], size_c[i2][j], a[i2] * size_c[i1][j]);
            float rb = fmaf(b[j1], size_c[i][j2], b[j2] * size_c[i][j1]);
            float distance = fabsf(fmaf(ta[i2], c[i1][j], -(ta[i1] * c[i2][j])));
            float gap = distance - (ra + rb);
            float turn = size_c[i][j1] + size_c[i][j2];
            bool parallel = turn < PARALLEL;
            greatest = fmaxf(greatest, gap);
            needed = fmaxf(needed, parallel ? -INFINITY : gap);
            tilt = fmaxf(tilt, parallel && gap >= -slack ? turn : 0.0f);
        }
    }
    float lost = fminf(largest(a), largest(b)) * tilt;
    if (trusted && greatest > slack)
        return NARROW_SEPARATED;
    return trusted && needed + lost < -slack ? NARROW_COLLIDING : NARROW_UNDECIDED;
}

static narrow_verdict test_in_2d(const duet_pose *pose_a, const duet_pose *pose_b)
{
    const float *a = pose_a->half, *b = pose_b->half;
    float za = pose_a->rotation[2], wa = pose_a->rotation[3];
    float zb = pose_b->rotation[2], wb = pose_b->rotation[3];
    float scale_a = reciprocal(fmaf(za, za, wa * wa));
    float scale_b = reciprocal(fmaf(zb, zb, wb * wb));
    float cos_a = scale_a * fmaf(wa, wa, -(za * za)), sin_a = 2.0f * scale_a * (wa * za);
    float cos_b = scale_b * fmaf(wb, wb, -(zb * zb)), sin_b = 2.0f * scale_b * (wb * zb);
    float c = fabsf(fmaf(cos_a, cos_b, sin_a * sin_b));
    float s = fabsf(fmaf(cos_a, sin_b, -(sin_a * cos_b)));
    float x = pose_b->centre[0] - pose_a->centre[0];
    float y = pose_b->centre[1] - pose_a->centre[1];
    float size = (fabsf(x) + fabsf(y)) + ((a[0] + a[1]) + (b[0] + b[1]));
    float slack = SLACK * size;
    bool trusted = size >= LEAST_SIZE && size <= GREATEST_SIZE;

    float gap = fabsf(fmaf(x, cos_a, y * sin_a)) - (a[0] + fmaf(b[0], c, b[1] * s));
    gap = fmaxf(gap, fabsf(fmaf(y, cos_a, -(x * sin_a))) - (a[1] + fmaf(b[0], s, b[1] * c)));
    gap = fmaxf(gap, fabsf(fmaf(x, cos_b, y * sin_b)) - (b[0] + fmaf(a[0], c, a[1] * s)));
    gap = fmaxf(gap, fabsf(fmaf(y, cos_b, -(x * sin_b))) - (b[1] + fmaf(a[0], s, a[1] * c)));
    if (trusted && gap > slack)
        return NARROW_SEPARATED;
    return trusted && gap < -slack ? NARROW_COLLIDING : NARROW_UNDECIDED;
}

// Without rotation. What rounding leaves over of a sum of two floats is a float
// too, and rounding keeps order: comparing the sums, then what is left over, is
// exact. The device must have denormal numbers.
static narrow_verdict test_upright(const duet_pose *a, const duet_pose *b, int dims)
{
    bool apart = false;
    bool trusted = true;
    for (int i = 0; i < dims; ++i) {
        float from = a->centre[i], to = b->centre[i];
        float t = to - from;
        float part = t - to;
        float t_left = (to - (t - part)) + (-from - part);
        float reach = a->half[i] + b->half[i];
        float extent = reach - a->half[i];
        float reach_left = (a->half[i] - (reach - extent)) + (b->half[i] - extent);
        t_left = t < 0 ? -t_left : t_left;
        t = fabsf(t);
        apart = apart || t > reach || (t == reach && t_left > reach_left);
        trusted = trusted && t <= GREATEST_SIZE && reach <= GREATEST_SIZE;
    }
    if (!trusted)
        return NARROW_UNDECIDED;
    return apart ? NARROW_SEPARATED : NARROW_COLLIDING;
}

narrow_verdict narrow_float(const duet_pose *a, const duet_pose *b, uint32_t dims, bool rotated)
{
    if (!narrow_is_box(a, dims) || !narrow_is_box(b, dims))
        return NARROW_UNDECIDED; // the devices leave such objects out
    if (!rotated)
        return test_upright(a, b, (int)dims);
    duet_pose p = without_length(narrow_flat(a, dims));
    duet_pose q = without_length(narrow_flat(b, dims));
    return dims == 3 ? test_in_3d(&p, &q) : test_in_2d(&p, &q);
}

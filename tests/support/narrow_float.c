// SPDX-License-Identifier: MIT
// Separating axes in float with an error bound: what kernels/narrowphase/sat.clh computes,
// operation for operation, so that a device can be checked bit by bit. The
// structure is that of narrow.c, with u = 2^-24.
#include "support/narrow_float.h"

#include "runtime/narrowphase/sat_frame.h"

#include <math.h>

#define SLACK (NARROW_SLACK * 0x1p-24f)
#define PARALLEL 0.5f
#define GREATEST_DISTANCE 0x1p100f

static float largest(const float v[3])
{
    return fmaxf(v[0], fmaxf(v[1], v[2]));
}

static narrow_answer test_frame(const sat_frame *m)
{
    float slack = SLACK * m->size;
    float needed = sat_frame_face_separation(m);
    float greatest = needed;
    float tilt = 0.0f;
    for (int i = 0; m->dims == 3 && i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            float separation = sat_frame_edge_separation(m, i, j);
            float turn = m->size_c[i][(j + 1) % 3] + m->size_c[i][(j + 2) % 3];
            bool parallel = turn < PARALLEL;
            greatest = fmaxf(greatest, separation);
            needed = fmaxf(needed, parallel ? -INFINITY : separation);
            tilt = fmaxf(tilt, parallel && separation >= -slack ? turn : 0.0f);
        }
    float lost = fminf(largest(m->a), largest(m->b)) * tilt;
    if (m->trusted && greatest > slack)
        return NARROW_SEPARATED;
    return m->trusted && needed + lost < -slack ? NARROW_COLLIDING : NARROW_UNDECIDED;
}

// Without rotation. The rest that rounding leaves of a sum of two floats is a float
// too, and rounding keeps order: comparing the sums, then what is left over, is
// exact. The device must have denormal numbers.
static narrow_answer test_upright(const duet_pose *a, const duet_pose *b, const double shift[3],
                                  int dims)
{
    bool apart = false;
    bool trusted = true;
    for (int i = 0; i < dims; ++i) {
        float from = a->centre[i], to = b->centre[i];
        if (shift[i] != 0) {
            from = a->centre[i] - b->centre[i];
            to = (float)shift[i];
            trusted = trusted && (double)to == shift[i];
        }
        float t = to - from;
        float part = t - to;
        float t_left = (to - (t - part)) + (-from - part);
        float reach = a->half_extents[i] + b->half_extents[i];
        float extent = reach - a->half_extents[i];
        float reach_left = (a->half_extents[i] - (reach - extent)) + (b->half_extents[i] - extent);
        t_left = t < 0 ? -t_left : t_left;
        t = fabsf(t);
        apart = apart || t > reach || (t == reach && t_left > reach_left);
        trusted = trusted && t <= GREATEST_DISTANCE && reach <= GREATEST_DISTANCE;
    }
    if (!trusted)
        return NARROW_UNDECIDED;
    return apart ? NARROW_SEPARATED : NARROW_COLLIDING;
}

narrow_answer narrow_float(const duet_pose *a, const duet_pose *b, uint32_t dims, bool rotated)
{
    return narrow_float_apart(a, b, narrow_here, dims, rotated);
}

narrow_answer narrow_float_apart(const duet_pose *a, const duet_pose *b, const double shift[3],
                                 uint32_t dims, bool rotated)
{
    if (!narrow_is_box(a, dims) || !narrow_is_box(b, dims))
        return NARROW_UNDECIDED; // the devices leave such objects out
    if (!rotated)
        return test_upright(a, b, shift, (int)dims);
    sat_frame m = sat_frame_of(a, b, shift, dims);
    return test_frame(&m);
}

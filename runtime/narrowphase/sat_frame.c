// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/sat_frame.h"

#include "runtime/narrowphase/narrow.h"

#include <math.h>
#include <string.h>

// Outside of these what underflows could count, or a sum overflow.
#define LEAST_SIZE 0x1p-70f
#define GREATEST_SIZE 0x1p100f

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

static float dot(const float u[3], const float v[3])
{
    return fmaf(u[0], v[0], fmaf(u[1], v[1], u[2] * v[2]));
}

// ------------------------------------------------------------ one box

// A quaternion's length does not count, but its squares must neither vanish nor
// overflow. A power of two takes the length away and nothing else.
static void take_length_away(float q[4])
{
    float greatest = fmaxf(fmaxf(fabsf(q[0]), fabsf(q[1])), fmaxf(fabsf(q[2]), fabsf(q[3])));
    uint32_t exponent = bits_of(greatest) & 0x7F800000u;
    float scale = float_of(0x7F000000u - (exponent < 0x7E800000u ? exponent : 0x7E800000u));
    for (int i = 0; i < 4; ++i)
        q[i] *= scale;
}

static duet_pose load(const duet_pose *pose, uint32_t dims)
{
    duet_pose loaded = narrow_flat(pose, dims);
    take_length_away(loaded.rotation);
    return loaded;
}

static float squared_length(const float q[4])
{
    return fmaf(q[0], q[0], fmaf(q[1], q[1], fmaf(q[2], q[2], q[3] * q[3])));
}

// axis[i]: the direction of edge i
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

// Half the extent along each axis of the world, never too small: an entry of
// the rotation is off by at most 9 u, the sums by 4 u, and 64 u are added.
static void set_reach(float reach[3], const duet_pose *box, bool rotated)
{
    const float *half = box->half_extents;
    float axis[3][3];
    set_axes(axis, box->rotation);
    float sum = half[0] + half[1] + half[2];
    for (int k = 0; k < 3; ++k) {
        float r = fabsf(axis[0][k]) * half[0];
        for (int i = 1; i < 3; ++i)
            r = fmaf(fabsf(axis[i][k]), half[i], r);
        reach[k] = rotated ? fmaf(sum, 0x1p-18f, r) : half[k];
    }
}

static duet_bounds bounds_around(const duet_pose *box, const float reach[3], uint32_t dims)
{
    duet_bounds b = {{0}, {0}};
    for (uint32_t k = 0; k < dims; ++k) {
        float lower = box->centre[k] - reach[k];
        float upper = box->centre[k] + reach[k];
        b.lower[k] = lower - fmaf(fabsf(lower), 0x1p-23f, 0x1p-125f);
        b.upper[k] = upper + fmaf(fabsf(upper), 0x1p-23f, 0x1p-125f);
    }
    return b;
}

duet_bounds sat_bounds(const duet_pose *pose, uint32_t dims, bool rotated)
{
    duet_pose box = load(pose, dims);
    float reach[3];
    set_reach(reach, &box, rotated);
    return bounds_around(&box, reach, dims);
}

duet_bounds sat_rounded_bounds(const duet_rounded_box *rounded, uint32_t dims, bool rotated)
{
    duet_pose box = load(&rounded->pose, dims);
    float reach[3];
    set_reach(reach, &box, rotated);
    for (int k = 0; k < 3; ++k)
        reach[k] = fmaf(reach[k] + rounded->radius, 0x1p-22f, reach[k] + rounded->radius);
    return bounds_around(&box, reach, dims);
}

bool sat_bounds_overlap(const duet_bounds *a, const duet_bounds *b, const double shift[3],
                        uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k)
        if (a->lower[k] - b->upper[k] > (float)shift[k] ||
            a->upper[k] - b->lower[k] < (float)shift[k])
            return false;
    return true;
}

// ------------------------------------------------------------ two boxes

// From a's centre to b's, rounded once.
static void set_way(float t[3], const duet_pose *a, const duet_pose *b, const double shift[3],
                    uint32_t dims)
{
    t[2] = 0;
    for (uint32_t i = 0; i < dims; ++i)
        t[i] = (float)shift[i] + (b->centre[i] - a->centre[i]);
}

static bool is_trusted(float size)
{
    return size >= LEAST_SIZE && size <= GREATEST_SIZE;
}

static float sum_of_sizes(const float t[3], const float a[3], const float b[3])
{
    float distance = fabsf(t[0]) + fabsf(t[1]) + fabsf(t[2]);
    return distance + ((a[0] + a[1] + a[2]) + (b[0] + b[1] + b[2]));
}

static void see_in_3d(sat_frame *m, const float t[3], const float qa[4], const float qb[4])
{
    float axes_a[3][3], axes_b[3][3];
    set_axes(axes_a, qa);
    set_axes(axes_b, qb);
    for (int i = 0; i < 3; ++i) {
        m->ta[i] = dot(axes_a[i], t);
        m->tb[i] = dot(axes_b[i], t);
        for (int j = 0; j < 3; ++j) {
            m->c[i][j] = dot(axes_a[i], axes_b[j]);
            m->size_c[i][j] = fabsf(m->c[i][j]);
        }
    }
}

static void set_direction(const float q[4], float *cosine, float *sine)
{
    float z = q[2], w = q[3];
    float scale = reciprocal(fmaf(z, z, w * w));
    *cosine = scale * fmaf(w, w, -(z * z));
    *sine = 2.0f * scale * (w * z);
}

static void see_in_2d(sat_frame *m, const float t[3], const float qa[4], const float qb[4])
{
    float x = t[0], y = t[1], cos_a, sin_a, cos_b, sin_b;
    set_direction(qa, &cos_a, &sin_a);
    set_direction(qb, &cos_b, &sin_b);
    m->size_c[0][0] = m->size_c[1][1] = fabsf(fmaf(cos_a, cos_b, sin_a * sin_b));
    m->size_c[0][1] = m->size_c[1][0] = fabsf(fmaf(cos_a, sin_b, -(sin_a * cos_b)));
    m->ta[0] = fmaf(x, cos_a, y * sin_a);
    m->ta[1] = fmaf(y, cos_a, -(x * sin_a));
    m->tb[0] = fmaf(x, cos_b, y * sin_b);
    m->tb[1] = fmaf(y, cos_b, -(x * sin_b));
}

sat_frame sat_frame_of(const duet_pose *pose_a, const duet_pose *pose_b, const double shift[3],
                       uint32_t dims)
{
    duet_pose a = load(pose_a, dims), b = load(pose_b, dims);
    sat_frame m = {.dims = (int)dims};
    float t[3];
    set_way(t, &a, &b, shift, dims);
    for (int i = 0; i < 3; ++i) {
        m.a[i] = a.half_extents[i];
        m.b[i] = b.half_extents[i];
    }
    m.size = sum_of_sizes(t, m.a, m.b);
    m.trusted = is_trusted(m.size);
    (dims == 3 ? see_in_3d : see_in_2d)(&m, t, a.rotation, b.rotation);
    return m;
}

float sat_frame_face_separation(const sat_frame *m)
{
    float separation = -INFINITY;
    for (int i = 0; i < m->dims; ++i) {
        const float column[3] = {m->size_c[0][i], m->size_c[1][i], m->size_c[2][i]};
        separation = fmaxf(separation, fabsf(m->ta[i]) - (m->a[i] + dot(m->b, m->size_c[i])));
        separation = fmaxf(separation, fabsf(m->tb[i]) - (m->b[i] + dot(m->a, column)));
    }
    return separation;
}

float sat_frame_edge_separation(const sat_frame *m, int i, int j)
{
    int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    float ra = fmaf(m->a[i1], m->size_c[i2][j], m->a[i2] * m->size_c[i1][j]);
    float rb = fmaf(m->b[j1], m->size_c[i][j2], m->b[j2] * m->size_c[i][j1]);
    float distance = fabsf(fmaf(m->ta[i2], m->c[i1][j], -(m->ta[i1] * m->c[i2][j])));
    return distance - (ra + rb);
}

// ------------------------------------------------------------ spheres

// The power of two of a size of 2^-126 or more, and 1 / it of 2^126 or less.
static float power_of(float size)
{
    return float_of(bits_of(size) & 0x7F800000u);
}

static float inverse_power_of(float size)
{
    return float_of(0x7F000000u - (bits_of(size) & 0x7F800000u));
}

// sqrt(x) within 4 ulp, for x in 2^-100 .. 2^100, or 0; a device's own root may
// be rounded in its own way.
static float root(float x)
{
    float y = float_of(0x5F3759DFu - (bits_of(x) >> 1));
    for (int step = 0; step < 3; ++step)
        y = y * fmaf(-0.5f * x * y, y, 1.5f);
    return x * y;
}

// Half the diagonal, by squares near 1. Extents below 2^-126 count as 0.
static float radius_of(const float half[3])
{
    float greatest = fmaxf(fmaxf(half[0], half[1]), half[2]);
    float scale = inverse_power_of(greatest);
    const float scaled[3] = {scale * half[0], scale * half[1], scale * half[2]};
    return root(dot(scaled, scaled)) * power_of(greatest);
}

static bool is_beyond(const float t[3], float reach)
{
    return dot(t, t) > reach * reach * (1.0f + 0x1p-18f);
}

static bool spheres_overlap(const duet_pose *pose_a, float radius_a, const duet_pose *pose_b,
                            float radius_b, const double shift[3], uint32_t dims)
{
    duet_pose a = narrow_flat(pose_a, dims), b = narrow_flat(pose_b, dims);
    float t[3];
    set_way(t, &a, &b, shift, dims);
    float size = sum_of_sizes(t, a.half_extents, b.half_extents);
    float reach = (radius_of(a.half_extents) + radius_a) + (radius_of(b.half_extents) + radius_b);
    bool apart = is_beyond(t, reach);
    if (!(size >= 0x1p-40f && size <= 0x1p40f)) { // squares near 1
        float scale = inverse_power_of(size);
        for (int k = 0; k < 3; ++k)
            t[k] *= scale;
        apart = is_beyond(t, scale * reach);
    }
    return !(apart && is_trusted(size));
}

bool sat_spheres_overlap(const duet_pose *a, const duet_pose *b, const double shift[3],
                         uint32_t dims)
{
    return spheres_overlap(a, 0, b, 0, shift, dims);
}

bool sat_rounded_spheres_overlap(const duet_rounded_box *a, const duet_rounded_box *b,
                                 uint32_t dims)
{
    return spheres_overlap(&a->pose, a->radius, &b->pose, b->radius, narrow_here, dims);
}

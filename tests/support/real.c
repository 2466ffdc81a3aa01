// SPDX-License-Identifier: MIT
#include "support/real.h"

#include <math.h>
#include <string.h>

void real_less(real out[3], const real a[3], const real b[3])
{
    for (int k = 0; k < 3; ++k)
        out[k] = a[k] - b[k];
}

void real_cross(real out[3], const real u[3], const real v[3])
{
    for (int k = 0; k < 3; ++k)
        out[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
}

real real_dot(const real u[3], const real v[3])
{
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

void real_axes(real axis[3][3], const float q[4])
{
    real x = q[0], y = q[1], z = q[2], w = q[3], s = 2 / (x * x + y * y + z * z + w * w);
    const real rows[3][3] = {{1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
                             {s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x)},
                             {s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y)}};
    memcpy(axis, rows, sizeof rows);
}

// ---------------------------------------------------------------- triangles

real triangle_pass(const triangle *t, const duet_ray *ray)
{
    real e1[3], e2[3], way[3], p[3], q[3], go[3], from[3];
    for (int k = 0; k < 3; ++k) {
        go[k] = ray->direction[k];
        from[k] = ray->origin[k];
    }
    real_less(e1, t->at[1], t->at[0]);
    real_less(e2, t->at[2], t->at[0]);
    real_less(way, from, t->at[0]);
    real_cross(p, go, e2);
    real_cross(q, way, e1);
    real det = real_dot(e1, p), u = real_dot(way, p) / det, v = real_dot(go, q) / det;
    real when = real_dot(e2, q) / det;
    return u >= 0 && v >= 0 && u + v <= 1 && when >= 0 ? when : INFINITY;
}

int polygon_clip(real at[12][3], int n, const real inside[12])
{
    real to[12][3];
    int kept = 0;
    for (int i = 0; i < n; ++i) {
        int next = (i + 1) % n;
        if (inside[i] >= 0)
            memcpy(to[kept++], at[i], sizeof *to);
        if ((inside[i] >= 0) != (inside[next] >= 0)) {
            real part = inside[i] / (inside[i] - inside[next]);
            for (int k = 0; k < 3; ++k)
                to[kept][k] = at[i][k] + part * (at[next][k] - at[i][k]);
            ++kept;
        }
    }
    memcpy(at, to, (size_t)kept * sizeof *to);
    return kept;
}

// ---------------------------------------------------------------- boxes

block block_of(const duet_pose *pose)
{
    block b;
    real_axes(b.axis, pose->rotation);
    for (int k = 0; k < 3; ++k) {
        b.centre[k] = pose->centre[k];
        b.half[k] = pose->half_extents[k];
    }
    return b;
}

void block_corner(const block *b, int which, real at[3])
{
    for (int k = 0; k < 3; ++k) {
        at[k] = b->centre[k];
        for (int i = 0; i < 3; ++i)
            at[k] += (which >> i & 1 ? 1 : -1) * b->half[i] * b->axis[i][k];
    }
}

block block_moved(const duet_sweep *sweep, real t)
{
    block b = block_of(&sweep->box);
    for (int k = 0; k < 3; ++k)
        b.centre[k] += t * (real)sweep->direction[k];
    return b;
}

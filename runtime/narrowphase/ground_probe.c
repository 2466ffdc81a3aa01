// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/ground_probe.h"

#include "runtime/narrowphase/narrow.h"

#include <math.h>
#include <string.h>

static bool is_still(const float direction[3])
{
    return direction[0] == 0.0f && direction[1] == 0.0f && direction[2] == 0.0f;
}

static void set_way(ground_probe *p, const float direction[3], float t_max)
{
    memcpy(p->direction, direction, sizeof p->direction);
    p->t_max = is_still(direction) ? 0.0f : t_max;
}

// An entry of an axis is a sum of products of the rotation's numbers: 0 where all are.
static void set_sums(ground_probe *p)
{
    const float *q = p->rotation;
    double x = fabs((double)q[0]), y = fabs((double)q[1]), z = fabs((double)q[2]);
    double w = fabs((double)q[3]), twice = 2.0 / (x * x + y * y + z * z + w * w);
    const double sums[3][3] = {{1.0, twice * (x * y + w * z), twice * (x * z + w * y)},
                               {twice * (x * y + w * z), 1.0, twice * (y * z + w * x)},
                               {twice * (x * z + w * y), twice * (y * z + w * x), 1.0}};
    memcpy(p->sums, sums, sizeof sums);
}

static void set_box(ground_probe *p, const float rotation[4])
{
    memcpy(p->rotation, rotation, sizeof p->rotation);
    narrow_axes(p->axis, rotation);
    set_sums(p);
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i)
            p->reach[k] += p->half[i] * fabs(p->axis[i][k]);
        p->reach[k] *= 1.0 + 0x1p-40;
    }
    p->is_point = p->half[0] == 0.0 && p->half[1] == 0.0 && p->half[2] == 0.0;
}

ground_probe ground_probe_of_ray(const duet_ray *ray)
{
    ground_probe p = {.rotation = {0, 0, 0, 1}, .is_point = true};
    for (int k = 0; k < 3; ++k)
        p.centre[k] = ray->origin[k];
    set_way(&p, ray->direction, ray->t_max);
    return p;
}

ground_probe ground_probe_of_sweep(const duet_sweep *sweep)
{
    ground_probe p = {0};
    for (int k = 0; k < 3; ++k) {
        p.centre[k] = sweep->box.centre[k];
        p.half[k] = sweep->box.half_extents[k];
    }
    set_box(&p, sweep->box.rotation);
    set_way(&p, sweep->direction, sweep->t_max);
    return p;
}

ground_probe ground_probe_of_bounds(const duet_bounds_sweep *sweep)
{
    ground_probe p = ground_probe_of_still_bounds(&sweep->bounds);
    set_way(&p, sweep->direction, sweep->t_max);
    return p;
}

ground_probe ground_probe_of_box(const duet_pose *box)
{
    const duet_sweep still = {.box = *box};
    return ground_probe_of_sweep(&still);
}

ground_probe ground_probe_of_still_bounds(const duet_bounds *bounds)
{
    static const float upright[4] = {0, 0, 0, 1};
    ground_probe p = {.bounds = bounds, .inexact = 1.0};
    for (int k = 0; k < 3; ++k) {
        p.centre[k] = 0.5 * ((double)bounds->lower[k] + (double)bounds->upper[k]);
        p.half[k] = 0.5 * ((double)bounds->upper[k] - (double)bounds->lower[k]);
    }
    set_box(&p, upright);
    return p;
}

ground_probe ground_probe_of_rounded_sweep(const duet_rounded_sweep *sweep)
{
    duet_sweep core = {.box = sweep->box.pose, .t_max = sweep->t_max};
    memcpy(core.direction, sweep->direction, sizeof core.direction);
    ground_probe p = ground_probe_of_sweep(&core);
    p.radius = sweep->box.radius;
    for (int k = 0; k < 3; ++k)
        p.reach[k] += p.radius;
    return p;
}

ground_probe ground_probe_of_rounded_box(const duet_rounded_box *box)
{
    const duet_rounded_sweep still = {.box = *box};
    return ground_probe_of_rounded_sweep(&still);
}

// No number is -0.
void ground_set_normal(const ground_entry *entry, float normal[3])
{
    const double *n = entry->normal;
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; ++k)
        normal[k] = (float)(n[k] / length) + 0.0f;
}

// SPDX-License-Identifier: MIT
#include "runtime/dynamics/substeps.h"

#include <math.h>

// A column of N bodies stands if its springs hold it alone, or if it keeps the levers that it has
// upright and sways too slowly to fall: then it may be as tall as stands with springs a tenth as
// stiff, and must not sink so far that manifolds are made again. One that leans has no such levers;
// it falls anyway if twice the most substeps would not hold it.
static const double plain_limit = 0.98, kept_limit = 10.0, margin_part = 1.0 / 3.0;

// Substeps of a spring's swing (set_solver in motion_step.c).
static const double substeps_a_swing = 6.0;

enum { LEAST = 4, MOST = 32 };

static double gravity_of(const duet_motion_def *def)
{
    return sqrt(def->gravity[0] * def->gravity[0] + def->gravity[1] * def->gravity[1] +
                (def->dims == 3 ? def->gravity[2] * def->gravity[2] : 0.0));
}

static double substeps_of(const duet_motion *m, double stiffness)
{
    const double pi = 3.14159265358979323846;
    return ceil(m->def.dt * sqrt(stiffness) * substeps_a_swing / (2.0 * pi));
}

// The least square of a spring's angular frequency that holds the column.
static double stiffness_for(const duet_motion *m, const column *c)
{
    double n = c->layers, g = gravity_of(&m->def);
    double plain = n * n * n * g / (plain_limit * c->edge);
    if (c->kind == COLUMN_LEANING)
        return substeps_of(m, plain) <= 2 * MOST ? plain : 0.0;
    if (c->layers < 2)
        return 0.0;
    double sway = n * n * n * g / (kept_limit * c->edge);
    double sink = n * g / (margin_part * m->margin);
    return fmin(plain, fmax(sway, sink));
}

static uint32_t substeps_for(const duet_motion *m, const column *c)
{
    return (uint32_t)fmax(LEAST, fmin(MOST, substeps_of(m, stiffness_for(m, c))));
}

bool motion_choose_substeps(duet_motion *m, duet_error *err)
{
    const uint32_t all = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_GRAVITY;
    if (m->def.substeps > 0)
        return true;
    column tallest = {0};
    bool falls = (m->effects & all) == all && m->def.attraction == 0.0;
    if (falls && !column_find(m, stiffness_for, &tallest, err))
        return false;
    m->def.substeps = substeps_for(m, &tallest);
    m->substeps = (duet_substep_info){.substeps = m->def.substeps,
                                      .chosen = true,
                                      .layers = tallest.layers,
                                      .edge = tallest.edge};
    return true;
}

bool duet_motion_explain_substeps(const duet_motion *m, duet_substep_info *info)
{
    if (!m || !info)
        return false;
    *info = m->substeps;
    info->substeps = m->def.substeps;
    return true;
}

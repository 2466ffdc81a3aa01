// SPDX-License-Identifier: MIT
// What a step's kernels are told, by the names that the cards in kernels/dynamics use.
#include "runtime/dynamics/motion.h"

#include <math.h>

#define BUFFER(which, name, type) BIND_BUFFER(duet_motion, name, type, buffers[which])
#define VALUE(name) BIND_VALUE(duet_motion, #name, args.name)

const binding motion_bindings[] = {
    BUFFER(CENTRES, "centres", "real4 *"),
    BUFFER(CELLS, "cells", "int4 *"),
    BUFFER(VELOCITIES, "velocities", "real4 *"),
    BUFFER(ROTATIONS, "rotations", "real4 *"),
    BUFFER(ANGULAR_VELOCITIES, "angular_velocities", "real4 *"),
    BUFFER(INERTIAS, "inertias", "float4 *"),
    BUFFER(HALVES, "halves", "float4 *"),
    BUFFER(RESTITUTIONS, "restitutions", "float *"),
    BUFFER(FRICTIONS, "frictions", "float *"),
    BUFFER(FILTERS, "filters", "uint2 *"),
    BUFFER(SENSORS, "sensors", "float *"),
    BUFFER(RESTS, "rests", "float *"),
    BUFFER(ASLEEP, "asleep", "uint *"),
    BUFFER(FORCES, "forces", "float4 *"),
    BUFFER(BODIES, "bodies", "float4 *"),
    BUFFER(BOXES, "boxes", "float *"),
    BUFFER(STARTS, "starts", "uint *"),
    BUFFER(RETURN_STARTS, "return_starts", "uint *"),
    BUFFER(USED, "used", "uint *"),
    BUFFER(CHOICES, "choices", "uint *"),
    BUFFER(OTHERS, "others", "uint *"),
    BUFFER(LINKS, "links", "uint2 *"),
    BUFFER(RETURNS, "returns", "uint *"),
    BUFFER(CONTACTS, "contacts", "float *"),
    BUFFER(TOUCHES, "touches", "uint *"),
    BUFFER(COLOUR_OF, "colours", "uint *"),
    BUFFER(OLD_LINKS, "old_links", "uint2 *"),
    BUFFER(OLD_CONTACTS, "old_contacts", "float *"),
    BUFFER(OLD_TOUCHES, "old_touches", "uint *"),
    BUFFER(OLD_COLOURS, "old_colours", "uint *"),
    BUFFER(LIST, "list", "uint *"),
    BUFFER(LIST_KEYS, "keys", "uint *"),
    BUFFER(COLOUR_STARTS, "key_starts", "uint *"),
    BUFFER(SPANS, "spans", "uint4 *"),
    BUFFER(BLOCKS, "blocks", "float *"),
    BUFFER(TOUCHING, "touching", "uint *"),
    BUFFER(HITS, "hits", "uint *"),
    BUFFER(FLAG_WORDS, "flags", "uint *"),
    BIND_BUFFER(duet_motion, "pairs", "uint2 *", args.pairs),
    BIND_BUFFER(duet_motion, "row_starts", "uint *", args.row_starts),
    BIND_BUFFER(duet_motion, "row_values", "uint *", args.row_values),
    BUFFER(READ_IDS, "ids", "uint *"),
    BUFFER(GATHERED, "gathered", "uint *"),
    BUFFER(CHANGED, "changed", "uint *"),
    BIND_BUFFER(duet_motion, "rows", "uint *", args.rows),
    BIND_BUFFER(duet_motion, "last_rows", "uint *", args.last_rows),
    BIND_BUFFER(duet_motion, "poses", "float *", args.poses),
    BUFFER(PAIRS, "found_pairs", "uint2 *"),
    BUFFER(ALTERED, "altered", "uint *"),
    BUFFER(IS_ALTERED, "is_altered", "uint *"),
    BUFFER(ALTERED_HEADS, "heads", "uint *"),
    BUFFER(ALTERED_ENTRIES_OF, "entries", "int4 *"),
    BUFFER(ALTERED_NEXTS, "nexts", "uint *"),
    BUFFER(ALTERED_WIDE_ONES, "wide", "uint *"),
    BUFFER(ALTERED_COUNT_WORDS, "altered_counts", "uint *"),
    VALUE(n_altered),
    VALUE(n_heads),
    VALUE(per_edge),
    VALUE(pair_capacity),
    VALUE(row_words),
    VALUE(n_ids),
    BIND_VALUE(duet_motion, "n", n),
    BIND_VALUE(duet_motion, "n_contacts", n_contacts),
    BIND_VALUE(duet_motion, "n_keys", n_contacts),
    VALUE(n_pairs),
    VALUE(n_old),
    VALUE(key_end),
    VALUE(gravity),
    BIND_VALUE(duet_motion, "gravity", args.gravity_float),
    VALUE(lower),
    VALUE(upper),
    VALUE(times),
    VALUE(drags),
    VALUE(substeps),
    BIND_VALUE(duet_motion, "dt", args.dt_real),
    VALUE(dt),
    VALUE(h),
    VALUE(per_h),
    VALUE(drag),
    VALUE(spring),
    VALUE(hard_spring),
    VALUE(pull),
    VALUE(kick),
    VALUE(margin),
    VALUE(aabb_margin),
    VALUE(skin),
    VALUE(least_speed),
    VALUE(sleep_speed),
    VALUE(sleep_after),
    VALUE(hit_speed),
    VALUE(base),
    VALUE(fill),
    VALUE(woken),
    VALUE(soft),
    VALUE(span),
    VALUE(round),
    VALUE(from_colour),
    VALUE(to_colour),
    VALUE(each),
    {0}};

arg_real motion_real(const duet_motion *m, double value)
{
    return m->def.doubles ? (arg_real){.d = value} : (arg_real){.f = (float)value};
}

static cl_float4 float4_of(double x, double y, double z, double w)
{
    return (cl_float4){{(float)x, (float)y, (float)z, (float)w}};
}

static arg_real4 real4_of(const duet_motion *m, double x, double y, double z, double w)
{
    return m->def.doubles ? (arg_real4){.d = {{x, y, z, w}}}
                          : (arg_real4){.f = float4_of(x, y, z, w)};
}

// The parts of a substep in free flight: one, or of Yoshida's order 4 two outer ones and
// one between them that goes back. Drag comes once a part, or before and after it.
static void set_flight(duet_motion *m, double h)
{
    double root = cbrt(2.0);
    bool parted = m->def.integrator == DUET_INTEGRATOR_YOSHIDA;
    double outer = parted ? h / (2.0 - root) : h;
    double inner = parted ? -h * root / (2.0 - root) : 0.0;
    double share = m->def.integrator == DUET_INTEGRATOR_EULER ? 1.0 : 0.5;
    m->args.times = real4_of(m, outer, inner, 0.0, 0.0);
    m->args.drags =
        real4_of(m, exp(-m->def.drag * share * outer), exp(-m->def.drag * share * inner), 0.0, 0.0);
}

static void set_gravity(duet_motion *m)
{
    const duet_motion_def *d = &m->def;
    const double *at = d->attraction != 0.0 ? d->centre : d->gravity;
    double z = d->dims == 3 ? at[2] : 0.0;
    m->args.gravity = real4_of(m, at[0], at[1], z, d->attraction);
    m->args.gravity_float = float4_of(at[0], at[1], z, d->attraction);
}

// A damped spring, implicitly: how fast overlap is pushed out per depth, what part of the
// mass answers, and what part of the impulse decays.
static cl_float4 spring_of(const duet_motion *m, double h, double hertz)
{
    const double damping = 10.0;
    double omega = 2.0 * 3.14159265358979323846 * hertz;
    double stiff = 2.0 * damping + h * omega;
    double soft = h * omega * stiff;
    double part = 1.0 / (1.0 + soft);
    return float4_of(omega / stiff, soft * part, part, m->def.max_push_speed);
}

// What the contacts of a substep are solved with.
static void set_solver(duet_motion *m, double h)
{
    const duet_motion_def *d = &m->def;
    // Six substeps a swing, and five against what never moves: fewer than 4.5 shake what they hold.
    m->args.spring = spring_of(m, h, 1.0 / (6.0 * h));
    m->args.hard_spring = spring_of(m, h, 1.0 / (5.0 * h));
    m->args.least_speed = (float)d->restitution_threshold;
    // What a substep adds to the velocity of all that falls, and 1 / its time. An
    // attraction, which differs from place to place, is left out.
    double part = d->attraction != 0.0 ? 0.0 : h;
    m->args.pull = float4_of(part * d->gravity[0], part * d->gravity[1],
                             d->dims == 3 ? part * d->gravity[2] : 0.0, 1.0 / h);
    // What a load adds to a closing speed in a substep. Less than a slop in a step is rest.
    const cl_float *pull = m->args.pull.s;
    double fall = sqrt(pull[0] * pull[0] + pull[1] * pull[1] + pull[2] * pull[2]);
    m->args.kick = (float)(fall + m->margin / MOTION_SLOPS / d->dt);
}

// Where there are none, walls are far away.
static void set_walls(duet_motion *m)
{
    const duet_motion_def *d = &m->def;
    const double far = 1e30;
    bool any = d->boundary != DUET_BOUNDARY_NONE;
    m->args.lower = any ? real4_of(m, d->lower[0], d->lower[1], d->lower[2], 0.0)
                        : real4_of(m, -far, -far, -far, 0.0);
    m->args.upper = any ? real4_of(m, d->upper[0], d->upper[1], d->upper[2], 0.0)
                        : real4_of(m, far, far, far, 0.0);
}

void motion_set_args(duet_motion *m)
{
    const duet_motion_def *d = &m->def;
    double h = d->dt / d->substeps;
    m->args = (motion_args){
        .substeps = d->substeps,
        .dt = (float)d->dt,
        .dt_real = motion_real(m, d->dt),
        .h = (float)h,
        .per_h = (float)(1.0 / h),
        .drag = (float)exp(-d->drag * h),
        .margin = (float)m->margin,
        .skin = motion_real(m, d->skin),
        .sleep_speed = (float)d->sleep_speed,
        .sleep_after = (float)d->sleep_after,
        .hit_speed = (float)d->hit_speed,
        .key_end = KEYS,
        .base = m->cells ? m->cells[0] : (cl_int4){{0}},
    };
    set_walls(m);
    set_flight(m, h);
    set_gravity(m);
    set_solver(m, h);
}

bool motion_launch(duet_motion *m, const char *stage, const kernel *k, uint64_t work,
                   duet_error *err)
{
    return timeline_launch(&m->times, stage, k, work, m, err);
}

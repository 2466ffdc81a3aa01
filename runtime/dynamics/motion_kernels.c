// SPDX-License-Identifier: MIT
// Which kernels a motion runs, and with which parameters.
#include "runtime/dynamics/motion.h"

#include "base/error.h"
#include "runtime/narrowphase/origin.h"

#include <assert.h>
#include <math.h>
#include <string.h>

// ---------------------------------------------------------------- arguments

#define BUFFER(which, name, type) BIND_BUFFER(duet_motion, name, type, buffers[which])
#define VALUE(name) BIND_VALUE(duet_motion, #name, args.name)

static const binding motion_bindings[] = {
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

// ---------------------------------------------------------------- parameters

enum { MOST_PARAMS = 32 };

static const gen_param *find_param(const gen_param *params, uint32_t n, const char *name)
{
    for (uint32_t i = 0; i < n; ++i)
        if (strcmp(params[i].name, name) == 0)
            return &params[i];
    return NULL;
}

static int64_t has(const duet_motion *m, uint32_t effect)
{
    return motion_has(m, effect) ? 1 : 0;
}

static int64_t gravity_kind(const duet_motion *m)
{
    return !motion_has(m, DUET_EFFECT_GRAVITY) ? 0 : m->def.attraction != 0.0 ? 2 : 1;
}

// With response, walls are contacts and nothing is left to a free flight.
static int64_t boundary_kind(const duet_motion *m)
{
    return !motion_has(m, DUET_EFFECT_BOUNDARY)        ? 0
           : m->def.boundary == DUET_BOUNDARY_PERIODIC ? 2
                                                       : 1;
}

static int64_t order_of(duet_integrator integrator)
{
    static const int64_t orders[] = {
        [DUET_INTEGRATOR_EULER] = 1, [DUET_INTEGRATOR_VERLET] = 2, [DUET_INTEGRATOR_YOSHIDA] = 4};
    return orders[integrator];
}

// Kernels that know no difference take what turns far as what turns.
static int64_t turning_kind(const duet_motion *m)
{
    return !motion_has(m, DUET_EFFECT_ANGULAR_VELOCITY) ? 0
           : motion_has(m, DUET_EFFECT_CONTINUOUS)      ? 2
                                                        : 1;
}

static gen_setting setting_of(const gen_param *p, int64_t value)
{
    int64_t most = p->is_range ? p->most : p->values[p->n_values - 1];
    return (gen_setting){p->name, value < most ? value : most};
}

// What the scene says of the parameters that the kernel's card has.
static bool gather(duet_motion *m, const char *name, bool altered,
                   gen_setting settings[MOST_PARAMS], uint32_t *n, duet_error *err)
{
    int64_t gyro = motion_has(m, DUET_EFFECT_ANGULAR_VELOCITY) && m->facts.uneven;
    const gen_setting choices[] = {
        {"DIMS", m->def.dims},
        {"DOUBLE", m->def.doubles},
        {"ORIGIN", origin_setting(m->def.origin_edge)},
        {"ORDER", order_of(m->def.integrator)},
        {"ROTATED", has(m, DUET_EFFECT_ROTATION)},
        {"ANGULAR_VELOCITY", turning_kind(m)},
        {"GYRO", gyro},
        {"GRAVITY", gravity_kind(m)},
        {"DRAG", has(m, DUET_EFFECT_DRAG)},
        {"FORCES", has(m, DUET_EFFECT_FORCES)},
        {"BOUNDARY", boundary_kind(m)},
        {"CONTACT_RESPONSE", has(m, DUET_EFFECT_CONTACT_RESPONSE)},
        {"FRICTION", has(m, DUET_EFFECT_FRICTION)},
        {"CONTINUOUS", has(m, DUET_EFFECT_CONTINUOUS)},
        {"FILTER", has(m, DUET_EFFECT_FILTER)},
        {"SLEEP", has(m, DUET_EFFECT_SLEEP)},
        {"SKIN", has(m, DUET_EFFECT_SKIN)},
        {"ROUNDED", has(m, DUET_EFFECT_RADIUS)},
        {"SENSORS", has(m, DUET_EFFECT_SENSORS)},
        {"HITS", motion_tells_hits(m)},
        {"ALTERED", altered},
    };
    const gen_param *params = NULL;
    uint32_t n_params = 0;
    gen_limits limits = program_set_limits(m->programs);
    if (!gen_params(m->gen, name, &limits, &params, &n_params, err))
        return false;
    *n = 0;
    static_assert(sizeof choices / sizeof choices[0] <= MOST_PARAMS, "settings");
    for (size_t i = 0; i < sizeof choices / sizeof choices[0]; ++i) {
        const gen_param *p = find_param(params, n_params, choices[i].name);
        if (p)
            settings[(*n)++] = setting_of(p, choices[i].value);
    }
    return true;
}

bool motion_ask(duet_motion *m, kernel **at, const char *name, const char *entry, bool altered,
                duet_error *err)
{
    gen_setting settings[MOST_PARAMS];
    uint32_t n = 0;
    if (!gather(m, name, altered, settings, &n, err))
        return false;
    *at = program_set_kernel(m->programs, name, entry, settings, n, motion_bindings, err);
    return *at;
}

// ---------------------------------------------------------------- all of them

static motion_layout lay_out(const duet_motion *m)
{
    bool response = motion_has(m, DUET_EFFECT_CONTACT_RESPONSE);
    bool turns = motion_has(m, DUET_EFFECT_ANGULAR_VELOCITY);
    bool friction = motion_has(m, DUET_EFFECT_FRICTION);
    uint32_t dims = m->def.dims;
    uint32_t points = POINTS_OF(response, turns, dims);
    motion_layout l = {
        .head = HEAD_OF(response, turns, points),
        .point = POINT_FLOATS_OF(response, friction, dims),
        .points = points,
        .body = BODY_OF(turns),
    };
    l.record = l.head + l.points * l.point;
    l.constraint = CONSTRAINT_OF(friction, l.points, dims);
    return l;
}

static bool choose_kernels(duet_motion *m, duet_error *err)
{
    motion_kernels *k = &m->kernels;
    bool contact = motion_has(m, DUET_EFFECT_CONTACT);
    bool response = motion_has(m, DUET_EFFECT_CONTACT_RESPONSE);
    bool flight = motion_has(m, DUET_EFFECT_MOTION) && !response;
    bool walls = contact && boundary_kind(m) == 1;
    const struct {
        kernel **at;
        bool wanted;
        const char *name;
        const char *entry;
    } list[] = {
        {&k->integrate_free_flight, flight, "integrate_free_flight", "integrate_free_flight"},
        {&k->compute_fat_aabbs, contact, "fat_aabbs", "compute_fat_aabbs"},
        {&k->check_fat_aabbs, motion_has(m, DUET_EFFECT_SKIN), "fat_aabbs", "check_fat_aabbs"},
        {&k->contact_graph_pairs, contact, "contact_graph", "contact_graph_pairs"},
        {&k->contact_graph_walls, walls, "contact_graph", "contact_graph_walls"},
        {&k->contact_graph_sort, contact, "contact_graph", "contact_graph_sort"},
        {&k->contact_graph_reverse, contact, "contact_graph", "contact_graph_reverse"},
        {&k->match_contacts, contact, "match_contacts", "match_contacts"},
        {&k->build_manifolds, contact, "build_manifolds", "build_manifolds"},
        {&k->update_sleep, motion_has(m, DUET_EFFECT_SLEEP), "update_sleep", "update_sleep"},
        {&k->push_sleepers, motion_has(m, DUET_EFFECT_SLEEP), "update_sleep", "push_sleepers"},
        {&k->move_sleepers, motion_has(m, DUET_EFFECT_SLEEP), "update_sleep", "move_sleepers"},
        {&k->contact_events, motion_has(m, DUET_EFFECT_EVENTS), "contact_events", "contact_events"},
        {&k->prepare_bodies, response, "bodies", "prepare_bodies"},
        {&k->integrate_velocities, response, "bodies", "integrate_velocities"},
        {&k->integrate_positions, response, "integrate_positions", "integrate_positions"},
        {&k->finalize_bodies, response, "bodies", "finalize_bodies"},
        {&k->graph_colour_mark, response, "graph_colour", "graph_colour_mark"},
        {&k->graph_colour_choose, response, "graph_colour", "graph_colour_choose"},
        {&k->graph_colour_take, response, "graph_colour", "graph_colour_take"},
        {&k->graph_colour_key, response, "graph_colour", "graph_colour_key"},
        {&k->prepare_contacts, response, "prepare_contacts", "prepare_contacts"},
        {&k->store_impulses, response, "prepare_contacts", "store_impulses"},
        {&k->solve_contacts, response, "solve_contacts", "solve_contacts"},
        {&k->apply_restitution, response, "solve_contacts", "apply_restitution"},
        {&k->row_start, response, "cell_start", "row_start"},
    };
    m->layout = lay_out(m);
    for (size_t i = 0; i < sizeof list / sizeof list[0]; ++i)
        if (list[i].wanted && !motion_ask(m, list[i].at, list[i].name, list[i].entry, false, err))
            return false;
    if (response)
        m->layout.block = (uint32_t)kernel_param(k->solve_contacts, "BLOCK");
    return true;
}

bool motion_prepare(duet_motion *m, duet_error *err)
{
    bool contact = motion_has(m, DUET_EFFECT_CONTACT);
    bool response = motion_has(m, DUET_EFFECT_CONTACT_RESPONSE);
    return choose_kernels(m, err) &&
           (!contact || scan_open(&m->scan, m->device, m->programs, NULL, 0, err)) &&
           (!response ||
            radix_sort_open(&m->radix, m->device, m->programs, &m->scan, NULL, 0, err)) &&
           program_set_build(m->programs, err);
}

bool motion_prepare_again(duet_motion *m, duet_error *err)
{
    return choose_kernels(m, err) && program_set_build(m->programs, err);
}

// ---------------------------------------------------------------- launches

// A buffer that must grow gets more than it needs now: fresh pages cost as much time as
// writing them.
bool motion_reserve(duet_motion *m, motion_buffer which, uint64_t n, size_t size, duet_error *err)
{
    buffer *b = &m->buffers[which];
    uint64_t bytes = n * size;
    uint64_t roomy = bytes + bytes / 4;
    bool grows = b->mem && b->bytes < bytes && roomy <= m->device->info.max_buffer_bytes;
    return buffer_reserve(b, m->device, (size_t)(grows ? roomy : bytes), err);
}

bool motion_read_flags(duet_motion *m, duet_error *err)
{
    return timeline_read(&m->times, "flags", &m->buffers[FLAG_WORDS], m->flags, sizeof m->flags,
                         err);
}

bool motion_launch(duet_motion *m, const char *stage, const kernel *k, uint64_t work,
                   duet_error *err)
{
    return timeline_launch(&m->times, stage, k, work, m, err);
}

// SPDX-License-Identifier: MIT
// A time step: the launches that its effects call for, in order.
//
// Without response each object flies free, and where it then touches is looked
// at afterwards. With response the contacts of the step's beginning are solved
// in substeps.
#include "runtime/dynamics/motion_args.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"

#include <math.h>
#include <string.h>

// ---------------------------------------------------------------- free flight

// The parts of a substep: one, or of Yoshida's order 4 two outer ones and one
// between them that goes back.
static void part_times(const duet_motion *m, double times[2])
{
    double h = m->def.dt / m->def.substeps;
    double root = cbrt(2.0);
    bool parted = m->def.integrator == DUET_INTEGRATOR_YOSHIDA;
    times[0] = parted ? h / (2.0 - root) : h;
    times[1] = parted ? -h * root / (2.0 - root) : 0.0;
}

static void add_gravity(motion_args *a, bool real)
{
    const duet_motion_def *d = &a->motion->def;
    const double *at = d->attraction != 0.0 ? d->centre : d->gravity;
    void (*add)(motion_args *, double, double, double, double) = real ? args_real4 : args_float4;
    add(a, at[0], at[1], d->dims == 3 ? at[2] : 0.0, d->attraction);
}

// What a substep adds to the velocity of all that falls, and 1 / its time. An
// attraction, which differs from place to place, is left out.
static void add_pull(motion_args *a)
{
    const duet_motion_def *d = &a->motion->def;
    double h = d->dt / d->substeps;
    double part = d->attraction != 0.0 ? 0.0 : h;
    args_float4(a, part * d->gravity[0], part * d->gravity[1],
                d->dims == 3 ? part * d->gravity[2] : 0.0, 1.0 / h);
}

static void add_box(motion_args *a)
{
    const duet_motion_def *d = &a->motion->def;
    bool any = d->edge != DUET_EDGE_NONE;
    const double far = 1e30;
    args_real4(a, any ? d->lower[0] : -far, any ? d->lower[1] : -far, any ? d->lower[2] : -far, 0);
    args_real4(a, any ? d->upper[0] : far, any ? d->upper[1] : far, any ? d->upper[2] : far, 0);
}

static bool fly(duet_motion *m, duet_error *err)
{
    double times[2];
    part_times(m, times);
    bool turns = motion_has(m, DUET_EFFECT_ANGULAR_VELOCITY);
    bool walls = motion_has(m, DUET_EFFECT_BOUNDS) && m->def.edge != DUET_EDGE_PERIODIC;
    motion_args a = args_begin(m);
    args_buffer(&a, CENTRES);
    args_cells(&a);
    args_buffer(&a, VELOCITIES);
    args_buffer_for(&a, DUET_EFFECT_ANGULAR_VELOCITY, ROTATIONS);
    args_buffer_for(&a, DUET_EFFECT_ANGULAR_VELOCITY, ANGULAR_VELOCITIES);
    if (turns && m->facts.uneven)
        args_buffer(&a, INERTIAS);
    if (motion_has(m, DUET_EFFECT_GRAVITY))
        add_gravity(&a, true);
    if (motion_has(m, DUET_EFFECT_DRAG)) {
        double half =
            m->def.integrator == DUET_INTEGRATOR_EULER ? 1.0 : 0.5; // drag comes once, or twice
        args_real4(&a, exp(-m->def.drag * half * times[0]), exp(-m->def.drag * half * times[1]),
                   0.0, 0.0);
    }
    if (motion_has(m, DUET_EFFECT_BOUNDS))
        add_box(&a);
    if (walls) {
        args_buffer(&a, HALVES);
        if (motion_has(m, DUET_EFFECT_ROTATION) && !turns)
            args_buffer(&a, ROTATIONS);
    }
    args_real4(&a, times[0], times[1], 0.0, 0.0);
    args_uint(&a, m->def.substeps);
    args_uint(&a, m->n);
    return args_launch(&a, "integrate", m->kernels.integrate_free_flight, m->n, err);
}

// ---------------------------------------------------------------- response

static bool update_sleep(duet_motion *m, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, LINKS);
    args_buffer(&a, TOUCHES);
    args_buffer(&a, STARTS);
    args_buffer(&a, RETURN_STARTS);
    args_buffer(&a, RETURNS);
    args_uint(&a, m->n);
    args_buffer(&a, RESTS);
    args_buffer(&a, VELOCITIES);
    args_buffer_for(&a, DUET_EFFECT_ANGULAR_VELOCITY, ANGULAR_VELOCITIES);
    args_float(&a, m->def.sleep_after);
    args_buffer(&a, ASLEEP);
    args_buffer(&a, FLAG_WORDS);
    return args_launch(&a, "sleep", m->kernels.update_sleep, m->n, err);
}

static bool prepare_bodies(duet_motion *m, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, VELOCITIES);
    args_buffer_for(&a, DUET_EFFECT_ANGULAR_VELOCITY, ROTATIONS);
    args_buffer_for(&a, DUET_EFFECT_ANGULAR_VELOCITY, ANGULAR_VELOCITIES);
    args_buffer_for(&a, DUET_EFFECT_ANGULAR_VELOCITY, INERTIAS);
    args_buffer_for(&a, DUET_EFFECT_SLEEP, ASLEEP);
    args_uint(&a, m->n);
    args_buffer(&a, BODIES);
    return args_launch(&a, "integrate", m->kernels.prepare_bodies, (uint64_t)m->n + MOTION_WALLS,
                       err);
}

// Bodies and where they touch. What is woken by a touch has its mass again
// before it is pushed.
static bool touch(duet_motion *m, duet_error *err)
{
    if (!prepare_bodies(m, err) || !motion_touch(m, false, err))
        return false;
    if (!motion_has(m, DUET_EFFECT_SLEEP))
        return true;
    if (!update_sleep(m, err) || !motion_read_flags(m, err))
        return false;
    return !m->flags[FLAG_FELL_ASLEEP] || (prepare_bodies(m, err) && motion_touch(m, true, err));
}

static bool integrate_velocities(duet_motion *m, double h, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, BODIES);
    args_uint(&a, m->n);
    if (motion_has(m, DUET_EFFECT_GRAVITY)) {
        add_gravity(&a, false);
        if (m->def.attraction != 0.0)
            args_buffer(&a, CENTRES);
    }
    if (motion_has(m, DUET_EFFECT_DRAG))
        args_float(&a, exp(-m->def.drag * h));
    args_float(&a, h);
    return args_launch(&a, "integrate", m->kernels.integrate_velocities, m->n, err);
}

static bool integrate_positions(duet_motion *m, double h, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, BODIES);
    args_uint(&a, m->n);
    if (motion_has(m, DUET_EFFECT_ANGULAR_VELOCITY) && m->facts.uneven) {
        args_buffer(&a, ROTATIONS);
        args_buffer(&a, INERTIAS);
    }
    args_float(&a, h);
    return args_launch(&a, "integrate", m->kernels.integrate_positions, m->n, err);
}

static bool finalize_bodies(duet_motion *m, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, BODIES);
    args_uint(&a, m->n);
    args_buffer(&a, CENTRES);
    args_cells(&a);
    args_buffer_for(&a, DUET_EFFECT_ANGULAR_VELOCITY, ROTATIONS);
    args_buffer_for(&a, DUET_EFFECT_ANGULAR_VELOCITY, ANGULAR_VELOCITIES);
    if (motion_has(m, DUET_EFFECT_SLEEP)) {
        args_buffer(&a, ASLEEP);
        args_buffer(&a, RESTS);
        args_buffer(&a, HALVES);
        args_float(&a, m->def.dt);
        args_float(&a, m->def.sleep_speed);
        args_float(&a, m->def.sleep_after);
    }
    args_buffer(&a, VELOCITIES);
    return args_launch(&a, "integrate", m->kernels.finalize_bodies, m->n, err);
}

// A damped spring, implicitly: how fast overlap is pushed out per depth, what
// part of the mass answers, and what part of the push decays.
static void add_spring(motion_args *a, double h, double hertz)
{
    const double damping = 10.0;
    double omega = 2.0 * 3.14159265358979323846 * hertz;
    double stiff = 2.0 * damping + h * omega;
    double soft = h * omega * stiff;
    double part = 1.0 / (1.0 + soft);
    args_float4(a, omega / stiff, soft * part, part, a->motion->def.max_push_speed);
}

// Where the colour's contacts are in blocks, and how many a work-item takes: all
// of those that found no colour.
static void add_slots(motion_args *a, uint32_t colour, const kernel *k)
{
    const colour_span *span = &a->motion->colours[colour];
    bool in_order = colour == COLOUR_OVERFLOW;
    args_uint(a, span->slot);
    args_uint(a, in_order ? span->count : k->per_item);
    args_uint(a, in_order ? a->motion->layout.block : 1);
    args_buffer(a, BLOCKS);
}

static bool launch_colour(motion_args *a, uint32_t colour, const kernel *k, duet_error *err)
{
    uint32_t count = a->motion->colours[colour].count;
    bool in_order = colour == COLOUR_OVERFLOW;
    return args_launch(a, "solve_contacts", k, in_order && count > 0 ? 1 : count, err);
}

static bool prepare_contacts_colour(duet_motion *m, uint32_t colour, duet_error *err)
{
    const colour_span *span = &m->colours[colour];
    motion_args a = args_begin(m);
    args_buffer(&a, LINKS);
    args_buffer(&a, TOUCHES);
    args_buffer(&a, CONTACTS);
    args_buffer(&a, BOUNCES);
    args_buffer_for(&a, DUET_EFFECT_FRICTION, FRICTIONS);
    args_uint(&a, m->n);
    args_buffer(&a, LIST);
    args_uint(&a, span->first);
    args_uint(&a, span->count);
    add_slots(&a, colour, m->kernels.prepare_contacts);
    args_buffer(&a, BODIES);
    return launch_colour(&a, colour, m->kernels.prepare_contacts, err);
}

static bool solve_colour(duet_motion *m, uint32_t colour, uint32_t soft, double h, duet_error *err)
{
    double hertz = 0.25 / h; // four substeps a swing, as fast as they can follow
    motion_args a = args_begin(m);
    args_uint(&a, m->colours[colour].count);
    add_slots(&a, colour, m->kernels.solve_contacts);
    args_buffer(&a, BODIES);
    args_uint(&a, soft);
    args_float(&a, 1.0 / h);
    add_spring(&a, h, hertz);
    add_spring(&a, h, 2.0 * hertz);
    args_float(&a, m->margin / MOTION_SLOPS);
    return launch_colour(&a, colour, m->kernels.solve_contacts, err);
}

static bool apply_restitution_colour(duet_motion *m, uint32_t colour, duet_error *err)
{
    motion_args a = args_begin(m);
    args_uint(&a, m->colours[colour].count);
    add_slots(&a, colour, m->kernels.apply_restitution);
    args_buffer(&a, BODIES);
    add_pull(&a);
    args_float(&a, m->def.restitution_threshold);
    return launch_colour(&a, colour, m->kernels.apply_restitution, err);
}

static bool store_impulses_colour(duet_motion *m, uint32_t colour, duet_error *err)
{
    const colour_span *span = &m->colours[colour];
    motion_args a = args_begin(m);
    args_buffer(&a, LIST);
    args_uint(&a, span->first);
    args_uint(&a, span->count);
    add_slots(&a, colour, m->kernels.store_impulses);
    args_buffer(&a, CONTACTS);
    return launch_colour(&a, colour, m->kernels.store_impulses, err);
}

static bool for_colours(duet_motion *m, bool (*run)(duet_motion *, uint32_t, duet_error *),
                        duet_error *err)
{
    bool ok = true;
    for (uint32_t colour = 0; ok && colour <= COLOUR_OVERFLOW; ++colour)
        ok = run(m, colour, err);
    return ok;
}

static bool solve(duet_motion *m, uint32_t soft, double h, duet_error *err)
{
    bool ok = true;
    for (uint32_t colour = 0; ok && colour <= COLOUR_OVERFLOW; ++colour)
        ok = solve_colour(m, colour, soft, h, err);
    return ok;
}

static bool respond(duet_motion *m, duet_error *err)
{
    double h = m->def.dt / m->def.substeps;
    bool ok = motion_build_graph(m, err) && touch(m, err) && motion_colour(m, err) &&
              for_colours(m, prepare_contacts_colour, err);
    for (uint32_t k = 0; ok && k < m->def.substeps; ++k)
        ok = budget_check(err) && integrate_velocities(m, h, err) && solve(m, 1, h, err) &&
             integrate_positions(m, h, err) && solve(m, 0, h, err);
    ok = ok && (!m->facts.bouncing || for_colours(m, apply_restitution_colour, err));
    return ok && for_colours(m, store_impulses_colour, err) && finalize_bodies(m, err);
}

// ---------------------------------------------------------------- a step

static bool run_effects(duet_motion *m, duet_error *err)
{
    if (m->n == 0 || m->def.dt == 0.0 || m->effects == 0)
        return true;
    bool contact = motion_has(m, DUET_EFFECT_CONTACT);
    if (contact && !motion_clear_flags(m, err))
        return false;
    if (motion_has(m, DUET_EFFECT_CONTACT_RESPONSE))
        return respond(m, err);
    if (motion_has(m, DUET_EFFECT_MOTION) && !fly(m, err))
        return false;
    return !contact || (motion_build_graph(m, err) && motion_touch(m, false, err));
}

static bool fetch_events(duet_motion *m, duet_error *err)
{
    bool any = motion_has(m, DUET_EFFECT_EVENTS) && m->n > 0 && m->def.dt > 0.0;
    return !any || (motion_read_flags(m, err) && motion_fetch_events(m, err));
}

static void fill_result(duet_motion *m, duet_motion_result *result)
{
    *result = (duet_motion_result){
        .step = m->step,
        .time = (double)m->step * m->def.dt,
        .pairs = m->n_pairs,
        .contacts = m->n_pushing,
        .colours = m->n_colours,
        .rebuilt = m->rebuilt,
        .events = m->events,
        .n_events = m->n_events,
        .stages = m->times.stages,
        .n_stages = (uint32_t)m->times.n_stages,
    };
}

bool duet_motion_advance(duet_motion *m, duet_motion_result *result, duet_error *err)
{
    if (!motion_is_whole(m, __func__, err) || !error_given(result, __func__, "result", err) ||
        !budget_check(err))
        return false;
    uint64_t begun = clock_steady_ns();
    timeline_begin(&m->times, m->device);
    m->rebuilt = false;
    m->n_events = 0;
    bool ok = run_effects(m, err) && fetch_events(m, err) && timeline_finish(&m->times, err);
    m->broken = !ok;
    if (!ok) {
        timeline_clear(&m->times);
        return false;
    }
    ++m->step;
    fill_result(m, result);
    result->total_ms = (double)(clock_steady_ns() - begun) * 1e-6;
    return true;
}

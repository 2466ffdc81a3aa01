// SPDX-License-Identifier: MIT
// A time step: the launches that its effects call for, in order.
//
// Without response each object flies free, and where it then touches is looked
// at afterwards. With response the contacts of the step's beginning are solved
// in substeps.
#include "runtime/dynamics/motion.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"

#include <string.h>

// ---------------------------------------------------------------- response

static bool prepare_bodies(duet_motion *m, duet_error *err)
{
    return motion_launch(m, "integrate", m->kernels.prepare_bodies, (uint64_t)m->n + MOTION_WALLS,
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
    if (!motion_launch(m, "sleep", m->kernels.update_sleep, m->n, err) ||
        !motion_read_flags(m, err))
        return false;
    return !m->flags[FLAG_FELL_ASLEEP] || (prepare_bodies(m, err) && motion_touch(m, true, err));
}

// Runs a kernel over one colour's contacts, in blocks or in the list. Those that found no
// colour are taken in order, by one work-item.
static bool launch_colour(duet_motion *m, const kernel *k, uint32_t colour, duet_error *err)
{
    const colour_span *span = &m->colours[colour];
    bool in_order = colour == COLOUR_OVERFLOW;
    m->args.first = span->first;
    m->args.count = span->count;
    m->args.first_slot = span->slot;
    m->args.each = in_order ? span->count : k->per_item;
    m->args.apart = in_order ? m->layout.block : 1;
    return motion_launch(m, "solve_contacts", k, in_order && span->count > 0 ? 1 : span->count,
                         err);
}

static bool for_colours(duet_motion *m, const kernel *k, duet_error *err)
{
    bool ok = true;
    for (uint32_t colour = 0; ok && colour <= COLOUR_OVERFLOW; ++colour)
        ok = launch_colour(m, k, colour, err);
    return ok;
}

static bool solve(duet_motion *m, uint32_t soft, duet_error *err)
{
    m->args.soft = soft;
    return for_colours(m, m->kernels.solve_contacts, err);
}

static bool substep(duet_motion *m, duet_error *err)
{
    const motion_kernels *k = &m->kernels;
    return budget_check(err) && motion_launch(m, "integrate", k->integrate_velocities, m->n, err) &&
           solve(m, 1, err) && motion_launch(m, "integrate", k->integrate_positions, m->n, err) &&
           solve(m, 0, err);
}

static bool respond(duet_motion *m, duet_error *err)
{
    const motion_kernels *k = &m->kernels;
    bool ok = motion_build_graph(m, err) && touch(m, err) && motion_colour(m, err) &&
              for_colours(m, k->prepare_contacts, err);
    for (uint32_t i = 0; ok && i < m->def.substeps; ++i)
        ok = substep(m, err);
    ok = ok && (!m->facts.elastic || for_colours(m, k->apply_restitution, err));
    return ok && for_colours(m, k->store_impulses, err) &&
           motion_launch(m, "integrate", k->finalize_bodies, m->n, err);
}

// ---------------------------------------------------------------- a step

static bool run_effects(duet_motion *m, duet_error *err)
{
    if (m->n == 0 || m->def.dt == 0.0 || m->effects == 0)
        return true;
    bool contact = motion_has(m, DUET_EFFECT_CONTACT);
    bool flies = motion_has(m, DUET_EFFECT_MOTION);
    motion_set_args(m);
    if (contact && !motion_clear_flags(m, err))
        return false;
    if (motion_has(m, DUET_EFFECT_CONTACT_RESPONSE))
        return respond(m, err);
    if (flies && !motion_launch(m, "integrate", m->kernels.integrate_free_flight, m->n, err))
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

// SPDX-License-Identifier: MIT
// A time step: the launches that its effects call for, in order.
//
// Without response each object flies free, and where it then touches is looked
// at afterwards. With response the contacts of the step's beginning are solved
// in substeps.
//
// In two halves a thread of the motion's own takes the step while the caller works. What a
// caller may ask meanwhile changes only in the second half.
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_map.h"
#include "runtime/dynamics/recording.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"

// ---------------------------------------------------------------- between steps

bool motion_is_under_way(const duet_motion *m)
{
    return m->background.under_way;
}

bool motion_is_idle(const duet_motion *m, const char *call, duet_error *err)
{
    return !motion_is_under_way(m) ||
           error_set(
               err, DUET_STATUS_BAD_ARGUMENT,
               "%s: a step of the motion is under way; expected duet_motion_advance_end first",
               call);
}

bool motion_is_steady(const duet_motion *m, const char *call, duet_error *err)
{
    return error_given(m, call, "motion", err) && motion_is_idle(m, call, err) &&
           (!m->broken ||
            error_set(err, DUET_STATUS_BAD_ARGUMENT,
                      "the motion failed in its step %llu; expected a saved one to be loaded, or a "
                      "new motion",
                      (unsigned long long)m->step + 1));
}

bool motion_is_whole(const duet_motion *m, const char *call, duet_error *err)
{
    return motion_is_steady(m, call, err) && motion_is_unmapped(m, call, err);
}

// ---------------------------------------------------------------- response

// woken: only of what woke in this step, where anything did.
static bool find_manifolds(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->args.woken = woken;
    return motion_launch(m, "manifolds", m->kernels.build_manifolds, m->n_contacts, err);
}

static bool prepare_bodies(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->args.woken = woken;
    return motion_launch(m, "integrate", m->kernels.prepare_bodies, (uint64_t)m->n + MOTION_WALLS,
                         err);
}

// Bodies and where they touch. What is woken by a touch has its mass again
// before it is pushed.
static bool touch(duet_motion *m, duet_error *err)
{
    return prepare_bodies(m, 0, err) && find_manifolds(m, 0, err) &&
           (!motion_has(m, DUET_EFFECT_SLEEP) ||
            (motion_launch(m, "sleep", m->kernels.update_sleep, m->n, err) &&
             prepare_bodies(m, 1, err) && find_manifolds(m, 1, err)));
}

static uint32_t most_of(const duet_motion *m, uint32_t from, uint32_t to)
{
    uint32_t most = 0;
    for (uint32_t colour = from; colour < to; ++colour)
        most = m->colours[colour].count > most ? m->colours[colour].count : most;
    return most;
}

// Runs a kernel over the contacts of these colours, one colour after the other.
static bool launch_colours(duet_motion *m, const kernel *k, uint32_t from, uint32_t to,
                           uint32_t each, uint64_t work, duet_error *err)
{
    const colour_span *span = &m->colours[from];
    m->args.span = (cl_int4){{(cl_int)span->first, (cl_int)span->count, (cl_int)span->slot}};
    m->args.from_colour = from;
    m->args.to_colour = to;
    m->args.each = each;
    return motion_launch(m, "solve_contacts", k, work, err);
}

// Colours that one work-group has space for are taken by the same one.
static uint32_t end_of_few(const duet_motion *m, const kernel *k, uint32_t from)
{
    uint32_t to = from + 1;
    if (m->colours[from].count <= k->group * k->per_item)
        while (to < COLOUR_OVERFLOW && m->colours[to].count <= k->group * k->per_item)
            ++to;
    return to;
}

// What found no colour is taken in order, by one work-item.
static bool for_colours(duet_motion *m, const kernel *k, duet_error *err)
{
    uint32_t in_order = m->colours[COLOUR_OVERFLOW].count;
    bool ok = true;
    for (uint32_t from = 0, to = 0; ok && from < COLOUR_OVERFLOW; from = to) {
        to = end_of_few(m, k, from);
        ok = launch_colours(m, k, from, to, k->per_item, most_of(m, from, to), err);
    }
    return ok && (in_order == 0 ||
                  launch_colours(m, k, COLOUR_OVERFLOW, COLOUR_OVERFLOW + 1, in_order, 1, err));
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

// Each contact has its own.
static bool store_impulses(duet_motion *m, duet_error *err)
{
    const kernel *k = m->kernels.store_impulses;
    return launch_colours(m, k, 0, COLOUR_OVERFLOW + 1, k->per_item,
                          most_of(m, 0, COLOUR_OVERFLOW + 1), err);
}

// What sleeps deep in others goes when all else has gone, so that whatever it then touches is
// searched for where it is. The flags are those that colours were chosen by.
static bool push_sleepers(duet_motion *m, duet_error *err)
{
    const motion_kernels *k = &m->kernels;
    bool ok = true;
    if (!motion_has(m, DUET_EFFECT_SLEEP) || m->n_contacts == 0 || !m->flags[FLAG_PRESSED])
        return true;
    for (m->args.round = 0; ok && m->args.round < PRESSED_ROUNDS; ++m->args.round)
        ok = motion_launch(m, "sleep", k->push_sleepers, m->n, err);
    return ok && motion_launch(m, "sleep", k->move_sleepers, m->n, err);
}

static bool respond(duet_motion *m, duet_error *err)
{
    const motion_kernels *k = &m->kernels;
    bool ok = motion_build_graph(m, err) && touch(m, err) && motion_colour(m, err) &&
              for_colours(m, k->prepare_contacts, err);
    for (uint32_t i = 0; ok && i < m->def.substeps; ++i)
        ok = substep(m, err);
    ok = ok && (!m->facts.elastic || for_colours(m, k->apply_restitution, err));
    ok = ok && store_impulses(m, err) && motion_note_events(m, err) &&
         motion_launch(m, "integrate", k->finalize_bodies, m->n, err) && push_sleepers(m, err);
    if (!motion_has(m, DUET_EFFECT_SKIN))
        return ok;
    m->bounds_checked = ok && motion_check_bounds(m, err);
    return m->bounds_checked;
}

// ---------------------------------------------------------------- a step

static bool run_effects(duet_motion *m, duet_error *err)
{
    bool contact = motion_has(m, DUET_EFFECT_CONTACT);
    bool flies = motion_has(m, DUET_EFFECT_MOTION);
    motion_set_args(m);
    if (!motion_recall_events(m, err))
        return false;
    if (contact && !timeline_fill(&m->times, "clear", &m->buffers[FLAG_WORDS], 0, 0, FLAGS, err))
        return false;
    if (motion_has(m, DUET_EFFECT_CONTACT_RESPONSE))
        return respond(m, err);
    if (flies && !motion_launch(m, "integrate", m->kernels.integrate_free_flight, m->n, err))
        return false;
    return !contact ||
           (motion_build_graph(m, err) && find_manifolds(m, 0, err) && motion_note_events(m, err));
}

// What the step leaves to be known: whether bounds still hold, what sleeps, and events.
static bool hear(duet_motion *m, duet_error *err)
{
    if (!m->bounds_checked && !motion_has(m, DUET_EFFECT_SLEEP | DUET_EFFECT_EVENTS))
        return true;
    if (!motion_read_flags(m, err))
        return false;
    m->at_rest =
        motion_has(m, DUET_EFFECT_SLEEP) && !m->flags[FLAG_AWAKE] && !m->flags[FLAG_FELL_ASLEEP];
    return !motion_has(m, DUET_EFFECT_EVENTS) || motion_fetch_events(m, err);
}

// Nothing is sent to the device where nothing would change.
static bool run_step(duet_motion *m, duet_error *err)
{
    bool still = m->n == 0 || m->def.dt == 0.0 || m->effects == 0 || m->at_rest;
    return still ? motion_keep_events(m, err)
                 : run_effects(m, err) && hear(m, err) && timeline_finish(&m->times, err);
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
        .events = m->told.changes.events,
        .n_events = m->told.changes.n_events,
        .stays = m->told.changes.stays.pairs,
        .n_stays = m->told.changes.stays.n,
        .hits = m->told.hits,
        .n_hits = m->told.n_hits,
        .stages = m->times.stages,
        .n_stages = m->times.n_launches > 0 ? (uint32_t)m->times.n_stages : 0,
        .timed = !m->times.untimed,
    };
}

static bool carry_step(duet_motion *m, double *ms, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    if (m->def.stage_times || timeline_is_due(&m->times, m->device, m->step))
        timeline_begin(&m->times, m->device);
    else
        timeline_begin_untimed(&m->times, m->device);
    m->rebuilt = false;
    bool ok = run_step(m, err);
    *ms = clock_ms_since(begun);
    return ok;
}

static bool complete_step(duet_motion *m, bool carried, double ms, duet_motion_result *result,
                          duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    m->broken = !carried || (m->commands && !motion_end_commands(m, err));
    if (m->broken) {
        timeline_clear(&m->times);
        motion_forget_recording(m);
        return false;
    }
    ++m->step;
    motion_note_step(m);
    fill_result(m, result);
    m->times.untimed = true; // what comes between steps is of none
    result->total_ms = ms + clock_ms_since(begun);
    return true;
}

bool duet_motion_advance(duet_motion *m, duet_motion_result *result, duet_error *err)
{
    double ms = 0.0;
    if (!motion_is_whole(m, __func__, err) || !error_given(result, __func__, "result", err) ||
        !budget_check(err))
        return false;
    bool carried = carry_step(m, &ms, err);
    return complete_step(m, carried, ms, result, err);
}

// ---------------------------------------------------------------- in two halves

static void carry(void *arg)
{
    duet_motion *m = arg;
    m->background.ok = carry_step(m, &m->background_ms, &m->background.err);
}

bool duet_motion_advance_begin(duet_motion *m, duet_error *err)
{
    if (!motion_is_whole(m, __func__, err) || !background_open(&m->background, err))
        return false;
    background_start(&m->background, carry, m);
    return true;
}

bool duet_motion_advance_end(duet_motion *m, duet_motion_result *result, duet_error *err)
{
    if (!error_given(m, __func__, "motion", err) || !error_given(result, __func__, "result", err))
        return false;
    if (!motion_is_under_way(m))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: no step is under way; expected duet_motion_advance_begin first",
                         __func__);
    bool carried = background_end(&m->background, err);
    return complete_step(m, carried, m->background_ms, result, err);
}

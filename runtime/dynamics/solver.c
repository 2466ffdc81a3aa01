// SPDX-License-Identifier: MIT
// Contact response: the contacts of a step's beginning, by colour, solved in substeps.
//
// Contacts of one colour share no body that moves, so that a launch solves them in parallel.
// Contacts that find no colour are solved in order.
#include "runtime/dynamics/domain_motion.h"

#include "base/budget.h"

// ---------------------------------------------------------------- substeps

static uint32_t most_of(const contact_solver *s, uint32_t from, uint32_t to)
{
    uint32_t most = 0;
    for (uint32_t colour = from; colour < to; ++colour)
        most = s->colours[colour].count > most ? s->colours[colour].count : most;
    return most;
}

static cl_int4 span_of(const contact_solver *s, uint32_t colour)
{
    const colour_span *span = &s->colours[colour];
    return (cl_int4){{(cl_int)span->first, (cl_int)span->count, (cl_int)span->slot}};
}

// Runs a kernel over the contacts of these colours, one colour after the other.
static bool launch_colours(duet_motion *m, motion_kernel which, uint32_t from, uint32_t to,
                           uint32_t each, uint64_t work, duet_error *err)
{
    m->solver.span = span_of(&m->solver, from);
    m->solver.from_colour = from;
    m->solver.to_colour = to;
    m->solver.each = each;
    return motion_launch_over(m, which, work, err);
}

// Colours that one work-group has space for are taken by the same one.
static uint32_t end_of_few(const contact_solver *s, const kernel *k, uint32_t from, uint32_t to)
{
    uint32_t end = from + 1;
    if (s->colours[from].count <= k->group * k->per_item)
        while (end < to && s->colours[end].count <= k->group * k->per_item)
            ++end;
    return end;
}

// Takes colours below COLOUR_OVERFLOW.
static bool launch_below(duet_motion *m, motion_kernel which, uint32_t from, uint32_t to,
                         duet_error *err)
{
    const contact_solver *s = &m->solver;
    const kernel *k = m->kernels.of[which];
    bool ok = true;
    for (uint32_t next; ok && from < to; from = next) {
        next = end_of_few(s, k, from, to);
        ok = launch_colours(m, which, from, next, k->per_item, most_of(s, from, next), err);
    }
    return ok;
}

static bool launch_team(duet_motion *m, motion_kernel which, uint32_t from, uint32_t to,
                        uint32_t most, duet_error *err)
{
    contact_solver *s = &m->solver;
    s->span = span_of(s, from);
    s->from_colour = from;
    s->to_colour = to;
    return from == to || team_launch(m, which, most, TEAM_LEAST_PART, to - from, err);
}

// Takes colours: a team in one launch; else contacts that found no colour come last, in order, by
// one work-item.
static bool take_colours(duet_motion *m, motion_kernel which, uint32_t from, uint32_t to,
                         duet_error *err)
{
    const contact_solver *s = &m->solver;
    const uint32_t below = to < COLOUR_OVERFLOW ? to : COLOUR_OVERFLOW;
    if (motion_has_team(m, which))
        return launch_team(m, which, from, to, most_of(s, from, below), err);
    return launch_below(m, which, from, below, err) &&
           (to == below || launch_colours(m, which, below, to, s->colours[below].count, 1, err));
}

static uint32_t end_of_colours(const contact_solver *s)
{
    uint32_t to = COLOUR_OVERFLOW + 1;
    while (to > 0 && s->colours[to - 1].count == 0)
        --to;
    return to;
}

static bool for_colours(duet_motion *m, motion_kernel which, duet_error *err)
{
    return take_colours(m, which, 0, end_of_colours(&m->solver), err);
}

static bool solve(duet_motion *m, uint32_t soft, duet_error *err)
{
    m->solver.soft = soft;
    return for_colours(m, SOLVE_CONTACTS, err);
}

bool motion_has_shocks(const duet_motion *m)
{
    return (m->effects & DUET_EFFECT_SHOCKS) && (m->facts & FACT_ELASTIC);
}

// The first sweep looks at all contacts, and the others go on while something bounced.
static bool solve_shocks(duet_motion *m, duet_error *err)
{
    contact_solver *s = &m->solver;
    bool ok = true;
    if (!motion_has_shocks(m))
        return true;
    s->first_sweep = s->sweep;
    for (int i = 0; ok && i < SHOCK_SWEEPS; ++i, ++s->sweep)
        ok = for_colours(m, SOLVE_SHOCKS, err);
    return ok;
}

// Contacts are soft springs, and then relax without these.
static bool substep(duet_motion *m, duet_error *err)
{
    return motion_launch(m, INTEGRATE_VELOCITIES, err) && solve_shocks(m, err) &&
           solve(m, 1, err) && motion_launch(m, INTEGRATE_POSITIONS, err) && solve(m, 0, err);
}

// Each contact has its own.
static bool store_impulses(duet_motion *m, duet_error *err)
{
    const kernel *k = m->kernels.of[STORE_IMPULSES];
    return launch_colours(m, STORE_IMPULSES, 0, COLOUR_OVERFLOW + 1, k->per_item,
                          most_of(&m->solver, 0, COLOUR_OVERFLOW + 1), err);
}

// A sleeper deep in others goes when all else has gone, so that whatever it then touches is
// searched for where it is.
static bool push_sleepers(duet_motion *m, uint32_t from, uint32_t to, duet_error *err)
{
    const kernel *k = m->kernels.of[PUSH_SLEEPERS];
    m->solver.from_round = from;
    m->solver.to_round = to;
    if (k->groups != GROUPS_TEAM && to == from + 1)
        return motion_launch(m, PUSH_SLEEPERS, err);
    return team_launch(m, PUSH_SLEEPERS, m->awake.n_bodies,
                       k->group > 1 ? k->group : TEAM_LEAST_BODIES, to - from, err);
}

// Groups that meet have a work-item for each body, or take one round a launch.
static uint32_t rounds_at_once(const duet_motion *m)
{
    const kernel *k = m->kernels.of[PUSH_SLEEPERS];
    const bool meet = k->groups == GROUPS_MEET &&
                      m->awake.n_bodies <= (uint64_t)team_most_groups(m, k) * k->group;
    return k->groups == GROUPS_TEAM || meet ? PRESSED_ROUNDS + 1 : 1;
}

static bool push_all_rounds(duet_motion *m, duet_error *err)
{
    const uint32_t each = rounds_at_once(m);
    bool ok = true;
    for (uint32_t from = 0; ok && from <= PRESSED_ROUNDS; from += each)
        ok = push_sleepers(m, from, from + each, err);
    return ok;
}

// ---------------------------------------------------------------- all passes at once

// Bodies that take as long as a contact of a colour, and fewer if groups meet; contacts of a
// colour, or bodies that take as long, that a group has at least; passes of a substep, and of a
// launch of a team; contacts of a colour that a work-item takes one after the other at most if
// groups meet.
enum {
    BODIES_OF_ONE = 4,
    BODIES_OF_MEETING = 2,
    GROUP_LEAST = 64,
    PASSES = 2,
    TEAM_PASSES = 2 * PASSES,
    CONTACTS_OF_ONE = 2
};

// Contacts of a colour, or bodies that take as long as those.
static uint32_t most_work(const duet_motion *m, const kernel *k)
{
    const uint32_t each = k->groups == GROUPS_MEET ? BODIES_OF_MEETING : BODIES_OF_ONE;
    const uint32_t contacts = most_of(&m->solver, 0, COLOUR_OVERFLOW);
    const uint32_t bodies = (m->awake.n_bodies + each - 1) / each;
    return contacts > bodies ? contacts : bodies;
}

// Whether a launch of passes has space for every colour. Groups that meet are as many as run at
// once. If they do not meet there is one, which takes no contacts in order.
static bool have_space(const duet_motion *m, const kernel *k)
{
    const uint64_t takes = (uint64_t)k->group * k->per_item;
    if (k->groups == GROUPS_MEET)
        return most_work(m, k) <= CONTACTS_OF_ONE * takes * team_most_groups(m, k);
    return most_work(m, k) <= takes && m->awake.n_bodies <= SOLVER_FEW &&
           m->solver.colours[COLOUR_OVERFLOW].count == 0;
}

// Takes passes (solve_substeps.cl).
static bool launch_passes(duet_motion *m, uint32_t from, uint32_t to, duet_error *err)
{
    const kernel *k = m->kernels.of[SOLVE_SUBSTEPS];
    contact_solver *s = &m->solver;
    s->from_pass = from;
    s->to_pass = to;
    s->to_colour = m->graph.n_contacts > 0 ? COLOUR_OVERFLOW + 1 : 0;
    if (k->groups == GROUPS_APART)
        return motion_launch_over(m, SOLVE_SUBSTEPS, 1, err);
    return team_launch(m, SOLVE_SUBSTEPS, most_work(m, k), k->group > 1 ? k->group : GROUP_LEAST,
                       (to - from) * (1 + s->to_colour), err);
}

// A team of several may lose members up to the end of a launch, which is then not that of the step.
static uint32_t passes_at_once(const duet_motion *m, uint32_t passes)
{
    const kernel *k = m->kernels.of[SOLVE_SUBSTEPS];
    return k->groups == GROUPS_TEAM && most_work(m, k) > GROUP_LEAST ? TEAM_PASSES : passes;
}

// Shocks have given back all speed.
static bool restores_speeds(const duet_motion *m)
{
    return (m->facts & FACT_ELASTIC) && !motion_has_shocks(m);
}

static bool solve_at_once(duet_motion *m, duet_error *err)
{
    const uint32_t last = PASSES * m->def.substeps, end = last + 1 + restores_speeds(m);
    const uint32_t each = passes_at_once(m, end);
    bool ok = true;
    for (uint32_t from = 0, to; ok && from < end; from = to) {
        to = from + each + (from == 0);
        to = to > last ? end : to;
        ok = budget_check(err) && launch_passes(m, from, to, err);
    }
    return ok;
}

// ---------------------------------------------------------------- all stages

static bool run_substeps(duet_motion *m, duet_error *err)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < m->def.substeps; ++i)
        ok = budget_check(err) && substep(m, err);
    return ok;
}

bool motion_solves_at_once(const duet_motion *m)
{
    const kernel *k = m->kernels.of[SOLVE_SUBSTEPS];
    return k && (k->groups == GROUPS_TEAM || have_space(m, k));
}

bool motion_solve(duet_motion *m, duet_error *err)
{
    if (motion_solves_at_once(m))
        return solve_at_once(m, err);
    return for_colours(m, PREPARE_CONTACTS, err) && run_substeps(m, err) &&
           (!restores_speeds(m) || for_colours(m, APPLY_RESTITUTION, err)) &&
           store_impulses(m, err);
}

bool motion_finalize(duet_motion *m, bool presses, duet_error *err)
{
    return motion_launch(m, FINALIZE_BODIES, err) && (!presses || push_all_rounds(m, err));
}

// ---------------------------------------------------------------- stage by stage

bool domain_push_sleepers(duet_motion *m, uint32_t round, duet_error *err)
{
    return push_sleepers(m, round, round + 1, err);
}

bool domain_prepare_contacts(duet_motion *m, duet_error *err)
{
    return for_colours(m, PREPARE_CONTACTS, err);
}

static bool take_if_any(duet_motion *m, motion_kernel which, uint32_t from, uint32_t to,
                        duet_error *err)
{
    return most_of(&m->solver, from, to) == 0 || take_colours(m, which, from, to, err);
}

// Launches a kernel for n contacts of a colour, from one that begins a block.
static bool launch_some(duet_motion *m, motion_kernel which, uint32_t colour, uint32_t from,
                        uint32_t n, duet_error *err)
{
    contact_solver *s = &m->solver;
    const colour_span *all = &s->colours[colour];
    const uint32_t slots = colour == COLOUR_OVERFLOW ? m->layout.block : 1;
    s->span =
        (cl_int4){{(cl_int)(all->first + from), (cl_int)n, (cl_int)(all->slot + from * slots)}};
    s->from_colour = colour;
    s->to_colour = colour + 1;
    s->each = m->kernels.of[which]->per_item;
    if (n == 0)
        return true;
    return motion_has_team(m, which) ? team_launch(m, which, n, TEAM_LEAST_PART, 1, err)
                                     : motion_launch_over(m, which, n, err);
}

// Returns the kernel of a pass. No sweep of a domain knows whether it is the last one.
static motion_kernel begin_pass(duet_motion *m, domain_pass pass)
{
    m->solver.soft = pass == PASS_SOFT;
    m->solver.first_sweep = m->solver.sweep;
    return pass == PASS_SHOCKS    ? SOLVE_SHOCKS
           : pass == PASS_RESTORE ? APPLY_RESTITUTION
                                  : SOLVE_CONTACTS;
}

bool domain_solve_in_order(duet_motion *m, domain_pass pass, uint32_t i, duet_error *err)
{
    return launch_some(m, begin_pass(m, pass), COLOUR_OVERFLOW, i, 1, err);
}

bool domain_solve_border(duet_motion *m, domain_pass pass, uint32_t from, uint32_t to,
                         duet_error *err)
{
    const motion_kernel which = begin_pass(m, pass);
    const colour_span *first = &m->solver.colours[from];
    if (first->border == first->count)
        return take_if_any(m, which, from, to, err);
    return launch_some(m, which, from, 0, first->border, err) &&
           take_if_any(m, which, from + 1, to, err);
}

// A device that is the host's own is waited for: whoever then waits for messages takes a core.
bool domain_solve_inner(duet_motion *m, domain_pass pass, uint32_t colour, duet_error *err)
{
    const colour_span *span = &m->solver.colours[colour];
    const uint32_t n = span->count - span->border;
    return n == 0 || (launch_some(m, begin_pass(m, pass), colour, span->border, n, err) &&
                      (!m->buffers[BODIES].host || timeline_finish(&m->times, err)));
}

bool domain_end_sweep(duet_motion *m, bool *bounced, duet_error *err)
{
    cl_uint last = 0, sweep = m->solver.sweep++;
    bool ok = m->n == 0 || motion_fetch(m, "solve_contacts", SHOCKED, 0, &last, sizeof last, err);
    *bounced = m->n > 0 && last == sweep;
    return ok;
}

bool domain_store_impulses(duet_motion *m, duet_error *err)
{
    return m->n == 0 || store_impulses(m, err);
}

bool domain_finalize(duet_motion *m, duet_error *err)
{
    return m->n == 0 || (domain_note_events(m, err) && motion_launch(m, FINALIZE_BODIES, err));
}

// SPDX-License-Identifier: MIT
// A step of a scene's bodies over all domains: the stages of one motion's step
// (runtime/dynamics/solver.c), with an exchange of ghosts after each one that leaves them wrong.
#include "cluster/moving_domains.h"

#include "base/error.h"

// ---------------------------------------------------------------- stages

typedef bool domain_stage(duet_motion *m, duet_error *err);

static void each(moving *m, domain_stage *stage, duet_error *own)
{
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        stage(m->domains[k].motion, own);
}

static void each_launch(moving *m, motion_kernel which, duet_error *own)
{
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        motion_launch(m->domains[k].motion, which, own);
}

// Contacts without a colour of their own come one by one, in the order of all ids: a domain takes
// those that it has.
static void solve_in_order(moving *m, domain_pass pass, duet_error *own)
{
    uint64_t *taken = calloc(m->parts, sizeof *taken);
    if (!taken)
        no_memory(own, "contacts in order");
    for (uint64_t i = 0; i < m->n_in_order; ++i) {
        for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
            const row_list *has = &m->domains[k].in_order;
            if (taken[k] < has->n && has->rows[taken[k]] == i)
                domain_solve_in_order(m->domains[k].motion, pass, (uint32_t)taken[k]++, own);
        }
        halo_exchange(&m->halo, m, BODIES, own);
    }
    free(taken);
}

// Colours after which no ghost of this rank goes or comes are solved together with the next one.
static uint32_t end_of_colours(const moving *m, uint32_t from, uint32_t colours)
{
    uint32_t to = from + 1;
    while (to < colours && !halo_comes(&m->halo, to - 1))
        ++to;
    return to;
}

// Brings ghosts of a list, and then solves these colours. While ghosts travel each domain takes the
// first colour's contacts that have no ghost and no body that is one elsewhere: no message holds
// their bodies, whose contacts of the colours before are all solved.
static void solve_after(moving *m, domain_pass pass, uint32_t list, uint32_t from, uint32_t to,
                        duet_error *own)
{
    const bool comes = halo_comes(&m->halo, list);
    const uint64_t begun_ns = ranks_now_ns();
    const int n = halo_begin_after(&m->halo, m, list, own);
    const uint64_t sent_ns = ranks_now_ns();
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        domain_solve_inner(m->domains[k].motion, pass, from, own);
    const uint64_t solved_ns = ranks_now_ns();
    halo_end_after(&m->halo, m, list, n, own);
    if (comes)
        every_note_exchange(&m->trial, sent_ns - begun_ns + ranks_now_ns() - solved_ns);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        domain_solve_border(m->domains[k].motion, pass, from, to, own);
}

// Ghosts of a list come first. What follows needs those that colours left wrong, unless contacts
// relaxed: a substep begins with all ghosts that any contact left wrong.
static void solve(moving *m, domain_pass pass, uint32_t list, duet_error *own)
{
    const uint32_t colours = m->counts.colours < HALO_COLOURS ? m->counts.colours : HALO_COLOURS;
    for (uint32_t from = 0, to; from < colours; from = to) {
        to = end_of_colours(m, from, colours);
        solve_after(m, pass, list, from, to, own);
        list = to - 1;
    }
    if (pass != PASS_RELAX || m->n_in_order > 0)
        halo_exchange_after(&m->halo, m, HALO_END, own);
    if (m->n_in_order > 0)
        solve_in_order(m, pass, own);
}

// Sweeps go on while something bounced in any domain.
static bool solve_shocks(moving *m, duet_error *own)
{
    tally t = {.sums = {motion_has_shocks(m->domains[0].motion)}};
    for (int i = 0; t.sums[0] > 0 && i < SHOCK_SWEEPS; ++i) {
        solve(m, PASS_SHOCKS, HALO_NONE, own);
        t = (tally){0};
        for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
            bool bounced = false;
            domain_end_sweep(m->domains[k].motion, &bounced, own);
            t.sums[0] += bounced;
        }
        if (!ranks_agree_and(m->ranks, is_well(own), &t, own))
            return false;
    }
    return true;
}

// The impulses to warm start with are sums over contacts, of which a ghost lacks some: velocities
// that come of them travel in their place. Positions of ghosts change as their owners' do.
static bool substep(moving *m, duet_error *own)
{
    const bool has_shocks = motion_has_shocks(m->domains[0].motion);
    each_launch(m, INTEGRATE_VELOCITIES, own);
    if (has_shocks)
        halo_exchange_after(&m->halo, m, HALO_ANY, own);
    if (!solve_shocks(m, own))
        return false;
    solve(m, PASS_SOFT, has_shocks ? HALO_NONE : HALO_ANY, own);
    each_launch(m, INTEGRATE_POSITIONS, own);
    solve(m, PASS_RELAX, HALO_NONE, own);
    return true;
}

// Shocks have given back all speed.
static bool run_substeps(moving *m, duet_error *own)
{
    const duet_motion *motion = m->domains[0].motion;
    bool ok = true;
    for (uint32_t i = 0; ok && i < motion->def.substeps; ++i)
        ok = substep(m, own);
    halo_exchange_after(&m->halo, m, HALO_END, own);
    if (ok && (motion->facts & FACT_ELASTIC) && !motion_has_shocks(motion))
        solve(m, PASS_RESTORE, HALO_NONE, own);
    return ok;
}

// Finds what wakes and what falls asleep among the bodies that a domain owns, and tells others:
// rests before bodies look at those that they touch, and then which of them sleep.
static bool update_sleep(moving *m, tally *t, duet_error *own)
{
    *t = (tally){0};
    if (!(m->domains[0].motion->effects & DUET_EFFECT_SLEEP))
        return true;
    halo_exchange(&m->halo, m, RESTS, own);
    each_launch(m, UPDATE_SLEEP, own);
    halo_exchange_asleep(&m->halo, m, own);
    each(m, domain_read_flags, own);
    for (uint32_t k = 0; k < m->parts; ++k) {
        const uint32_t *flags = m->domains[k].motion->flags;
        t->sums[0] += flags[FLAG_FELL_ASLEEP];
        t->sums[1] += flags[FLAG_PRESSED];
    }
    if (!ranks_agree_and(m->ranks, is_well(own), t, own))
        return false;
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        domain_wake_touched(m->domains[k].motion, t->sums[0] > 0, own);
    return true;
}

static void push_sleepers(moving *m, duet_error *own)
{
    for (uint32_t round = 0; round <= PRESSED_ROUNDS; ++round) {
        for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
            domain_push_sleepers(m->domains[k].motion, round, own);
        if (round < PRESSED_ROUNDS)
            halo_exchange_ways(&m->halo, m, round, own);
    }
}

static bool respond(moving *m, duet_error *own)
{
    tally t;
    moving_enter(m, PHASE_MANIFOLDS);
    each(m, domain_begin_step, own);
    moving_enter(m, PHASE_SLEEP);
    if (!update_sleep(m, &t, own) || !moving_colour(m, own))
        return false;
    moving_enter(m, PHASE_SUBSTEPS);
    each(m, domain_prepare_contacts, own);
    if (!run_substeps(m, own))
        return false;
    moving_enter(m, PHASE_FINALIZE);
    const int n = halo_begin_late(&m->halo, m, own);
    each(m, domain_store_impulses, own);
    halo_end_late(&m->halo, m, n, own);
    each(m, domain_finalize, own);
    if (t.sums[1] > 0)
        push_sleepers(m, own);
    each(m, domain_end_step, own);
    return true;
}

// Contacts, which are long, are here only while they are exchanged.
static void forget_contacts(moving *m)
{
    for (uint32_t k = 0; k < m->parts; ++k) {
        free(m->domains[k].contacts.items);
        m->domains[k].contacts = (item_list){0};
    }
}

// Once one domain has to search its pairs, all do: a step lasts as long as its slowest rank, and
// domains that search by turns have one in nearly each step. Sets whether a domain lacks some of
// its pairs.
static bool search_together(moving *m, bool *lacks, duet_error *own)
{
    tally t = {.sums = {0}};
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
        domain_forget_bounds(m->domains[k].motion);
        t.sums[0] += !moving_has_all_pairs(m, &m->domains[k], own);
    }
    bool ok = ranks_agree_and(m->ranks, is_well(own), &t, own);
    *lacks = t.sums[0] > 0;
    return ok;
}

// All ranks know whether a body is to be a ghost elsewhere.
static bool settle_where_due(moving *m, duet_error *own)
{
    tally t = {.sums = {0}};
    bool lacks = false;
    for (uint32_t k = 0; k < m->parts; ++k)
        t.sums[0] += !domain_is_bounded(m->domains[k].motion);
    moving_note_work(m, &t);
    if (!ranks_agree_and(m->ranks, is_well(own), &t, own) || !moving_compare_work(m, &t, own) ||
        (t.sums[0] > 0 && !search_together(m, &lacks, own)))
        return false;
    return (!lacks && !moving_cut_is_due(m)) || moving_settle(m, own);
}

// The only domain's bodies are a motion of their own.
static bool step_alone(moving *m, duet_error *own)
{
    duet_motion_result result;
    forget_contacts(m);
    if (!is_well(own) || !duet_motion_advance(m->domains[0].motion, &result, own))
        return false;
    m->counts.contacts = result.contacts;
    m->counts.colours = result.colours;
    return true;
}

static void end_commands(moving *m, duet_error *own)
{
    each(m, domain_end_commands, own);
    for (uint32_t k = 0; k < m->parts; ++k)
        moving_keep_base(m, m->domains[k].motion);
}

// Touches after the flight are found among ghosts at the places of that time.
static bool fly(moving *m, duet_error *own)
{
    each(m, domain_fly, own);
    if (!settle_where_due(m, own))
        return false;
    if (moving_touches(m))
        each(m, domain_find_contacts, own);
    forget_contacts(m);
    end_commands(m, own);
    moving_find_events(m, own);
    return true;
}

static bool step_together(moving *m, duet_error *own)
{
    if (!every_choose(m, own) || (m->n_commands > 0 && !moving_settle(m, own)))
        return false;
    forget_contacts(m);
    if (!moving_pushes(m))
        return fly(m, own);
    if (!respond(m, own))
        return false;
    end_commands(m, own);
    moving_find_events(m, own);
    return settle_where_due(m, own);
}

bool moving_step(moving *m, duet_error *own)
{
    bool ok = m->n_domains == 1 ? step_alone(m, own) : step_together(m, own);
    moving_enter(m, PHASE_NONE);
    m->counts.step += ok;
    m->n_commands = 0;
    return ok;
}

// ---------------------------------------------------------------- hash

static void add_states(const moving_domain *d, uint64_t *hash, duet_error *own)
{
    duet_state *states = motion_read_states(d->motion, own);
    for (uint64_t i = 0; states && i < d->bodies.n; ++i) {
        const moving_body *b = &d->bodies.rows[i];
        if (moving_is_own(d, b))
            *hash = motion_hash_state(*hash, &states[i], b->id);
    }
    free(states);
}

bool moving_hash(moving *m, uint64_t *hash, duet_error *own)
{
    tally t = {.sums = {0}};
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        add_states(&m->domains[k], &t.sums[0], own);
    bool ok = ranks_agree_and(m->ranks, is_well(own), &t, own);
    *hash = t.sums[0];
    return ok;
}

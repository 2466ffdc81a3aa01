// SPDX-License-Identifier: MIT
// Contact response: the manifolds of a step's beginning, in colours, solved in substeps.
//
// Contacts of one colour share no body that moves, so that a launch solves them in parallel.
// Contacts that find no colour are solved in order.
#include "runtime/dynamics/domain_motion.h"

#include "base/budget.h"

// ---------------------------------------------------------------- manifolds

// woken: only of what woke in this step, if anything did.
static bool find_manifolds(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->solver.woken = woken;
    return motion_launch(m, "manifolds", m->kernels.build_manifolds, m->awake.n_contacts, err);
}

static bool prepare_bodies(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->solver.woken = woken;
    return motion_launch(m, "integrate", m->kernels.prepare_bodies,
                         (uint64_t)m->awake.n_bodies + FIXED, err);
}

// A body that a touch wakes has its mass again before it is pushed.
static bool prepare_woken(duet_motion *m, duet_error *err)
{
    return prepare_bodies(m, 1, err) && find_manifolds(m, 1, err);
}

// Where there are lists they get what woke.
static bool wake_touched(duet_motion *m, duet_error *err)
{
    if (!motion_launch(m, "sleep", m->kernels.update_sleep, m->awake.n_bodies, err))
        return false;
    if (m->awake.all_awake)
        return prepare_woken(m, err);
    if (!motion_read_flags(m, err))
        return false;
    motion_count_awake(m);
    return (!m->flags[FLAG_WOKE] || motion_list_woken(m, err)) &&
           (!m->flags[FLAG_FELL_ASLEEP] || prepare_woken(m, err));
}

bool motion_make_manifolds(duet_motion *m, duet_error *err)
{
    product_renew(&m->products, PRODUCT_MANIFOLDS);
    return (!(m->effects & DUET_EFFECT_CONTACT_RESPONSE) || prepare_bodies(m, 0, err)) &&
           find_manifolds(m, 0, err) && (!(m->effects & DUET_EFFECT_SLEEP) || wake_touched(m, err));
}

// ---------------------------------------------------------------- graph colouring

// Rounds that are sent at once if the last step's rounds were too few.
enum { ROUNDS_MORE = 4 };

static bool reserve_lists(duet_motion *m, duet_error *err)
{
    static const motion_buffer lists[] = {LIST, LIST_SPARE, LIST_KEYS, LIST_KEYS_SPARE};
    bool ok = motion_reserve(m, COLOUR_STARTS, KEYS + 1, sizeof(uint32_t), err) &&
              motion_reserve(m, SPANS, COLOUR_OVERFLOW + 1, sizeof(colour_span), err);
    for (size_t i = 0; ok && i < sizeof lists / sizeof lists[0]; ++i)
        ok = motion_reserve(m, lists[i], (uint64_t)m->graph.n_contacts + 1, sizeof(uint32_t), err);
    return ok;
}

// Places each colour's contacts in the list, and in blocks: contacts of a colour begin a block, and
// contacts without a colour have one each.
static void lay_colours(contact_solver *s, uint32_t block, const uint32_t starts[KEYS + 1])
{
    s->n_blocks = s->n_colours = 0;
    for (uint32_t k = 0; k <= COLOUR_OVERFLOW; ++k) {
        colour_span *span = &s->colours[k];
        span->first = starts[k * COLOUR_KEYS];
        span->count = starts[(k + 1) * COLOUR_KEYS] - span->first;
        span->slot = s->n_blocks * block;
        s->n_blocks += k == COLOUR_OVERFLOW ? span->count : (span->count + block - 1) / block;
        s->n_colours += span->count > 0;
    }
    s->n_pushing = starts[(COLOUR_OVERFLOW + 1) * COLOUR_KEYS];
}

// Contacts of one colour after the other into LIST. Reads the flags as well.
static bool sort_colours(duet_motion *m, duet_error *err)
{
    uint32_t starts[KEYS + 1];
    buffer *b = m->buffers;
    const radix_lists lists = {&b[LIST_KEYS], &b[LIST], &b[LIST_KEYS_SPARE], &b[LIST_SPARE]};
    const char *stage = "graph_colour";
    bool ok =
        motion_launch(m, stage, m->kernels.graph_colour_key, m->awake.n_contacts, err) &&
        radix_sort_ids(&m->solver.radix, &m->times, stage, &lists, m->awake.n_contacts, KEY_BITS,
                       err) &&
        motion_launch(m, stage, m->kernels.row_start, (uint64_t)m->awake.n_contacts + 1, err) &&
        timeline_start_read(&m->times, "flags", &b[FLAG_WORDS], 0, m->flags, sizeof m->flags,
                            err) &&
        timeline_read(&m->times, stage, &b[COLOUR_STARTS], starts, sizeof starts, err);
    if (ok)
        lay_colours(&m->solver, m->layout.block, starts);
    return ok;
}

static bool run_rounds(duet_motion *m, uint32_t from, uint32_t to, duet_error *err)
{
    const uint32_t n = m->awake.n_bodies;
    bool ok = true;
    for (m->solver.round = from + 1; ok && m->solver.round <= to; ++m->solver.round)
        ok = motion_launch(m, "graph_colour", m->kernels.graph_colour_choose, n, err) &&
             motion_launch(m, "graph_colour", m->kernels.graph_colour_take, n, err);
    return ok;
}

// Makes space for the blocks of colours that have been laid out.
static bool use_colours(duet_motion *m, duet_error *err)
{
    contact_solver *s = &m->solver;
    product_renew(&m->products, PRODUCT_COLOURS);
    return motion_reserve(m, BLOCKS, (uint64_t)s->n_blocks * m->layout.block,
                          m->layout.constraint * sizeof(float), err) &&
           timeline_write_at(&m->times, "graph_colour", &m->buffers[SPANS], 0, s->colours,
                             sizeof s->colours, err);
}

// Each round colours at least the contact of greatest rank, so rounds end. The expected rounds are
// sent before the host looks whether any contact still waits.
static bool list_colours(duet_motion *m, duet_error *err)
{
    contact_solver *s = &m->solver;
    bool ok = reserve_lists(m, err);
    uint32_t from = 0, to = s->rounds > 0 ? s->rounds : m->flags[FLAG_UNCOLOURED] > 0;
    do {
        ok = ok && run_rounds(m, from, to, err) && sort_colours(m, err);
        from = to;
        to += ROUNDS_MORE;
    } while (ok && m->flags[FLAG_UNCOLOURED] > 0);
    s->rounds = m->flags[FLAG_RECOLOURED] ? m->flags[FLAG_ROUNDS] + 1 : 0;
    return ok && use_colours(m, err);
}

// If the contacts are those of the list, and none changed its colour, the list holds.
static bool keep_colours(duet_motion *m, duet_error *err)
{
    if (!motion_read_flags(m, err))
        return false;
    if (m->effects & DUET_EFFECT_SLEEP)
        motion_count_awake(m);
    if (!product_is_forgotten(&m->products, PRODUCT_COLOURS) && !m->flags[FLAG_RECOLOURED])
        product_keep(&m->products, PRODUCT_COLOURS);
    return true;
}

static bool list_none(duet_motion *m)
{
    const uint32_t none[KEYS + 1] = {0};
    lay_colours(&m->solver, m->layout.block, none);
    product_renew(&m->products, PRODUCT_COLOURS);
    return true;
}

// Stages of a team that marks and sorts, and of each of its rounds; rounds that a launch is thought
// to take at most.
enum { LEAST_CONTACTS = 256, SORT_STAGES = 3, ROUND_STAGES = 2, MOST_ROUNDS = 1024 };

static bool launch_colouring(duet_motion *m, duet_error *err)
{
    return reserve_lists(m, err) &&
           motion_reserve(m, KEY_COUNTS, (uint64_t)TEAM_MOST * KEYS, sizeof(uint32_t), err) &&
           team_launch(m, "graph_colour", m->kernels.colour_contacts, m->awake.n_contacts,
                       LEAST_CONTACTS, SORT_STAGES + ROUND_STAGES * MOST_ROUNDS, err);
}

// Chooses and sorts in one launch, if any contact changed its colour or the contacts are others.
static bool colour_by_team(duet_motion *m, duet_error *err)
{
    contact_solver *s = &m->solver;
    buffer *b = m->buffers;
    uint32_t starts[KEYS + 1];
    s->sorts = product_is_forgotten(&m->products, PRODUCT_COLOURS);
    if (!launch_colouring(m, err) ||
        !timeline_start_read(&m->times, "flags", &b[FLAG_WORDS], 0, m->flags, sizeof m->flags,
                             err) ||
        !timeline_read(&m->times, "graph_colour", &b[COLOUR_STARTS], starts, sizeof starts, err))
        return false;
    if (m->flags[FLAG_ROUNDS] > MOST_ROUNDS)
        m->team.stage += ROUND_STAGES * (m->flags[FLAG_ROUNDS] - MOST_ROUNDS);
    if (m->effects & DUET_EFFECT_SLEEP)
        motion_count_awake(m);
    if (!s->sorts && !m->flags[FLAG_RECOLOURED]) {
        product_keep(&m->products, PRODUCT_COLOURS);
        return true;
    }
    lay_colours(s, m->layout.block, starts);
    return use_colours(m, err);
}

// A motion whose colours changed in the last step mostly changes them again: then the contacts are
// sorted anew without waiting for the device to say so.
bool motion_make_colours(duet_motion *m, duet_error *err)
{
    if (m->graph.n_contacts == 0)
        return list_none(m);
    if (team_takes(m->kernels.colour_contacts))
        return colour_by_team(m, err);
    return motion_launch(m, "graph_colour", m->kernels.graph_colour_mark, m->awake.n_contacts,
                         err) &&
           (m->solver.rounds > 0 || keep_colours(m, err)) &&
           (product_is_right(&m->products, PRODUCT_COLOURS) || list_colours(m, err));
}

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
static bool launch_colours(duet_motion *m, const kernel *k, uint32_t from, uint32_t to,
                           uint32_t each, uint64_t work, duet_error *err)
{
    m->solver.span = span_of(&m->solver, from);
    m->solver.from_colour = from;
    m->solver.to_colour = to;
    m->solver.each = each;
    return motion_launch(m, "solve_contacts", k, work, err);
}

// Colours that one work-group has space for are taken by the same one.
static uint32_t end_of_few(const contact_solver *s, const kernel *k, uint32_t from)
{
    uint32_t to = from + 1;
    if (s->colours[from].count <= k->group * k->per_item)
        while (to < COLOUR_OVERFLOW && s->colours[to].count <= k->group * k->per_item)
            ++to;
    return to;
}

// ---------------------------------------------------------------- colours by a team

static uint32_t end_of_colours(const contact_solver *s)
{
    uint32_t to = COLOUR_OVERFLOW + 1;
    while (to > 0 && s->colours[to - 1].count == 0)
        --to;
    return to;
}

// Takes colours in one launch.
static bool launch_team(duet_motion *m, const kernel *k, uint32_t from, uint32_t to,
                        duet_error *err)
{
    contact_solver *s = &m->solver;
    const uint32_t most = most_of(s, from, to < COLOUR_OVERFLOW ? to : COLOUR_OVERFLOW);
    s->span = span_of(s, from);
    s->from_colour = from;
    s->to_colour = to;
    return from == to || team_launch(m, "solve_contacts", k, most, TEAM_LEAST_PART, to - from, err);
}

// ---------------------------------------------------------------- colours by launches

// Contacts that found no colour are taken in order, by one work-item.
static bool launch_each(duet_motion *m, const kernel *k, duet_error *err)
{
    const contact_solver *s = &m->solver;
    uint32_t in_order = s->colours[COLOUR_OVERFLOW].count;
    bool ok = true;
    for (uint32_t from = 0, to = 0; ok && from < COLOUR_OVERFLOW; from = to) {
        to = end_of_few(s, k, from);
        ok = launch_colours(m, k, from, to, k->per_item, most_of(s, from, to), err);
    }
    return ok && (in_order == 0 ||
                  launch_colours(m, k, COLOUR_OVERFLOW, COLOUR_OVERFLOW + 1, in_order, 1, err));
}

static bool for_colours(duet_motion *m, const kernel *k, duet_error *err)
{
    return team_takes(k) ? launch_team(m, k, 0, end_of_colours(&m->solver), err)
                         : launch_each(m, k, err);
}

static bool solve(duet_motion *m, uint32_t soft, duet_error *err)
{
    m->solver.soft = soft;
    return for_colours(m, m->kernels.solve_contacts, err);
}

// The first sweep looks at all contacts, and the others go on while something bounced.
static bool solve_shocks(duet_motion *m, duet_error *err)
{
    contact_solver *s = &m->solver;
    bool ok = true;
    if (!(m->effects & DUET_EFFECT_SHOCKS) || !(m->facts & FACT_ELASTIC))
        return true;
    s->first_sweep = s->sweep;
    for (int i = 0; ok && i < SHOCK_SWEEPS; ++i, ++s->sweep)
        ok = for_colours(m, m->kernels.solve_shocks, err);
    return ok;
}

// Contacts are soft springs, and then relax without these.
static bool substep(duet_motion *m, duet_error *err)
{
    const motion_kernels *k = &m->kernels;
    return budget_check(err) &&
           motion_launch(m, "integrate", k->integrate_velocities, m->awake.n_bodies, err) &&
           solve_shocks(m, err) && solve(m, 1, err) &&
           motion_launch(m, "integrate", k->integrate_positions, m->awake.n_bodies, err) &&
           solve(m, 0, err);
}

// Each contact has its own.
static bool store_impulses(duet_motion *m, duet_error *err)
{
    const kernel *k = m->kernels.store_impulses;
    return launch_colours(m, k, 0, COLOUR_OVERFLOW + 1, k->per_item,
                          most_of(&m->solver, 0, COLOUR_OVERFLOW + 1), err);
}

// A sleeper deep in others goes when all else has gone, so that whatever it then touches is
// searched for where it is. The flags are those that colours were chosen by.
static bool push_sleepers(duet_motion *m, duet_error *err)
{
    const motion_kernels *k = &m->kernels;
    bool ok = true;
    if (!(m->effects & DUET_EFFECT_SLEEP) || m->graph.n_contacts == 0 || !m->flags[FLAG_PRESSED])
        return true;
    for (m->solver.round = 0; ok && m->solver.round < PRESSED_ROUNDS; ++m->solver.round)
        ok = motion_launch(m, "sleep", k->push_sleepers, m->awake.n_bodies, err);
    return ok && motion_launch(m, "sleep", k->move_sleepers, m->awake.n_bodies, err);
}

// ---------------------------------------------------------------- all substeps at once

// Bodies that a work-item may have, as it takes them one after the other.
enum { BODIES_OF_ONE = 4 };

// Whether one group has space for every colour, and each work-item few bodies.
static bool are_few(const duet_motion *m, const kernel *k)
{
    const contact_solver *s = &m->solver;
    uint64_t takes = k ? (uint64_t)k->group * k->per_item : 0;
    uint64_t most = BODIES_OF_ONE * takes < SOLVER_FEW ? BODIES_OF_ONE * takes : SOLVER_FEW;
    return m->awake.n_bodies <= most && s->colours[COLOUR_OVERFLOW].count == 0 &&
           most_of(s, 0, COLOUR_OVERFLOW) <= takes;
}

static bool run_substeps(duet_motion *m, duet_error *err)
{
    bool ok = true;
    if (are_few(m, m->kernels.solve_few)) {
        m->solver.to_colour = end_of_colours(&m->solver);
        return budget_check(err) &&
               motion_launch(m, "solve_contacts", m->kernels.solve_few, 1, err);
    }
    for (uint32_t i = 0; ok && i < m->def.substeps; ++i)
        ok = substep(m, err);
    return ok;
}

// ---------------------------------------------------------------- all stages

// Shocks have given back all speed.
static bool restore_speeds(duet_motion *m, duet_error *err)
{
    return !(m->facts & FACT_ELASTIC) || (m->effects & DUET_EFFECT_SHOCKS) ||
           for_colours(m, m->kernels.apply_restitution, err);
}

bool motion_solve(duet_motion *m, duet_error *err)
{
    return for_colours(m, m->kernels.prepare_contacts, err) && run_substeps(m, err) &&
           restore_speeds(m, err) && store_impulses(m, err);
}

bool motion_finalize(duet_motion *m, duet_error *err)
{
    return motion_launch(m, "integrate", m->kernels.finalize_bodies, m->awake.n_bodies, err) &&
           push_sleepers(m, err);
}

// ---------------------------------------------------------------- stage by stage

static bool find_first_manifolds(duet_motion *m, duet_error *err)
{
    product_renew(&m->products, PRODUCT_MANIFOLDS);
    return prepare_bodies(m, 0, err) && find_manifolds(m, 0, err);
}

bool domain_find_manifolds(duet_motion *m, duet_error *err)
{
    return m->n == 0 || find_first_manifolds(m, err);
}

bool domain_update_sleep(duet_motion *m, duet_error *err)
{
    return motion_launch(m, "sleep", m->kernels.update_sleep, m->n, err);
}

bool domain_wake_touched(duet_motion *m, bool fell, duet_error *err)
{
    static const cl_uint one = 1;
    if (m->n == 0 || !fell)
        return true;
    return timeline_write_at(&m->times, "sleep", &m->buffers[FLAG_WORDS],
                             FLAG_FELL_ASLEEP * sizeof one, &one, sizeof one, err) &&
           prepare_bodies(m, 1, err) && find_manifolds(m, 1, err);
}

bool domain_push_sleepers(duet_motion *m, uint32_t round, duet_error *err)
{
    m->solver.round = round;
    return motion_launch(m, "sleep", m->kernels.push_sleepers, m->n, err);
}

bool domain_move_sleepers(duet_motion *m, duet_error *err)
{
    m->solver.round = PRESSED_ROUNDS;
    return motion_launch(m, "sleep", m->kernels.move_sleepers, m->n, err);
}

bool domain_take_colours(duet_motion *m, const cl_uint *colours, duet_error *err)
{
    const uint32_t n = m->graph.n_contacts;
    if (m->n == 0 || n == 0)
        return list_none(m);
    return timeline_write_at(&m->times, "graph_colour", &m->buffers[COLOUR_OF], 0, colours,
                             n * sizeof *colours, err) &&
           reserve_lists(m, err) && sort_colours(m, err) && use_colours(m, err);
}

bool domain_prepare_contacts(duet_motion *m, duet_error *err)
{
    return for_colours(m, m->kernels.prepare_contacts, err);
}

bool domain_integrate_velocities(duet_motion *m, duet_error *err)
{
    return motion_launch(m, "integrate", m->kernels.integrate_velocities, m->n, err);
}

bool domain_integrate_positions(duet_motion *m, duet_error *err)
{
    return motion_launch(m, "integrate", m->kernels.integrate_positions, m->n, err);
}

// Runs a kernel over the contacts of colours below COLOUR_OVERFLOW.
static bool launch_between(duet_motion *m, const kernel *k, uint32_t from, uint32_t to,
                           duet_error *err)
{
    const contact_solver *s = &m->solver;
    bool ok = true;
    if (most_of(s, from, to) == 0)
        return true;
    if (team_takes(k))
        return launch_team(m, k, from, to, err);
    for (uint32_t next; ok && from < to; from = next) {
        next = end_of_few(s, k, from);
        next = next < to ? next : to;
        ok = launch_colours(m, k, from, next, k->per_item, most_of(s, from, next), err);
    }
    return ok;
}

// Launches a kernel for one of the contacts that have no colour of their own.
static bool launch_in_order(duet_motion *m, const kernel *k, uint32_t i, duet_error *err)
{
    contact_solver *s = &m->solver;
    const colour_span *all = &s->colours[COLOUR_OVERFLOW];
    s->span = (cl_int4){{(cl_int)(all->first + i), 1, (cl_int)(all->slot + i * m->layout.block)}};
    s->from_colour = COLOUR_OVERFLOW;
    s->to_colour = COLOUR_OVERFLOW + 1;
    s->each = 1;
    return team_takes(k) ? team_launch(m, "solve_contacts", k, 1, TEAM_LEAST_PART, 1, err)
                         : motion_launch(m, "solve_contacts", k, 1, err);
}

bool domain_solve_in_order(duet_motion *m, uint32_t i, bool soft, duet_error *err)
{
    m->solver.soft = soft;
    return launch_in_order(m, m->kernels.solve_contacts, i, err);
}

bool domain_restore_in_order(duet_motion *m, uint32_t i, duet_error *err)
{
    return launch_in_order(m, m->kernels.apply_restitution, i, err);
}

bool domain_solve_colours(duet_motion *m, uint32_t from, uint32_t to, bool soft, duet_error *err)
{
    m->solver.soft = soft;
    return launch_between(m, m->kernels.solve_contacts, from, to, err);
}

// No sweep of a domain knows whether it is the last one.
bool domain_shock_colours(duet_motion *m, uint32_t from, uint32_t to, duet_error *err)
{
    m->solver.first_sweep = m->solver.sweep;
    return launch_between(m, m->kernels.solve_shocks, from, to, err);
}

bool domain_shock_in_order(duet_motion *m, uint32_t i, duet_error *err)
{
    m->solver.first_sweep = m->solver.sweep;
    return launch_in_order(m, m->kernels.solve_shocks, i, err);
}

bool domain_end_sweep(duet_motion *m, bool *bounced, duet_error *err)
{
    cl_uint last = 0, sweep = m->solver.sweep++;
    bool ok = m->n == 0 || motion_fetch(m, "solve_contacts", SHOCKED, 0, &last, sizeof last, err);
    *bounced = m->n > 0 && last == sweep;
    return ok;
}

bool domain_restore_colours(duet_motion *m, uint32_t from, uint32_t to, duet_error *err)
{
    return launch_between(m, m->kernels.apply_restitution, from, to, err);
}

bool domain_finalize(duet_motion *m, duet_error *err)
{
    return m->n == 0 || (store_impulses(m, err) && domain_note_events(m, err) &&
                         motion_launch(m, "integrate", m->kernels.finalize_bodies, m->n, err));
}

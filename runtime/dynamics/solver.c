// SPDX-License-Identifier: MIT
// Contact response: the manifolds of a step's beginning, in colours, solved in substeps.
//
// Contacts of one colour share no body that moves, so that a launch solves them in parallel. What
// finds no colour is solved in order.
#include "runtime/dynamics/motion.h"

#include "base/budget.h"

// ---------------------------------------------------------------- manifolds

// Over so many bodies, pairs or contacts.
static bool launch(duet_motion *m, const char *stage, const kernel *k, uint64_t work,
                   duet_error *err)
{
    return timeline_launch(&m->times, stage, k, work, m, err);
}

// woken: only of what woke in this step, where anything did.
static bool find_manifolds(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->args.woken = woken;
    return launch(m, "manifolds", m->kernels.build_manifolds, m->n_contacts, err);
}

static bool prepare_bodies(duet_motion *m, uint32_t woken, duet_error *err)
{
    m->args.woken = woken;
    return launch(m, "integrate", m->kernels.prepare_bodies, (uint64_t)m->n + MOTION_WALLS, err);
}

// Bodies and where they touch. What is woken by a touch has its mass again
// before it is pushed.
static bool update_contacts(duet_motion *m, duet_error *err)
{
    return prepare_bodies(m, 0, err) && find_manifolds(m, 0, err) &&
           (!(m->effects & DUET_EFFECT_SLEEP) ||
            (launch(m, "sleep", m->kernels.update_sleep, m->n, err) && prepare_bodies(m, 1, err) &&
             find_manifolds(m, 1, err)));
}

// ---------------------------------------------------------------- graph colouring

// Rounds that are sent at once where those of the last step were too few.
enum { ROUNDS_MORE = 4 };

static bool reserve_lists(duet_motion *m, duet_error *err)
{
    static const motion_buffer lists[] = {LIST, LIST_SPARE, LIST_KEYS, LIST_KEYS_SPARE};
    bool ok = motion_reserve(m, COLOUR_STARTS, KEYS + 1, sizeof(uint32_t), err) &&
              motion_reserve(m, SPANS, sizeof m->colours / sizeof m->colours[0],
                             sizeof m->colours[0], err);
    for (size_t i = 0; ok && i < sizeof lists / sizeof lists[0]; ++i)
        ok = motion_reserve(m, lists[i], (uint64_t)m->n_contacts + 1, sizeof(uint32_t), err);
    return ok;
}

// Where each colour's contacts are in the list, and in blocks: those of a colour
// begin a block, and those of none have one each.
static void lay_colours(duet_motion *m, const uint32_t starts[KEYS + 1])
{
    uint32_t block = m->layout.block, n_blocks = 0;
    m->n_colours = 0;
    for (uint32_t c = 0; c <= COLOUR_OVERFLOW; ++c) {
        colour_span *span = &m->colours[c];
        span->first = starts[c * COLOUR_KEYS];
        span->count = starts[(c + 1) * COLOUR_KEYS] - span->first;
        span->slot = n_blocks * block;
        n_blocks += c == COLOUR_OVERFLOW ? span->count : (span->count + block - 1) / block;
        m->n_colours += span->count > 0;
    }
    m->n_pushing = starts[(COLOUR_OVERFLOW + 1) * COLOUR_KEYS];
    m->n_blocks = n_blocks;
}

// Contacts of one colour after the other into LIST. Reads the flags as well.
static bool sort_colours(duet_motion *m, duet_error *err)
{
    uint32_t starts[KEYS + 1];
    buffer *b = m->buffers;
    const radix_lists lists = {&b[LIST_KEYS], &b[LIST], &b[LIST_KEYS_SPARE], &b[LIST_SPARE]};
    const char *stage = "graph_colour";
    bool ok = launch(m, stage, m->kernels.graph_colour_key, m->n_contacts, err) &&
              radix_sort_run(&m->radix, &m->times, stage, &lists, m->n_contacts, KEY_BITS, err) &&
              launch(m, stage, m->kernels.row_start, (uint64_t)m->n_contacts + 1, err) &&
              timeline_start_read(&m->times, "flags", &b[FLAG_WORDS], 0, m->flags, sizeof m->flags,
                                  err) &&
              timeline_read(&m->times, stage, &b[COLOUR_STARTS], starts, sizeof starts, err);
    if (ok)
        lay_colours(m, starts);
    return ok;
}

static bool run_rounds(duet_motion *m, uint32_t from, uint32_t to, duet_error *err)
{
    bool ok = true;
    for (m->args.round = from + 1; ok && m->args.round <= to; ++m->args.round)
        ok = launch(m, "graph_colour", m->kernels.graph_colour_choose, m->n, err) &&
             launch(m, "graph_colour", m->kernels.graph_colour_take, m->n, err);
    return ok;
}

// Each round colours at least the contact of greatest rank, so rounds end. As many as in
// the last step and one more are sent before the host looks whether any contact still waits.
static bool list_colours(duet_motion *m, duet_error *err)
{
    bool ok = reserve_lists(m, err);
    bool waits = m->recoloured || m->flags[FLAG_UNCOLOURED] > 0;
    uint32_t from = 0, to = waits ? m->rounds + 1 : 0;
    do {
        ok = ok && run_rounds(m, from, to, err) && sort_colours(m, err);
        from = to;
        to += ROUNDS_MORE;
    } while (ok && m->flags[FLAG_UNCOLOURED] > 0);
    m->rounds = m->flags[FLAG_ROUNDS];
    return ok &&
           motion_reserve(m, BLOCKS, (uint64_t)m->n_blocks * m->layout.block,
                          m->layout.constraint * sizeof(float), err) &&
           timeline_write_at(&m->times, "graph_colour", &m->buffers[SPANS], 0, m->colours,
                             sizeof m->colours, err);
}

// A motion whose colours changed in the last step mostly changes them again: then the contacts are
// sorted anew without waiting for the device to say so.
static bool colour_contacts(duet_motion *m, duet_error *err)
{
    const uint32_t none[KEYS + 1] = {0};
    if (m->n_contacts == 0) {
        lay_colours(m, none);
        return true;
    }
    if (!launch(m, "graph_colour", m->kernels.graph_colour_mark, m->n_contacts, err) ||
        (!m->recoloured && !motion_read_flags(m, err)))
        return false;
    m->list_stale = m->list_stale || m->rebuilt || m->recoloured || m->flags[FLAG_RECOLOURED];
    if (!m->list_stale)
        return true;
    m->list_stale = !list_colours(m, err);
    m->recoloured = m->flags[FLAG_RECOLOURED];
    return !m->list_stale;
}

// ---------------------------------------------------------------- substeps

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
    return launch(m, "solve_contacts", k, work, err);
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

// Contacts are soft springs, and then relax without these.
static bool substep(duet_motion *m, duet_error *err)
{
    const motion_kernels *k = &m->kernels;
    return budget_check(err) && launch(m, "integrate", k->integrate_velocities, m->n, err) &&
           solve(m, 1, err) && launch(m, "integrate", k->integrate_positions, m->n, err) &&
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
    if (!(m->effects & DUET_EFFECT_SLEEP) || m->n_contacts == 0 || !m->flags[FLAG_PRESSED])
        return true;
    for (m->args.round = 0; ok && m->args.round < PRESSED_ROUNDS; ++m->args.round)
        ok = launch(m, "sleep", k->push_sleepers, m->n, err);
    return ok && launch(m, "sleep", k->move_sleepers, m->n, err);
}

// ---------------------------------------------------------------- all stages

static bool respond(duet_motion *m, duet_error *err)
{
    bool ok = update_contacts(m, err) && colour_contacts(m, err) &&
              for_colours(m, m->kernels.prepare_contacts, err);
    for (uint32_t i = 0; ok && i < m->def.substeps; ++i)
        ok = substep(m, err);
    ok = ok && (!m->facts.elastic || for_colours(m, m->kernels.apply_restitution, err));
    return ok && store_impulses(m, err);
}

bool motion_solve(duet_motion *m, duet_error *err)
{
    bool response = m->effects & DUET_EFFECT_CONTACT_RESPONSE;
    return (response ? respond(m, err) : find_manifolds(m, 0, err)) && motion_note_events(m, err) &&
           (!response || (launch(m, "integrate", m->kernels.finalize_bodies, m->n, err) &&
                          push_sleepers(m, err)));
}

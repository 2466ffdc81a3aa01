// SPDX-License-Identifier: MIT
// Makes a colour of each contact, and the list of contacts by colour: those of one colour share no
// body that moves.
#include "runtime/dynamics/domain_motion.h"

// Rounds that are sent at once if the last step's rounds were too few.
enum { ROUNDS_MORE = 4 };

static bool reserve_lists(duet_motion *m, duet_error *err)
{
    static const motion_buffer lists[] = {LIST, LIST_SPARE, LIST_KEYS, LIST_KEYS_SPARE};
    bool ok = motion_reserve(m, COLOUR_STARTS, KEYS + 1, sizeof(uint32_t), err) &&
              motion_reserve(m, SPANS, COLOUR_SPANS, sizeof(colour_span), err);
    for (size_t i = 0; ok && i < sizeof lists / sizeof lists[0]; ++i)
        ok = motion_reserve(m, lists[i], (uint64_t)m->graph.n_contacts + 1, sizeof(uint32_t), err);
    return ok;
}

static uint32_t whole_blocks(uint32_t n, uint32_t block)
{
    return (n + block - 1) / block;
}

// Notes what the spans say of all colours.
static void count_colours(contact_solver *s)
{
    const colour_span *last = &s->colours[COLOUR_OVERFLOW];
    s->n_colours = 0;
    for (uint32_t k = 0; k <= COLOUR_OVERFLOW; ++k)
        s->n_colours += s->colours[k].count > 0;
    s->n_pushing = last->first + last->count;
    s->n_blocks = s->colours[COLOUR_SPANS - 1].count;
}

// Places each colour's contacts in the list, and in blocks, as kernels/dynamics/colour_contacts.cl
// does. A colour has so many keys.
static void lay_colours(contact_solver *s, uint32_t block, uint32_t keys,
                        const uint32_t starts[KEYS + 1])
{
    uint32_t blocks = 0, end = 0;
    for (uint32_t k = 0; k <= COLOUR_OVERFLOW; ++k) {
        colour_span *span = &s->colours[k];
        span->first = starts[COLOUR_KEY(k, keys)];
        span->count = starts[COLOUR_KEY(k + 1, keys)] - span->first;
        span->slot = blocks * block;
        span->border = 0;
        blocks += k == COLOUR_OVERFLOW ? span->count : whole_blocks(span->count, block);
        end = span->count > 0 ? k + 1 : end;
    }
    s->colours[COLOUR_SPANS - 1] = (colour_span){.first = end, .count = blocks};
    count_colours(s);
}

// A block of both is of the border. All is of it if fewer others than that would be left.
static void lay_border(contact_solver *s, uint32_t block, uint32_t least_inner,
                       const uint32_t starts[KEYS + 1])
{
    for (uint32_t k = 0; k < COLOUR_OVERFLOW; ++k) {
        colour_span *span = &s->colours[k];
        const uint32_t n = starts[COLOUR_KEY(k, BORDER_KEYS) + COLOUR_KEYS] - span->first,
                       border = whole_blocks(n, block) * block;
        span->border = border + (uint64_t)least_inner <= span->count ? border : span->count;
    }
}

// Contacts of one colour after the other into LIST, by the keys that a kernel gives them: starts
// become where each key begins. Reads the flags as well.
static bool sort_colours(duet_motion *m, motion_kernel key, uint32_t starts[KEYS + 1],
                         duet_error *err)
{
    const uint32_t bytes = (KEYS + 1) * sizeof *starts;
    buffer *b = m->buffers;
    const radix_lists lists = {&b[LIST_KEYS], &b[LIST], &b[LIST_KEYS_SPARE], &b[LIST_SPARE]};
    const char *stage = "graph_colour";
    return motion_launch(m, key, err) &&
           radix_sort_ids(&m->solver.radix, &m->times, stage, &lists, m->awake.n_contacts, KEY_BITS,
                          err) &&
           motion_launch(m, ROW_START, err) && motion_read_flags(m, err) &&
           timeline_read(&m->times, stage, &b[COLOUR_STARTS], starts, bytes, err);
}

static bool run_rounds(duet_motion *m, motion_kernel choose, uint32_t from, uint32_t to,
                       duet_error *err)
{
    bool ok = true;
    for (m->solver.round = from + 1; ok && m->solver.round <= to; ++m->solver.round)
        ok = motion_launch(m, choose, err) && motion_launch(m, GRAPH_COLOUR_TAKE, err);
    return ok;
}

static size_t block_bytes(const duet_motion *m)
{
    return (size_t)m->layout.block * m->layout.constraint * sizeof(float);
}

// Makes space for the blocks of colours that have been laid out.
static bool use_colours(duet_motion *m, duet_error *err)
{
    product_renew(&m->products, PRODUCT_COLOURS);
    return motion_reserve(m, BLOCKS, m->solver.n_blocks, block_bytes(m), err);
}

static bool send_colours(duet_motion *m, duet_error *err)
{
    return use_colours(m, err) &&
           timeline_write_at(&m->times, "graph_colour", &m->buffers[SPANS], 0, m->solver.colours,
                             sizeof m->solver.colours, err);
}

// Each round colours at least the contact of greatest rank, so rounds end. The expected rounds are
// sent before the host looks whether any contact still waits.
static bool list_colours(duet_motion *m, duet_error *err)
{
    contact_solver *s = &m->solver;
    uint32_t starts[KEYS + 1];
    bool ok = reserve_lists(m, err);
    uint32_t from = 0, to = s->rounds > 0 ? s->rounds : m->flags[FLAG_UNCOLOURED] > 0;
    do {
        ok = ok && run_rounds(m, GRAPH_COLOUR_CHOOSE, from, to, err) &&
             sort_colours(m, GRAPH_COLOUR_KEY, starts, err);
        from = to;
        to += ROUNDS_MORE;
    } while (ok && m->flags[FLAG_UNCOLOURED] > 0);
    s->rounds = m->flags[FLAG_RECOLOURED] ? m->flags[FLAG_ROUNDS] + 1 : 0;
    if (ok)
        lay_colours(s, m->layout.block, COLOUR_KEYS, starts);
    return ok && send_colours(m, err);
}

// If the contacts are those of the list, and none changed its colour, the list holds.
static bool keep_list(duet_motion *m)
{
    motion_count_awake(m);
    bool holds = !product_is_forgotten(&m->products, PRODUCT_COLOURS) && !m->flags[FLAG_RECOLOURED];
    if (holds)
        product_keep(&m->products, PRODUCT_COLOURS);
    return holds;
}

static bool list_none(duet_motion *m)
{
    const uint32_t none[KEYS + 1] = {0};
    lay_colours(&m->solver, m->layout.block, COLOUR_KEYS, none);
    product_renew(&m->products, PRODUCT_COLOURS);
    return true;
}

// Contacts that a group has at least; stages of a team that marks and sorts, and of each of its
// rounds.
enum { LEAST_CONTACTS = 256, SORT_STAGES = 3, ROUND_STAGES = 2 };

// Chooses and sorts in one launch, if any contact changed its colour or the contacts are others.
static bool launch_colouring(duet_motion *m, duet_error *err)
{
    const kernel *k = m->kernels.of[COLOUR_CONTACTS];
    m->solver.sorts = product_is_forgotten(&m->products, PRODUCT_COLOURS);
    m->solver.block_capacity = (cl_uint)(m->buffers[BLOCKS].bytes / block_bytes(m));
    return reserve_lists(m, err) &&
           motion_reserve(m, KEY_COUNTS, (uint64_t)TEAM_MOST * KEYS, sizeof(uint32_t), err) &&
           team_launch(m, COLOUR_CONTACTS, m->awake.n_contacts,
                       k->group > 1 ? k->group : LEAST_CONTACTS,
                       SORT_STAGES + ROUND_STAGES * TEAM_ROUNDS, err);
}

static bool read_spans(duet_motion *m, duet_error *err)
{
    return timeline_read(&m->times, "graph_colour", &m->buffers[SPANS], m->solver.colours,
                         sizeof m->solver.colours, err);
}

bool motion_keep_colours(duet_motion *m, duet_error *err)
{
    if (m->flags[FLAG_ROUNDS] > TEAM_ROUNDS)
        m->team.stage += ROUND_STAGES * (m->flags[FLAG_ROUNDS] - TEAM_ROUNDS);
    if (keep_list(m) || !m->kernels.of[COLOUR_CONTACTS])
        return true;
    if (!read_spans(m, err))
        return false;
    count_colours(&m->solver);
    return use_colours(m, err);
}

bool motion_begin_colours(duet_motion *m, duet_error *err)
{
    if (m->graph.n_contacts == 0)
        return true;
    if (m->kernels.of[COLOUR_CONTACTS])
        return launch_colouring(m, err);
    return motion_launch(m, GRAPH_COLOUR_MARK, err);
}

// A motion whose colours changed in the last step mostly changes them again: then the contacts are
// sorted anew without waiting for the device to say so.
bool motion_end_colours(duet_motion *m, duet_error *err)
{
    if (m->graph.n_contacts == 0)
        return list_none(m);
    const bool asks = m->kernels.of[COLOUR_CONTACTS] || m->solver.rounds == 0;
    return (!asks || (motion_read_flags(m, err) && motion_keep_colours(m, err))) &&
           (product_is_right(&m->products, PRODUCT_COLOURS) || list_colours(m, err));
}

// ---------------------------------------------------------------- stage by stage

// Contacts that more than this domain's decide wait still, after any number of rounds.
bool domain_colour_inner(duet_motion *m, uint32_t every, domain_contacts *told, duet_error *err)
{
    const uint32_t rounds = m->border.rounds;
    m->border.every = every;
    if (m->n == 0 || m->graph.n_contacts == 0)
        return domain_list_waiting(m, told, err);
    if (!domain_mark_border(m, err) || !run_rounds(m, CHOOSE_INNER, 0, rounds, err) ||
        !domain_list_waiting(m, told, err))
        return false;
    const uint32_t needed = m->flags[FLAG_ROUNDS];
    m->border.rounds = needed < rounds ? needed + 1 : rounds + ROUNDS_MORE;
    return true;
}

bool domain_take_colours(duet_motion *m, uint32_t least_inner, duet_error *err)
{
    uint32_t starts[KEYS + 1];
    if (m->n == 0 || m->graph.n_contacts == 0)
        return list_none(m);
    if (!reserve_lists(m, err) || !sort_colours(m, BORDER_KEY, starts, err))
        return false;
    lay_colours(&m->solver, m->layout.block, BORDER_KEYS, starts);
    lay_border(&m->solver, m->layout.block, least_inner, starts);
    return send_colours(m, err);
}

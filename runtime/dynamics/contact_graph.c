// SPDX-License-Identifier: MIT
// From pairs to rows: the contacts that each body may have, those that it had before, and a
// colour for each.
#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"

// ---------------------------------------------------------------- rows

// Contacts that rows may have: pairs, and walls.
static bool check_capacity(const duet_motion *m, uint64_t *most, duet_error *err)
{
    *most = m->n_pairs + (m->kernels.contact_graph_walls ? 6 * (uint64_t)m->n : 0);
    return *most <= UINT32_MAX - 1 ||
           error_set(err, DUET_STATUS_TOO_MANY, "%llu pairs of bounds, and a motion holds %u",
                     (unsigned long long)*most, UINT32_MAX - 1);
}

// Counts (fill 0) or writes (fill 1) what each object may touch.
static bool put_all(duet_motion *m, uint32_t fill, duet_error *err)
{
    const motion_kernels *k = &m->kernels;
    m->args.n_pairs = (uint32_t)m->n_pairs;
    m->args.fill = fill;
    return motion_launch(m, "contact_graph", k->contact_graph_pairs, m->n_pairs, err) &&
           (!k->contact_graph_walls ||
            motion_launch(m, "contact_graph", k->contact_graph_walls, m->n, err));
}

static bool sort_rows(duet_motion *m, motion_buffer starts, motion_buffer values, duet_error *err)
{
    m->args.row_starts = m->buffers[starts];
    m->args.row_values = m->buffers[values];
    return motion_launch(m, "contact_graph", m->kernels.contact_graph_sort, m->n, err);
}

static bool scan_starts(duet_motion *m, motion_buffer starts, duet_error *err)
{
    return scan_run(&m->scan, &m->times, "contact_graph", &m->buffers[starts], &m->buffers[starts],
                    m->n + 1, err);
}

static bool count_rows(duet_motion *m, duet_error *err)
{
    size_t n_starts = (size_t)m->n + 1;
    return timeline_fill(&m->times, "contact_graph", &m->buffers[STARTS], 0, 0, n_starts, err) &&
           motion_reserve(m, OTHERS, 1, sizeof(uint32_t), err) && put_all(m, 0, err) &&
           scan_starts(m, STARTS, err);
}

// The last of the starts says how many there are.
static bool fill_rows(duet_motion *m, uint64_t most, duet_error *err)
{
    return motion_reserve(m, OTHERS, most + 1, sizeof(uint32_t), err) && put_all(m, 1, err) &&
           sort_rows(m, STARTS, OTHERS, err) &&
           timeline_read_at(&m->times, "contact_graph", &m->buffers[STARTS],
                            m->n * sizeof m->n_contacts, &m->n_contacts, sizeof m->n_contacts, err);
}

static bool put_returns(duet_motion *m, uint32_t fill, duet_error *err)
{
    m->args.fill = fill;
    return motion_launch(m, "contact_graph", m->kernels.contact_graph_reverse, m->n, err);
}

static bool reserve_contacts(duet_motion *m, duet_error *err)
{
    uint64_t n = (uint64_t)m->n_contacts + 1;
    return motion_reserve(m, LINKS, n, 2 * sizeof(uint32_t), err) &&
           motion_reserve(m, CONTACTS, n * m->layout.record, sizeof(float), err) &&
           motion_reserve(m, TOUCHES, n, sizeof(uint32_t), err) &&
           (!motion_has(m, DUET_EFFECT_CONTACT_RESPONSE) ||
            motion_reserve(m, COLOUR_OF, n, sizeof(uint32_t), err));
}

static bool fill_returns(duet_motion *m, duet_error *err)
{
    size_t n_starts = (size_t)m->n + 1;
    uint64_t n = (uint64_t)m->n_contacts + 1;
    return reserve_contacts(m, err) && motion_reserve(m, RETURNS, n, sizeof(uint32_t), err) &&
           timeline_fill(&m->times, "contact_graph", &m->buffers[RETURN_STARTS], 0, 0, n_starts,
                         err) &&
           put_returns(m, 0, err) && scan_starts(m, RETURN_STARTS, err) && put_returns(m, 1, err) &&
           sort_rows(m, RETURN_STARTS, RETURNS, err);
}

static bool match_contacts(duet_motion *m, uint32_t n_old, duet_error *err)
{
    m->args.n_old = n_old;
    return motion_launch(m, "match_contacts", m->kernels.match_contacts, n_old, err);
}

static bool build_rows(duet_motion *m, duet_error *err)
{
    uint64_t most;
    uint32_t n_old = m->n_contacts;
    buffer *b = m->buffers;
    buffer_swap(&b[LINKS], &b[OLD_LINKS]);
    buffer_swap(&b[CONTACTS], &b[OLD_CONTACTS]);
    buffer_swap(&b[TOUCHES], &b[OLD_TOUCHES]);
    buffer_swap(&b[COLOUR_OF], &b[OLD_COLOURS]);
    m->rebuilt = true;
    m->has_graph = true;
    return check_capacity(m, &most, err) && count_rows(m, err) && fill_rows(m, most, err) &&
           fill_returns(m, err) && match_contacts(m, n_old, err);
}

bool motion_build_graph(duet_motion *m, duet_error *err)
{
    bool hold;
    m->rebuilt = false;
    return motion_find_candidates(m, &hold, err) && (hold || build_rows(m, err));
}

// ---------------------------------------------------------------- graph colouring

// Contacts into colours, and the list that goes colour by colour.

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
    bool ok = motion_launch(m, stage, m->kernels.graph_colour_key, m->n_contacts, err) &&
              radix_sort_run(&m->radix, &m->times, stage, &lists, m->n_contacts, KEY_BITS, err) &&
              motion_launch(m, stage, m->kernels.row_start, (uint64_t)m->n_contacts + 1, err) &&
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
        ok = motion_launch(m, "graph_colour", m->kernels.graph_colour_choose, m->n, err) &&
             motion_launch(m, "graph_colour", m->kernels.graph_colour_take, m->n, err);
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

// Where colours changed in the last step they do mostly again, and nobody need ask.
bool motion_colour(duet_motion *m, duet_error *err)
{
    const uint32_t none[KEYS + 1] = {0};
    if (m->n_contacts == 0) {
        lay_colours(m, none);
        return true;
    }
    if (!motion_launch(m, "graph_colour", m->kernels.graph_colour_mark, m->n_contacts, err) ||
        (!m->recoloured && !motion_read_flags(m, err)))
        return false;
    m->list_stale = m->list_stale || m->rebuilt || m->recoloured || m->flags[FLAG_RECOLOURED];
    if (!m->list_stale)
        return true;
    m->list_stale = !list_colours(m, err);
    m->recoloured = m->flags[FLAG_RECOLOURED];
    return !m->list_stale;
}

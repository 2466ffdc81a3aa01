// SPDX-License-Identifier: MIT
// Contacts into colours, and the list that goes colour by colour.
#include "runtime/dynamics/motion.h"

#include "base/error.h"

#include <string.h>

// Rounds that are sent before the host looks whether any contact still waits.
enum { ROUNDS_AT_ONCE = 4 };

// ---------------------------------------------------------------- sorting

static bool reserve_lists(duet_motion *m, duet_error *err)
{
    static const motion_buffer lists[] = {LIST, LIST_SPARE, LIST_KEYS, LIST_KEYS_SPARE};
    bool ok = motion_reserve(m, COLOUR_STARTS, KEYS + 1, sizeof(uint32_t), err);
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

static bool read_starts(duet_motion *m, duet_error *err)
{
    uint32_t starts[KEYS + 1];
    bool ok =
        motion_launch(m, "graph_colour", m->kernels.row_start, (uint64_t)m->n_contacts + 1, err) &&
        timeline_read(&m->times, "graph_colour", &m->buffers[COLOUR_STARTS], starts, sizeof starts,
                      err);
    if (ok)
        lay_colours(m, starts);
    return ok;
}

// Contacts of one colour after the other into LIST.
static bool sort_colours(duet_motion *m, duet_error *err)
{
    const uint32_t none[KEYS + 1] = {0};
    buffer *b = m->buffers;
    const radix_lists lists = {&b[LIST_KEYS], &b[LIST], &b[LIST_KEYS_SPARE], &b[LIST_SPARE]};
    lay_colours(m, none);
    if (m->n_contacts == 0)
        return true;
    return reserve_lists(m, err) &&
           motion_launch(m, "graph_colour", m->kernels.graph_colour_key, m->n_contacts, err) &&
           radix_sort_run(&m->radix, &m->times, "graph_colour", &lists, m->n_contacts, KEY_BITS,
                          err) &&
           read_starts(m, err) &&
           motion_reserve(m, BLOCKS, (uint64_t)m->n_blocks * m->layout.block,
                          m->layout.constraint * sizeof(float), err);
}

// ---------------------------------------------------------------- colours

static bool mark(duet_motion *m, duet_error *err)
{
    return motion_launch(m, "graph_colour", m->kernels.graph_colour_mark, m->n_contacts, err) &&
           motion_read_flags(m, err);
}

static bool run_round(duet_motion *m, duet_error *err)
{
    return motion_launch(m, "graph_colour", m->kernels.graph_colour_choose, m->n, err) &&
           motion_launch(m, "graph_colour", m->kernels.graph_colour_take, m->n, err);
}

// Each round colours at least the contact of greatest rank, so rounds end.
bool motion_colour(duet_motion *m, duet_error *err)
{
    bool ok = mark(m, err);
    while (ok && m->flags[FLAG_UNCOLOURED] > 0) {
        for (int i = 0; ok && i < ROUNDS_AT_ONCE; ++i)
            ok = run_round(m, err);
        ok = ok && motion_read_flags(m, err);
    }
    m->list_stale = m->list_stale || m->rebuilt || m->flags[FLAG_RECOLOURED];
    if (!ok || !m->list_stale)
        return ok;
    m->list_stale = !sort_colours(m, err);
    return !m->list_stale;
}

// SPDX-License-Identifier: MIT
// Contacts into colours, and the list that goes colour by colour.
#include "runtime/dynamics/motion_args.h"

#include "base/error.h"

#include <string.h>

// Rounds that are sent before the host looks whether any contact still waits.
enum { ROUNDS_AT_ONCE = 4 };

// ---------------------------------------------------------------- sorting

bool motion_scan(duet_motion *m, const char *stage, motion_buffer which, uint32_t n,
                 duet_error *err)
{
    const kernel *k = m->kernels.scan_sums;
    uint32_t block = k->group * k->per_item;
    uint32_t n_blocks = (n + block - 1) / block;
    motion_args sums = args_begin(m);
    args_buffer(&sums, which);
    args_uint(&sums, n);
    args_buffer(&sums, SUMS);
    motion_args tops = args_begin(m);
    args_buffer(&tops, SUMS);
    args_uint(&tops, n_blocks);
    motion_args blocks = sums;
    args_uint(&blocks, true);
    if (!motion_reserve(m, SUMS, n_blocks, sizeof(uint32_t), err))
        return false;
    return args_launch(&sums, stage, m->kernels.scan_sums, n, err) &&
           args_launch(&tops, stage, m->kernels.scan_tops, 1, err) &&
           args_launch(&blocks, stage, m->kernels.scan_blocks, n, err);
}

static bool sort_pass(duet_motion *m, uint32_t shift, duet_error *err)
{
    const kernel *k = m->kernels.radix_count;
    uint32_t tile = k->group * k->per_item;
    uint32_t n_tiles = (m->n_contacts + tile - 1) / tile;
    uint32_t n_counts = n_tiles << kernel_param(k, "BITS");
    if (!motion_reserve(m, TILES, n_counts, sizeof(uint32_t), err))
        return false;
    motion_args count = args_begin(m);
    args_buffer(&count, LIST_KEYS);
    args_uint(&count, m->n_contacts);
    args_uint(&count, shift);
    args_buffer(&count, TILES);
    motion_args move = args_begin(m);
    args_buffer(&move, LIST_KEYS);
    args_buffer(&move, LIST);
    args_uint(&move, m->n_contacts);
    args_uint(&move, shift);
    args_uint(&move, shift == 0);
    args_buffer(&move, TILES);
    args_buffer(&move, LIST_KEYS_SPARE);
    args_buffer(&move, LIST_SPARE);
    bool ok = args_launch(&count, "graph_colour", m->kernels.radix_count, m->n_contacts, err) &&
              motion_scan(m, "graph_colour", TILES, n_counts, err) &&
              args_launch(&move, "graph_colour", m->kernels.radix_move, m->n_contacts, err);
    buffer list = m->buffers[LIST];
    m->buffers[LIST] = m->buffers[LIST_SPARE];
    m->buffers[LIST_SPARE] = list;
    list = m->buffers[LIST_KEYS];
    m->buffers[LIST_KEYS] = m->buffers[LIST_KEYS_SPARE];
    m->buffers[LIST_KEYS_SPARE] = list;
    return ok;
}

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
    motion_args a = args_begin(m);
    args_buffer(&a, LIST_KEYS);
    args_uint(&a, m->n_contacts);
    args_uint(&a, KEYS);
    args_buffer(&a, COLOUR_STARTS);
    bool ok =
        args_launch(&a, "graph_colour", m->kernels.row_start, (uint64_t)m->n_contacts + 1, err) &&
        timeline_read(&m->times, "graph_colour", &m->buffers[COLOUR_STARTS], starts, sizeof starts,
                      err);
    if (ok)
        lay_colours(m, starts);
    return ok;
}

static bool put_keys(duet_motion *m, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, COLOUR_OF);
    args_buffer(&a, TOUCHES);
    args_uint(&a, m->n_contacts);
    args_buffer(&a, LIST_KEYS);
    return args_launch(&a, "graph_colour", m->kernels.graph_colour_key, m->n_contacts, err);
}

// Contacts of one colour after the other into LIST.
static bool sort_colours(duet_motion *m, duet_error *err)
{
    const uint32_t none[KEYS + 1] = {0};
    lay_colours(m, none);
    if (m->n_contacts == 0)
        return true;
    uint32_t bits = (uint32_t)kernel_param(m->kernels.radix_count, "BITS");
    bool ok = reserve_lists(m, err) && put_keys(m, err);
    for (uint32_t shift = 0; ok && shift < KEY_BITS; shift += bits)
        ok = sort_pass(m, shift, err);
    return ok && read_starts(m, err) &&
           motion_reserve(m, BLOCKS, (uint64_t)m->n_blocks * m->layout.block,
                          m->layout.constraint * sizeof(float), err);
}

// ---------------------------------------------------------------- colours

static bool mark(duet_motion *m, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, LINKS);
    args_buffer(&a, TOUCHES);
    args_uint(&a, m->n_contacts);
    args_uint(&a, m->n);
    args_buffer(&a, BODIES);
    args_buffer(&a, COLOUR_OF);
    args_buffer(&a, CHOICES);
    args_buffer(&a, FLAG_WORDS);
    return args_launch(&a, "graph_colour", m->kernels.graph_colour_mark, m->n_contacts, err) &&
           motion_read_flags(m, err);
}

static bool run_round(duet_motion *m, duet_error *err)
{
    motion_args choose = args_begin(m);
    args_buffer(&choose, LINKS);
    args_buffer(&choose, COLOUR_OF);
    args_buffer(&choose, STARTS);
    args_buffer(&choose, RETURN_STARTS);
    args_buffer(&choose, RETURNS);
    args_uint(&choose, m->n);
    args_buffer(&choose, USED);
    args_buffer(&choose, CHOICES);
    motion_args take = args_begin(m);
    args_buffer(&take, LINKS);
    args_uint(&take, m->n);
    args_buffer(&take, VELOCITIES);
    args_buffer(&take, USED);
    args_buffer(&take, CHOICES);
    args_buffer(&take, COLOUR_OF);
    args_buffer(&take, FLAG_WORDS);
    return args_launch(&choose, "graph_colour", m->kernels.graph_colour_choose, m->n, err) &&
           args_launch(&take, "graph_colour", m->kernels.graph_colour_take, m->n, err);
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

// SPDX-License-Identifier: MIT
// From bounds to rows: which objects may touch which, and the contacts that
// they had before.
#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion_commands.h"

#include <string.h>

// ---------------------------------------------------------------- bounds

// Separations up to the margin are contacts, so each object's bounds have half of it.
bool motion_compute_bounds(duet_motion *m, const kernel *k, uint32_t n, duet_error *err)
{
    double skin = motion_has(m, DUET_EFFECT_SKIN) ? m->def.skin : 0.0;
    m->args.aabb_margin = motion_real(m, 0.5 * (m->margin + skin));
    return motion_launch(m, "grid", k, n, err);
}

bool motion_check_bounds(duet_motion *m, duet_error *err)
{
    m->args.aabb_margin = motion_real(m, 0.5 * m->margin);
    return motion_launch(m, "fat_aabbs", m->kernels.check_fat_aabbs, m->n, err);
}

// Whether everything is still inside the bounds that the rows were made from. What a step
// moves last is checked at its end.
static bool skin_holds(duet_motion *m, bool *holds, duet_error *err)
{
    bool ok = m->bounds_checked || (motion_check_bounds(m, err) && motion_read_flags(m, err));
    *holds = !m->flags[FLAG_MOVED];
    return ok;
}

// ---------------------------------------------------------------- pairs

// What A and what B found, one behind the other.
static bool send_pairs(duet_motion *m, const duet_result *result, duet_error *err)
{
    const size_t size = sizeof *result->spans[0].pairs;
    bool ok = motion_reserve(m, PAIRS, result->pairs + 1, size, err);
    size_t at = 0;
    for (int i = 0; ok && i < 2; ++i) {
        size_t bytes = (size_t)result->spans[i].n * size;
        ok = timeline_write_at(&m->times, "contact_graph", &m->buffers[PAIRS], at,
                               result->spans[i].pairs, bytes, err);
        at += bytes;
    }
    m->args.pairs = m->buffers[PAIRS];
    return ok;
}

// Where both devices search, bounds and pairs go through the host.
static bool search_on_both(duet_motion *m, duet_result *result, duet_error *err)
{
    duet_bounds *bounds = duet_world_map_objects(m->world, DUET_OBJECT_BOUNDS, m->n, err);
    return bounds &&
           timeline_read(&m->times, "grid", &m->buffers[BOXES], bounds, m->n * sizeof *bounds,
                         err) &&
           duet_world_step(m->world, result, err) && send_pairs(m, result, err);
}

static bool search_on_b(duet_motion *m, duet_result *result, duet_error *err)
{
    const buffer *pairs = NULL;
    m->world->parts[1].untimed = m->times.untimed;
    bool ok = world_step_resident(m->world, &m->buffers[BOXES], m->n, result, &pairs, err);
    m->args.pairs = *pairs;
    return ok;
}

// What is hidden is left out, and nothing else may be.
static bool check_left_out(duet_motion *m, const duet_result *result, duet_error *err)
{
    uint32_t hidden = m->commands ? m->commands->n_hidden : 0;
    return result->bad == hidden ||
           (motion_check_states(m, err) &&
            error_set(err, DUET_STATUS_BAD_OBJECT,
                      "the bounds of %u objects of %u are not finite after step %llu",
                      result->bad - hidden, m->n - hidden, (unsigned long long)m->step));
}

static bool find_pairs(duet_motion *m, duet_error *err)
{
    duet_result result;
    m->world->def.keep_bad = m->commands && m->commands->n_hidden > 0;
    bool ok =
        world_is_b_alone(m->world) ? search_on_b(m, &result, err) : search_on_both(m, &result, err);
    ok = ok && check_left_out(m, &result, err);
    if (ok)
        timeline_add_host(&m->times, "pairs", result.total_ms);
    m->n_pairs = ok ? result.pairs : 0;
    return ok;
}

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

// The last of the starts: how many there are.
static bool read_total(duet_motion *m, motion_buffer starts, uint32_t *total, duet_error *err)
{
    return timeline_read_at(&m->times, "contact_graph", &m->buffers[starts], m->n * sizeof *total,
                            total, sizeof *total, err);
}

static bool scan_starts(duet_motion *m, motion_buffer starts, duet_error *err)
{
    return scan_run(&m->scan, &m->times, "contact_graph", &m->buffers[starts], m->n + 1, err);
}

static bool count_rows(duet_motion *m, duet_error *err)
{
    size_t n_starts = (size_t)m->n + 1;
    return timeline_fill(&m->times, "contact_graph", &m->buffers[STARTS], 0, 0, n_starts, err) &&
           motion_reserve(m, OTHERS, 1, sizeof(uint32_t), err) && put_all(m, 0, err) &&
           scan_starts(m, STARTS, err);
}

static bool fill_rows(duet_motion *m, uint64_t most, duet_error *err)
{
    return motion_reserve(m, OTHERS, most + 1, sizeof(uint32_t), err) && put_all(m, 1, err) &&
           sort_rows(m, STARTS, OTHERS, err) && read_total(m, STARTS, &m->n_contacts, err);
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

// ---------------------------------------------------------------- contacts

static bool match_contacts(duet_motion *m, uint32_t n_old, duet_error *err)
{
    m->args.n_old = n_old;
    return motion_launch(m, "match_contacts", m->kernels.match_contacts, n_old, err);
}

// What had left its bounds has new ones.
static bool find_all_pairs(duet_motion *m, duet_error *err)
{
    return (!m->flags[FLAG_MOVED] || timeline_fill(&m->times, "clear", &m->buffers[FLAG_WORDS], 0,
                                                   FLAG_MOVED, FLAG_MOVED + 1, err)) &&
           motion_compute_bounds(m, m->kernels.compute_fat_aabbs, m->n, err) && find_pairs(m, err);
}

// Those of what commands altered, where the others' hold on; else all.
static bool find_candidates(duet_motion *m, duet_error *err)
{
    bool some = !m->rows_stale && motion_rows_are_stale(m), found = false;
    if (some && !motion_find_altered_pairs(m, &found, err))
        return false;
    m->rows_stale = false;
    if (m->commands)
        m->commands->n_altered = 0;
    return found || find_all_pairs(m, err);
}

static bool build_graph(duet_motion *m, duet_error *err)
{
    if (!find_candidates(m, err))
        return false;
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
    m->rebuilt = false;
    bool holds = false;
    bool skin = m->has_graph && !motion_rows_are_stale(m) && motion_has(m, DUET_EFFECT_SKIN);
    if (skin && !skin_holds(m, &holds, err))
        return false;
    return holds || build_graph(m, err);
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

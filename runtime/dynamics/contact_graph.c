// SPDX-License-Identifier: MIT
// Which bodies may touch: from bounds to pairs, and from pairs to the contacts of each body.
//
// A world of the bodies' bounds searches the pairs, or an index of the altered bodies those of
// these alone (altered.h). Contacts are rows of their owners, and take over what those before them
// had.
#include "base/error.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion_commands.h"

#include <math.h>
#include <stdlib.h>

// ---------------------------------------------------------------- bounds

bool motion_check_bounds(duet_motion *m, bool of_all, duet_error *err)
{
    m->graph.of_all = of_all;
    return motion_launch(m, CHECK_FAT_AABBS, err);
}

void motion_note_bounds(duet_motion *m)
{
    if (m->flags[FLAG_MOVED])
        product_forget(&m->products, PRODUCT_BOUNDS);
    else
        product_keep(&m->products, PRODUCT_BOUNDS);
}

// Whether everything is still inside them. Bodies that had left get new ones.
static bool keep_bounds(duet_motion *m, duet_error *err)
{
    if (!motion_check_bounds(m, true, err) || !motion_read_flags(m, err))
        return false;
    motion_note_bounds(m);
    return !m->flags[FLAG_MOVED] ||
           motion_clear(m, "clear", FLAG_WORDS, FLAG_MOVED, FLAG_MOVED + 1, err);
}

static bool compute_bounds(duet_motion *m, duet_error *err)
{
    altered_forget(&m->altered);
    product_renew(&m->products, PRODUCT_BOUNDS);
    return motion_launch(m, COMPUTE_FAT_AABBS, err);
}

bool motion_make_bounds(duet_motion *m, duet_error *err)
{
    bool checks =
        m->kernels.of[CHECK_FAT_AABBS] && !product_is_forgotten(&m->products, PRODUCT_BOUNDS);
    return (!checks || keep_bounds(m, err)) &&
           (product_is_right(&m->products, PRODUCT_BOUNDS) || compute_bounds(m, err));
}

// ---------------------------------------------------------------- pairs

static bool are_right(const duet_bounds *b, uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k)
        if (!isfinite(b->lower[k]) || !isfinite(b->upper[k]) || b->lower[k] > b->upper[k])
            return false;
    return true;
}

static bool tell_left_out(duet_motion *m, duet_error *err)
{
    duet_bounds *bounds = malloc(m->n * sizeof *bounds);
    uint32_t id = 0;
    if (!bounds)
        return no_memory(err, "%u bounds", m->n);
    bool ok = motion_fetch(m, "grid", BOXES, 0, bounds, m->n * sizeof *bounds, err);
    while (ok && id + 1 < m->n &&
           (m->commands->states[id] != PLACE_ENABLED || are_right(&bounds[id], m->def.dims)))
        ++id;
    free(bounds);
    return ok && error_set(err, DUET_STATUS_BAD_OBJECT,
                           "object %u of %u: its bounds are not finite after step %llu", id, m->n,
                           (unsigned long long)m->step);
}

uint64_t motion_most_contacts(const duet_motion *m, uint64_t pairs)
{
    return pairs + (motion_touches_walls(m) ? 6 * (uint64_t)m->n : 0) +
           (motion_touches_ground(m) ? GROUND_CONTACTS * (uint64_t)m->n : 0);
}

static bool note_pairs(duet_motion *m, uint64_t n, const buffer *pairs, duet_error *err)
{
    const uint64_t most = motion_most_contacts(m, n);
    if (most >= UINT32_MAX)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu pairs of bounds, and a motion holds %u",
                         (unsigned long long)most, UINT32_MAX - 1);
    m->graph.n_pairs = (cl_uint)n;
    m->graph.pairs = *pairs;
    product_renew(&m->products, PRODUCT_PAIRS);
    return true;
}

static bool search_all(duet_motion *m, duet_error *err)
{
    duet_result *found = &m->graph.searched;
    const buffer *pairs;
    uint32_t hidden = motion_count_hidden(m); // these are left out
    m->graph.world->def.keep_bad = hidden > 0;
    bool ok = world_step_resident(m->graph.world, &m->buffers[BOXES], m->n, m->times.untimed, found,
                                  &pairs, err) &&
              (found->bad == hidden || tell_left_out(m, err));
    if (ok)
        timeline_add_host(&m->times, "pairs", found->total_ms);
    motion_plan_note(m); // the mode may follow the grid
    return ok && note_pairs(m, found->pairs, pairs, err);
}

// Searches pairs of the altered bodies, or of all bodies if none is listed or they have too many
// pairs.
bool motion_make_pairs(duet_motion *m, duet_error *err)
{
    cl_uint n = 0;
    bool listed = m->altered.n > 0;
    if (listed && !motion_search_altered(m, &n, err))
        return false;
    altered_forget(&m->altered);
    if (listed && n <= m->altered.pair_capacity)
        return note_pairs(m, n, &m->buffers[PAIRS], err);
    return (!listed || compute_bounds(m, err)) && search_all(m, err);
}

bool motion_take_search(duet_motion *m, duet_result *search)
{
    *search = m->graph.searched;
    m->graph.searched = (duet_result){0};
    return search->total_ms > 0;
}

void motion_refit_grid(duet_motion *m)
{
    if (m->graph.world)
        world_refit_grid(m->graph.world);
}

// ---------------------------------------------------------------- rows

// Counts (fill 0) or writes (fill 1) what each object may touch.
static bool put_all(duet_motion *m, uint32_t fill, duet_error *err)
{
    m->graph.fill = fill;
    return motion_launch(m, CONTACT_GRAPH_ROWS, err);
}

static bool sort_rows(duet_motion *m, motion_buffer starts, motion_buffer values, duet_error *err)
{
    m->graph.row_starts = m->buffers[starts];
    m->graph.row_values = m->buffers[values];
    return motion_launch(m, CONTACT_GRAPH_SORT, err);
}

static bool scan_starts(duet_motion *m, motion_buffer starts, duet_error *err)
{
    return scan_run(&m->graph.scan, &m->times, "contact_graph", &m->buffers[starts],
                    &m->buffers[starts], m->n + 1, err);
}

// Bodies have no rows of a kind yet.
static bool clear_starts(duet_motion *m, motion_buffer starts, duet_error *err)
{
    return motion_clear(m, "contact_graph", starts, 0, (size_t)m->n + 1, err);
}

// Stages of a team that makes rows (kernels/dynamics/contact_graph.cl); pairs or bodies that a
// group has at least.
enum { ROWS_STAGES = 3, ROWS_LEAST = 256 };

//   most  values of all rows
static bool make_by_team(duet_motion *m, motion_kernel k, uint32_t work, uint64_t most,
                         duet_error *err)
{
    const uint64_t counts = (uint64_t)TEAM_MOST * ROW_PARTS * ROW_BUCKETS + ROW_BUCKETS + 1;
    return motion_reserve(m, LIST_SPARE, most + 1, sizeof(uint32_t), err) &&
           motion_reserve(m, LIST_KEYS_SPARE, most + 1, sizeof(uint32_t), err) &&
           motion_reserve(m, ROW_COUNTS, counts, sizeof(uint32_t), err) &&
           team_launch(m, k, work > m->n ? work : m->n, ROWS_LEAST, ROWS_STAGES, err);
}

static bool put_rows(duet_motion *m, duet_error *err)
{
    if (motion_has_team(m, MAKE_ROWS))
        return make_by_team(m, MAKE_ROWS, m->graph.n_pairs,
                            motion_most_contacts(m, m->graph.n_pairs), err);
    return clear_starts(m, STARTS, err) && put_all(m, 0, err) && scan_starts(m, STARTS, err) &&
           put_all(m, 1, err) && sort_rows(m, STARTS, OTHERS, err);
}

// The last of the starts says how many contacts there are.
static bool fill_rows(duet_motion *m, duet_error *err)
{
    return put_rows(m, err) &&
           motion_fetch(m, "contact_graph", STARTS, m->n * sizeof m->graph.n_contacts,
                        &m->graph.n_contacts, sizeof m->graph.n_contacts, err);
}

static bool put_returns(duet_motion *m, uint32_t fill, duet_error *err)
{
    m->graph.fill = fill;
    return motion_launch(m, CONTACT_GRAPH_REVERSE, err);
}

static bool reserve_contacts(duet_motion *m, duet_error *err)
{
    uint64_t n = (uint64_t)m->graph.n_contacts + 1;
    return motion_reserve(m, RETURNS, n, sizeof(uint32_t), err) &&
           motion_reserve(m, LINKS, n, 2 * sizeof(uint32_t), err) &&
           motion_reserve(m, CONTACTS, n * m->layout.record, sizeof(float), err) &&
           motion_reserve(m, TOUCHES, n, sizeof(uint32_t), err) &&
           (!(m->effects & DUET_EFFECT_CONTACT_RESPONSE) ||
            motion_reserve(m, COLOUR_OF, n, sizeof(uint32_t), err));
}

static bool fill_returns(duet_motion *m, duet_error *err)
{
    if (!reserve_contacts(m, err))
        return false;
    if (motion_has_team(m, MAKE_RETURNS))
        return make_by_team(m, MAKE_RETURNS, m->graph.n_contacts, m->graph.n_contacts, err);
    return clear_starts(m, RETURN_STARTS, err) && put_returns(m, 0, err) &&
           scan_starts(m, RETURN_STARTS, err) && put_returns(m, 1, err) &&
           sort_rows(m, RETURN_STARTS, RETURNS, err);
}

// Whether rows have no contacts and had none before.
static bool stay_empty(const duet_motion *m)
{
    return m->graph.n_without > 0 && m->graph.n_without == m->n &&
           product_was_made(&m->products, PRODUCT_ROWS) &&
           motion_most_contacts(m, m->graph.n_pairs) == 0;
}

// The contacts before are matched with the new ones, which have other places in the list by colour.
static bool make_rows(duet_motion *m, duet_error *err)
{
    const uint64_t most = motion_most_contacts(m, m->graph.n_pairs);
    buffer *b = m->buffers;
    m->graph.n_without = 0;
    m->graph.n_old = m->graph.n_contacts;
    buffer_swap(&b[LINKS], &b[OLD_LINKS]);
    buffer_swap(&b[CONTACTS], &b[OLD_CONTACTS]);
    buffer_swap(&b[TOUCHES], &b[OLD_TOUCHES]);
    buffer_swap(&b[COLOUR_OF], &b[OLD_COLOURS]);
    return motion_reserve(m, OTHERS, most + 1, sizeof(uint32_t), err) && fill_rows(m, err) &&
           fill_returns(m, err) && motion_launch(m, MATCH_CONTACTS, err);
}

bool motion_make_rows(duet_motion *m, duet_error *err)
{
    if (!stay_empty(m) && !make_rows(m, err))
        return false;
    m->graph.n_without = m->graph.n_contacts == 0 ? m->n : 0;
    product_renew(&m->products, PRODUCT_ROWS);
    product_forget(&m->products, PRODUCT_COLOURS);
    return true;
}

// SPDX-License-Identifier: MIT
// Which bodies may touch: from fat AABBs to pairs, and from pairs to the contacts of each body.
//
// All pairs are searched by a world of the bodies' bounds. After commands that let bodies come, go
// or touch others than before, the pairs of all other bodies hold on within a skin; only those
// of the altered ones are searched, by a hash table of them. Contacts are rows of their owners
// and take over what those of the step before had.
#include "base/compare.h"
#include "base/error.h"
#include "kernels/dynamics/altered.h"
#include "runtime/broadphase/world.h"
#include "runtime/dynamics/motion_commands.h"

#include <math.h>
#include <stdlib.h>

// More altered bodies are searched with all others, whose grid costs less then.
enum { LEAST_PART = 8 };

// Pairs that an altered body may have; with more, all are searched.
enum { PAIRS_OF_ONE = 64 };

// Over so many bodies, pairs or contacts.
static bool launch(duet_motion *m, const char *stage, const kernel *k, uint64_t work,
                   duet_error *err)
{
    return timeline_launch(&m->times, stage, k, work, m, err);
}

// Words [from, to) of a buffer become 0; and bytes of one, from byte `at`, are waited for.
static bool clear(duet_motion *m, const char *stage, motion_buffer which, size_t from, size_t to,
                  duet_error *err)
{
    return timeline_fill(&m->times, stage, &m->buffers[which], 0, from, to, err);
}

static bool fetch(duet_motion *m, const char *stage, motion_buffer which, size_t at, void *to,
                  size_t bytes, duet_error *err)
{
    return timeline_read_at(&m->times, stage, &m->buffers[which], at, to, bytes, err);
}

// ---------------------------------------------------------------- bounds

bool motion_check_bounds(duet_motion *m, duet_error *err)
{
    return launch(m, "fat_aabbs", m->kernels.check_fat_aabbs, m->n, err);
}

// Whether everything is still inside the bounds that the rows were made from. What a step
// moves last is checked at its end.
static bool bounds_hold(duet_motion *m, bool *hold, duet_error *err)
{
    bool ok = m->bounds_checked || (motion_check_bounds(m, err) && motion_read_flags(m, err));
    *hold = !m->flags[FLAG_MOVED];
    return ok;
}

// ---------------------------------------------------------------- pairs of all bodies

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
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u bounds", m->n);
    bool ok = fetch(m, "grid", BOXES, 0, bounds, m->n * sizeof *bounds, err);
    while (ok && id + 1 < m->n &&
           (m->commands->states[id] != PLACE_ENABLED || are_right(&bounds[id], m->def.dims)))
        ++id;
    free(bounds);
    return ok && error_set(err, DUET_STATUS_BAD_OBJECT,
                           "object %u of %u: its bounds are not finite after step %llu", id, m->n,
                           (unsigned long long)m->step);
}

static bool find_pairs(duet_motion *m, duet_error *err)
{
    duet_result *found = &m->searched;
    const buffer *pairs;
    uint32_t hidden = m->commands ? m->commands->n_hidden : 0; // these are left out
    m->world->def.keep_bad = hidden > 0;
    bool ok = world_step_resident(m->world, &m->buffers[BOXES], m->n, m->times.untimed, found,
                                  &pairs, err) &&
              (found->bad == hidden || tell_left_out(m, err));
    if (ok)
        timeline_add_host(&m->times, "pairs", found->total_ms);
    motion_plan_note(m); // the mode may follow the grid
    m->n_pairs = ok ? found->pairs : 0;
    m->args.pairs = ok ? *pairs : (buffer){0};
    return ok;
}

// What had left its bounds has new ones.
static bool find_all_pairs(duet_motion *m, duet_error *err)
{
    return (!m->flags[FLAG_MOVED] ||
            clear(m, "clear", FLAG_WORDS, FLAG_MOVED, FLAG_MOVED + 1, err)) &&
           launch(m, "grid", m->kernels.compute_fat_aabbs, m->n, err) && find_pairs(m, err);
}

// ---------------------------------------------------------------- altered bodies

static bool reserve(motion_commands *c, uint64_t n)
{
    if (n <= c->altered_capacity)
        return true;
    uint32_t *altered = realloc(c->altered, 2 * n * sizeof *altered);
    if (!altered)
        return false;
    c->altered = altered;
    c->altered_capacity = (uint32_t)(2 * n);
    return true;
}

void motion_alter_places(duet_motion *m, const uint32_t *places, uint32_t n)
{
    motion_commands *c = m->commands;
    uint64_t all = (uint64_t)c->n_altered + n;
    m->rows_stale = m->rows_stale || !m->has_graph || !(m->effects & DUET_EFFECT_SKIN) ||
                    all > m->n / LEAST_PART || !reserve(c, all);
    for (uint32_t i = 0; i < n && !m->rows_stale; ++i)
        c->altered[c->n_altered++] = places[i];
}

bool motion_rows_are_stale(const duet_motion *m)
{
    return m->rows_stale || (m->commands && m->commands->n_altered > 0);
}

static void list_once(motion_commands *c)
{
    uint32_t n = 0;
    qsort(c->altered, c->n_altered, sizeof *c->altered, compare_uint32);
    for (uint32_t i = 0; i < c->n_altered; ++i)
        if (n == 0 || c->altered[n - 1] != c->altered[i])
            c->altered[n++] = c->altered[i];
    c->n_altered = n;
}

// ---------------------------------------------------------------- a table of them

// Twice as wide as what is altered, in the mean: few bodies overlap more than eight.
static double edge_of(const duet_motion *m)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < m->commands->n_altered; ++i) {
        const float *h = m->poses[m->commands->altered[i]].half_extents;
        sum += fmax(fmax(h[0], h[1]), m->def.dims == 3 ? h[2] : 0.0f);
    }
    return 4.0 * sum / m->commands->n_altered + 2.0 * (m->margin + motion_skin(m));
}

static uint32_t count_heads(uint32_t n_altered)
{
    uint32_t n = 1024;
    while (n < 16 * (uint64_t)n_altered && n < 1u << 31)
        n *= 2;
    return n;
}

static void set_args(duet_motion *m)
{
    motion_args *args = &m->args;
    args->n_altered = m->commands->n_altered;
    args->n_heads = count_heads(args->n_altered);
    args->per_edge = (float)fmin(1.0 / edge_of(m), 1e30);
    args->pair_capacity = m->n_contacts + PAIRS_OF_ONE * args->n_altered;
}

static bool reserve_table(duet_motion *m, duet_error *err)
{
    const uint64_t word = sizeof(uint32_t), n = m->args.n_altered;
    return motion_reserve(m, ALTERED, n, word, err) &&
           motion_reserve(m, IS_ALTERED, m->n, word, err) &&
           motion_reserve(m, ALTERED_HEADS, m->args.n_heads, word, err) &&
           motion_reserve(m, ALTERED_ENTRIES_OF, ALTERED_CELLS * n, sizeof(cl_int4), err) &&
           motion_reserve(m, ALTERED_NEXTS, ALTERED_CELLS * n, word, err) &&
           motion_reserve(m, ALTERED_WIDE_ONES, n, word, err) &&
           motion_reserve(m, ALTERED_COUNT_WORDS, ALTERED_COUNTS, word, err) &&
           motion_reserve(m, PAIRS, m->args.pair_capacity, 2 * word, err);
}

static bool send_altered(duet_motion *m, duet_error *err)
{
    const motion_commands *c = m->commands;
    const char *stage = "altered_pairs";
    return clear(m, stage, IS_ALTERED, 0, m->n, err) &&
           clear(m, stage, ALTERED_HEADS, 0, m->args.n_heads, err) &&
           clear(m, stage, ALTERED_COUNT_WORDS, 0, ALTERED_COUNTS, err) &&
           timeline_write_at(&m->times, stage, &m->buffers[ALTERED], 0, c->altered,
                             c->n_altered * sizeof *c->altered, err);
}

static bool prepare(duet_motion *m, duet_error *err)
{
    motion_kernels *k = &m->kernels;
    const bindings from = motion_bindings;
    const kernel_request list[] = {
        {&k->compute_altered_aabbs, true, "fat_aabbs", "compute_fat_aabbs", from},
        {&k->place_altered, true, "altered_pairs", "place_altered", from},
        {&k->find_altered_pairs, true, "altered_pairs", "find_altered_pairs", from},
        {&k->keep_pairs, true, "altered_pairs", "keep_pairs", from},
    };
    return motion_build_kernels(m, list, sizeof list / sizeof *list, true, err);
}

static bool place_altered(duet_motion *m, duet_error *err)
{
    list_once(m->commands);
    set_args(m);
    return prepare(m, err) && reserve_table(m, err) && send_altered(m, err) &&
           launch(m, "grid", m->kernels.compute_altered_aabbs, m->args.n_altered, err) &&
           launch(m, "altered_pairs", m->kernels.place_altered, m->args.n_altered, err);
}

static bool search_altered(duet_motion *m, bool *found, duet_error *err)
{
    uint32_t counts[ALTERED_COUNTS];
    bool ok = launch(m, "altered_pairs", m->kernels.find_altered_pairs, m->n, err) &&
              launch(m, "altered_pairs", m->kernels.keep_pairs, m->n_contacts, err) &&
              fetch(m, "altered_pairs", ALTERED_COUNT_WORDS, 0, counts, sizeof counts, err);
    *found = ok && counts[ALTERED_PAIRS] <= m->args.pair_capacity;
    if (!*found)
        return ok;
    m->n_pairs = counts[ALTERED_PAIRS];
    m->args.pairs = m->buffers[PAIRS];
    return true;
}

static bool find_altered_pairs(duet_motion *m, bool *found, duet_error *err)
{
    bool hold = false;
    *found = false;
    return place_altered(m, err) && bounds_hold(m, &hold, err) &&
           (!hold || search_altered(m, found, err));
}

// ---------------------------------------------------------------- pairs of either

// Those of what commands altered, where the others' hold on; else all.
static bool search(duet_motion *m, duet_error *err)
{
    bool some = !m->rows_stale && motion_rows_are_stale(m), found = false;
    if (some && !find_altered_pairs(m, &found, err))
        return false;
    m->rows_stale = false;
    if (m->commands)
        m->commands->n_altered = 0;
    return found || find_all_pairs(m, err);
}

static bool find_candidates(duet_motion *m, bool *hold, duet_error *err)
{
    bool skin = m->has_graph && !motion_rows_are_stale(m) && (m->effects & DUET_EFFECT_SKIN);
    *hold = false;
    return (!skin || bounds_hold(m, hold, err)) && (*hold || search(m, err));
}

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
    return launch(m, "contact_graph", k->contact_graph_pairs, m->n_pairs, err) &&
           (!k->contact_graph_walls ||
            launch(m, "contact_graph", k->contact_graph_walls, m->n, err));
}

static bool sort_rows(duet_motion *m, motion_buffer starts, motion_buffer values, duet_error *err)
{
    m->args.row_starts = m->buffers[starts];
    m->args.row_values = m->buffers[values];
    return launch(m, "contact_graph", m->kernels.contact_graph_sort, m->n, err);
}

static bool scan_starts(duet_motion *m, motion_buffer starts, duet_error *err)
{
    return scan_run(&m->scan, &m->times, "contact_graph", &m->buffers[starts], &m->buffers[starts],
                    m->n + 1, err);
}

// Bodies have no rows of a kind yet.
static bool clear_starts(duet_motion *m, motion_buffer starts, duet_error *err)
{
    return clear(m, "contact_graph", starts, 0, (size_t)m->n + 1, err);
}

// The last of the starts says how many contacts there are.
static bool fill_rows(duet_motion *m, duet_error *err)
{
    return clear_starts(m, STARTS, err) && put_all(m, 0, err) && scan_starts(m, STARTS, err) &&
           put_all(m, 1, err) && sort_rows(m, STARTS, OTHERS, err) &&
           fetch(m, "contact_graph", STARTS, m->n * sizeof m->n_contacts, &m->n_contacts,
                 sizeof m->n_contacts, err);
}

static bool put_returns(duet_motion *m, uint32_t fill, duet_error *err)
{
    m->args.fill = fill;
    return launch(m, "contact_graph", m->kernels.contact_graph_reverse, m->n, err);
}

static bool reserve_contacts(duet_motion *m, duet_error *err)
{
    uint64_t n = (uint64_t)m->n_contacts + 1;
    return motion_reserve(m, RETURNS, n, sizeof(uint32_t), err) &&
           motion_reserve(m, LINKS, n, 2 * sizeof(uint32_t), err) &&
           motion_reserve(m, CONTACTS, n * m->layout.record, sizeof(float), err) &&
           motion_reserve(m, TOUCHES, n, sizeof(uint32_t), err) &&
           (!(m->effects & DUET_EFFECT_CONTACT_RESPONSE) ||
            motion_reserve(m, COLOUR_OF, n, sizeof(uint32_t), err));
}

static bool fill_returns(duet_motion *m, duet_error *err)
{
    return reserve_contacts(m, err) && clear_starts(m, RETURN_STARTS, err) &&
           put_returns(m, 0, err) && scan_starts(m, RETURN_STARTS, err) && put_returns(m, 1, err) &&
           sort_rows(m, RETURN_STARTS, RETURNS, err);
}

static bool match_contacts(duet_motion *m, uint32_t n_old, duet_error *err)
{
    m->args.n_old = n_old;
    return launch(m, "match_contacts", m->kernels.match_contacts, n_old, err);
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
    return check_capacity(m, &most, err) &&
           motion_reserve(m, OTHERS, most + 1, sizeof(uint32_t), err) && fill_rows(m, err) &&
           fill_returns(m, err) && match_contacts(m, n_old, err);
}

bool motion_build_graph(duet_motion *m, duet_error *err)
{
    bool hold;
    m->rebuilt = false;
    return find_candidates(m, &hold, err) && (hold || build_rows(m, err));
}

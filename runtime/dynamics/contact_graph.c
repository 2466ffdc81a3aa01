// SPDX-License-Identifier: MIT
// From bounds to rows: which objects may touch which, and the contacts that
// they had before.
#include "runtime/dynamics/motion_args.h"

#include "base/error.h"

#include <string.h>

// ---------------------------------------------------------------- bounds

// Where walls are; far away where there are none.
static void add_walls(motion_args *a)
{
    const duet_motion_def *d = &a->motion->def;
    bool walls = d->edge == DUET_EDGE_WALLS;
    const double far = 1e30;
    args_real4(a, walls ? d->lower[0] : -far, walls ? d->lower[1] : -far,
               walls ? d->lower[2] : -far, 0.0);
    args_real4(a, walls ? d->upper[0] : far, walls ? d->upper[1] : far, walls ? d->upper[2] : far,
               0.0);
}

static void add_shape(motion_args *a, double margin)
{
    duet_motion *m = a->motion;
    args_buffer(a, CENTRES);
    args_cells(a);
    if (m->cells)
        args_int4(a, m->cells[0]);
    args_buffer_for(a, DUET_EFFECT_ROTATION, ROTATIONS);
    if (motion_has(m, DUET_EFFECT_CONTINUOUS)) {
        args_buffer(a, VELOCITIES);
        args_real(a, m->def.dt);
    }
    args_buffer(a, HALVES);
    args_real(a, margin);
    args_uint(a, m->n);
    args_buffer(a, BOXES);
}

// Separations up to the margin are contacts, so each object's bounds have half of it.
static bool compute_fat_aabbs(duet_motion *m, duet_error *err)
{
    motion_args a = args_begin(m);
    double skin = motion_has(m, DUET_EFFECT_SKIN) ? m->def.skin : 0.0;
    add_shape(&a, 0.5 * (m->margin + skin));
    return args_launch(&a, "grid", m->kernels.compute_fat_aabbs, m->n, err);
}

// Whether everything is still inside the bounds that the rows were made from.
static bool skin_holds(duet_motion *m, bool *holds, duet_error *err)
{
    motion_args a = args_begin(m);
    add_shape(&a, 0.5 * m->margin);
    args_buffer(&a, FLAG_WORDS);
    bool ok = args_launch(&a, "fat_aabbs", m->kernels.check_fat_aabbs, m->n, err) &&
              motion_read_flags(m, err);
    *holds = !m->flags[FLAG_MOVED];
    return ok;
}

// ---------------------------------------------------------------- pairs

static bool find_pairs(duet_motion *m, duet_result *result, duet_error *err)
{
    duet_bounds *bounds = duet_world_map_objects(m->world, DUET_OBJECT_BOUNDS, m->n, err);
    bool ok = bounds && timeline_read(&m->times, "grid", &m->buffers[BOXES], bounds,
                                      m->n * sizeof *bounds, err);
    ok = ok && duet_world_step(m->world, result, err);
    if (ok)
        timeline_add_host(&m->times, "pairs", result->total_ms);
    m->n_pairs = ok ? result->pairs : 0;
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

// What A and what B found, one behind the other.
static bool send_pairs(duet_motion *m, const duet_result *result, duet_error *err)
{
    const size_t size = sizeof *result->spans[0].pairs;
    bool ok = motion_reserve(m, PAIRS, m->n_pairs + 1, size, err);
    size_t at = 0;
    for (int i = 0; ok && i < 2; ++i) {
        size_t bytes = (size_t)result->spans[i].n * size;
        ok = timeline_write_at(&m->times, "contact_graph", &m->buffers[PAIRS], at,
                               result->spans[i].pairs, bytes, err);
        at += bytes;
    }
    return ok;
}

static bool put_pairs(duet_motion *m, uint32_t fill, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, PAIRS);
    args_uint(&a, (uint32_t)m->n_pairs);
    args_buffer(&a, VELOCITIES);
    args_buffer_for(&a, DUET_EFFECT_FILTER, FILTERS);
    args_uint(&a, fill);
    args_buffer(&a, STARTS);
    args_buffer(&a, OTHERS);
    return args_launch(&a, "contact_graph", m->kernels.contact_graph_pairs, m->n_pairs, err);
}

static bool put_walls(duet_motion *m, uint32_t fill, duet_error *err)
{
    if (!m->kernels.contact_graph_walls)
        return true;
    motion_args a = args_begin(m);
    args_buffer(&a, BOXES);
    args_buffer(&a, VELOCITIES);
    add_walls(&a);
    args_uint(&a, m->n);
    args_uint(&a, fill);
    args_buffer(&a, STARTS);
    args_buffer(&a, OTHERS);
    return args_launch(&a, "contact_graph", m->kernels.contact_graph_walls, m->n, err);
}

static bool put_all(duet_motion *m, uint32_t fill, duet_error *err)
{
    return put_pairs(m, fill, err) && put_walls(m, fill, err);
}

static bool sort_rows(duet_motion *m, motion_buffer starts, motion_buffer values, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, starts);
    args_uint(&a, m->n);
    args_buffer(&a, values);
    return args_launch(&a, "contact_graph", m->kernels.contact_graph_sort, m->n, err);
}

// The last of the starts: how many there are.
static bool read_total(duet_motion *m, motion_buffer starts, uint32_t *total, duet_error *err)
{
    cl_int code = clEnqueueReadBuffer(m->device->queue, m->buffers[starts].mem, CL_TRUE,
                                      m->n * sizeof *total, sizeof *total, total, 0, NULL, NULL);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: reading a count", m->device->info.selector);
}

static bool count_rows(duet_motion *m, duet_error *err)
{
    size_t n_starts = (size_t)m->n + 1;
    return timeline_fill(&m->times, "contact_graph", &m->buffers[STARTS], 0, 0, n_starts, err) &&
           motion_reserve(m, OTHERS, 1, sizeof(uint32_t), err) && put_all(m, 0, err) &&
           motion_scan(m, "contact_graph", STARTS, (uint32_t)n_starts, err);
}

static bool fill_rows(duet_motion *m, uint64_t most, duet_error *err)
{
    return motion_reserve(m, OTHERS, most + 1, sizeof(uint32_t), err) && put_all(m, 1, err) &&
           sort_rows(m, STARTS, OTHERS, err) && read_total(m, STARTS, &m->n_contacts, err);
}

static bool put_returns(duet_motion *m, uint32_t fill, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, STARTS);
    args_buffer(&a, OTHERS);
    args_uint(&a, m->n);
    args_buffer(&a, VELOCITIES);
    args_uint(&a, fill);
    args_buffer(&a, LINKS);
    args_buffer(&a, RETURN_STARTS);
    args_buffer(&a, RETURNS);
    return args_launch(&a, "contact_graph", m->kernels.contact_graph_reverse, m->n, err);
}

static bool fill_returns(duet_motion *m, duet_error *err)
{
    size_t n_starts = (size_t)m->n + 1;
    uint64_t n = (uint64_t)m->n_contacts + 1;
    return motion_reserve(m, LINKS, n, 2 * sizeof(uint32_t), err) &&
           motion_reserve(m, RETURNS, n, sizeof(uint32_t), err) &&
           timeline_fill(&m->times, "contact_graph", &m->buffers[RETURN_STARTS], 0, 0, n_starts,
                         err) &&
           put_returns(m, 0, err) &&
           motion_scan(m, "contact_graph", RETURN_STARTS, (uint32_t)n_starts, err) &&
           put_returns(m, 1, err) && sort_rows(m, RETURN_STARTS, RETURNS, err);
}

// ---------------------------------------------------------------- contacts

static void swap(duet_motion *m, motion_buffer a, motion_buffer b)
{
    buffer other = m->buffers[a];
    m->buffers[a] = m->buffers[b];
    m->buffers[b] = other;
}

static bool empty_contacts(duet_motion *m, duet_error *err)
{
    uint64_t n = (uint64_t)m->n_contacts + 1;
    bool ok = motion_reserve(m, CONTACTS, n * m->layout.record, sizeof(float), err) &&
              motion_reserve(m, TOUCHES, n, sizeof(uint32_t), err) &&
              timeline_fill(&m->times, "contact_graph", &m->buffers[TOUCHES], 0, 0, (size_t)n, err);
    if (ok && motion_has(m, DUET_EFFECT_CONTACT_RESPONSE))
        ok = motion_reserve(m, COLOUR_OF, n, sizeof(uint32_t), err) &&
             timeline_fill(&m->times, "contact_graph", &m->buffers[COLOUR_OF], COLOUR_NONE, 0,
                           (size_t)n, err);
    return ok;
}

// As many as can begin and end: devices cannot ask for more space.
static bool reserve_events(duet_motion *m, uint32_t n_old, duet_error *err)
{
    m->event_room = (uint64_t)m->n_contacts + 2 * (uint64_t)n_old + 1;
    return !motion_has(m, DUET_EFFECT_EVENTS) ||
           motion_reserve(m, EVENTS, m->event_room, 4 * sizeof(uint32_t), err);
}

static bool match_contacts(duet_motion *m, uint32_t n_old, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, OLD_LINKS);
    args_buffer(&a, OLD_TOUCHES);
    args_buffer(&a, OLD_CONTACTS);
    args_uint(&a, n_old);
    if (motion_has(m, DUET_EFFECT_CONTACT_RESPONSE)) {
        args_buffer(&a, OLD_COLOURS);
        args_buffer(&a, COLOUR_OF);
    }
    if (motion_has(m, DUET_EFFECT_EVENTS)) {
        args_buffer(&a, EVENTS);
        args_uint(&a, (uint32_t)m->event_room);
        args_buffer(&a, FLAG_WORDS);
    }
    if (motion_has(m, DUET_EFFECT_SLEEP)) {
        args_buffer(&a, ASLEEP);
        args_uint(&a, m->n);
        args_buffer(&a, RESTS);
    }
    args_buffer(&a, STARTS);
    args_buffer(&a, OTHERS);
    args_buffer(&a, TOUCHES);
    args_buffer(&a, CONTACTS);
    return args_launch(&a, "match_contacts", m->kernels.match_contacts, n_old, err);
}

static bool make_rows(duet_motion *m, duet_error *err)
{
    duet_result result;
    uint64_t most;
    uint32_t n_old = m->n_contacts;
    swap(m, LINKS, OLD_LINKS);
    swap(m, CONTACTS, OLD_CONTACTS);
    swap(m, TOUCHES, OLD_TOUCHES);
    swap(m, COLOUR_OF, OLD_COLOURS);
    m->rebuilt = true;
    m->has_rows = true;
    return compute_fat_aabbs(m, err) && find_pairs(m, &result, err) &&
           check_capacity(m, &most, err) && send_pairs(m, &result, err) && count_rows(m, err) &&
           fill_rows(m, most, err) && fill_returns(m, err) && empty_contacts(m, err) &&
           reserve_events(m, n_old, err) && match_contacts(m, n_old, err);
}

bool motion_build_graph(duet_motion *m, duet_error *err)
{
    m->rebuilt = false;
    bool holds = false;
    if (m->has_rows && motion_has(m, DUET_EFFECT_SKIN) && !skin_holds(m, &holds, err))
        return false;
    return holds || make_rows(m, err);
}

bool motion_touch(duet_motion *m, bool woken, duet_error *err)
{
    motion_args a = args_begin(m);
    args_buffer(&a, LINKS);
    args_uint(&a, m->n_contacts);
    args_uint(&a, m->n);
    args_buffer(&a, CENTRES);
    args_cells(&a);
    args_buffer(&a, HALVES);
    args_buffer_for(&a, DUET_EFFECT_ROTATION, ROTATIONS);
    if (motion_has(m, DUET_EFFECT_BOUNDS))
        add_walls(&a);
    args_buffer_for(&a, DUET_EFFECT_CONTACT_RESPONSE, BODIES);
    if (motion_has(m, DUET_EFFECT_SLEEP)) {
        args_buffer(&a, ASLEEP);
        args_uint(&a, woken);
        args_buffer(&a, RESTS);
    }
    if (motion_has(m, DUET_EFFECT_CONTINUOUS))
        args_float(&a, m->def.dt);
    if (motion_has(m, DUET_EFFECT_EVENTS)) {
        args_buffer(&a, EVENTS);
        args_uint(&a, (uint32_t)m->event_room);
        args_buffer(&a, FLAG_WORDS);
    }
    args_float(&a, m->margin);
    args_buffer(&a, TOUCHES);
    args_buffer(&a, CONTACTS);
    return args_launch(&a, "manifolds", m->kernels.build_manifolds, m->n_contacts, err);
}

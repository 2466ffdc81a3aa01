// SPDX-License-Identifier: MIT
// What the host reads and replaces of a domain's motion between its stages.
#include "base/error.h"
#include "kernels/dynamics/border.h"
#include "runtime/dynamics/domain_commands.h"
#include "runtime/dynamics/domain_motion.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_state.h"

#include <stdlib.h>
#include <string.h>

static const char stage[] = "domain";

// ---------------------------------------------------------------- states

static const motion_buffer kept[] = {CENTRES, VELOCITIES, ROTATIONS, ANGULAR_VELOCITIES,
                                     RESTS,   ASLEEP,     CELLS};

enum { N_KEPT = sizeof kept / sizeof kept[0] };

static size_t row_bytes(const duet_motion *m, motion_buffer which)
{
    return motion_words(m, which) * sizeof(uint32_t);
}

size_t domain_state_bytes(const duet_motion *m)
{
    size_t bytes = 0;
    for (int i = 0; i < N_KEPT; ++i)
        bytes += row_bytes(m, kept[i]);
    return bytes + domain_command_bytes(m);
}

static domain_left left_of(const duet_motion *m, const char *states)
{
    const size_t all = domain_state_bytes(m);
    return (domain_left){(char *)states + all - domain_command_bytes(m), all};
}

bool domain_is_hidden(const duet_motion *m, const char *state)
{
    return domain_left_hidden(m, left_of(m, state));
}

static size_t byte_of(const duet_motion *m, motion_buffer which)
{
    size_t at = 0;
    for (int i = 0; kept[i] != which; ++i)
        at += row_bytes(m, kept[i]);
    return at;
}

// An offset, in origin cells.
void domain_centre(const duet_motion *m, const char *state, double at[3])
{
    cl_int cell[4] = {0};
    memcpy(cell, state + byte_of(m, CELLS), row_bytes(m, CELLS));
    for (int k = 0; k < 3; ++k) {
        float offset;
        double exact;
        memcpy(&offset, state + (size_t)k * sizeof offset, sizeof offset);
        memcpy(&exact, state + (size_t)k * sizeof exact, sizeof exact);
        at[k] = (m->def.doubles ? exact : (double)offset) + cell[k] * (double)m->def.origin_edge;
    }
}

// A buffer's rows lie at byte `at` of each state.
static bool read_rows(duet_motion *m, motion_buffer which, const uint32_t *places, uint32_t n,
                      char *at, duet_error *err)
{
    const size_t row = row_bytes(m, which), all = domain_state_bytes(m);
    char *rows = malloc(n * row + 1);
    if (!rows)
        return no_memory(err, "the states of %u bodies", n);
    bool ok = domain_pack_rows(m, which, NULL, places, n, rows, err);
    for (uint32_t i = 0; ok && i < n; ++i)
        memcpy(at + i * all, rows + i * row, row);
    free(rows);
    return ok;
}

bool domain_read_states(duet_motion *m, const uint32_t *places, uint32_t n, char *states,
                        duet_error *err)
{
    bool ok = domain_read_commands(m, left_of(m, states), places, n, err);
    for (int i = 0; ok && n > 0 && i < N_KEPT; ++i)
        if (row_bytes(m, kept[i]) > 0) {
            ok = read_rows(m, kept[i], places, n, states, err);
            states += row_bytes(m, kept[i]);
        }
    return ok;
}

// ---------------------------------------------------------------- contacts

bool domain_was_pushed(const duet_motion *m, const float *record, uint32_t n)
{
    bool pushed = false;
    for (uint32_t k = 0; k < n; ++k)
        pushed = pushed || record[m->layout.head + k * m->layout.point + OF_MAX_IMPULSE] > 0.0f;
    return pushed;
}

bool domain_contacts_reserve(domain_contacts *c, const duet_motion *m, bool with_records,
                             duet_error *err)
{
    size_t n = (size_t)c->n + 1, record = with_records ? m->layout.record * sizeof(float) : 0;
    c->links = malloc(n * sizeof *c->links);
    c->touches = malloc(n * sizeof *c->touches);
    c->colours = malloc(n * sizeof *c->colours);
    c->records = malloc(n * record + 1);
    return (c->links && c->touches && c->colours && c->records) ||
           no_memory(err, "%u contacts", c->n);
}

bool domain_reserve_rows(domain_contacts *c, const duet_motion *m, duet_error *err)
{
    const size_t n = (size_t)c->n + 1;
    c->touches = malloc(n * sizeof *c->touches);
    c->records = malloc(n * m->layout.record * sizeof(float));
    return (c->touches && c->records) || no_memory(err, "%u contacts", c->n);
}

static bool responds(const duet_motion *m)
{
    return m->effects & DUET_EFFECT_CONTACT_RESPONSE;
}

// Without response no contact has a colour.
static bool read_colours(duet_motion *m, cl_uint *colours, size_t n, duet_error *err)
{
    for (size_t i = 0; i < n; ++i)
        colours[i] = COLOUR_NONE;
    return !responds(m) || motion_fetch(m, stage, COLOUR_OF, 0, colours, n * sizeof *colours, err);
}

bool domain_read_contacts(duet_motion *m, bool with_records, domain_contacts *c, duet_error *err)
{
    size_t record = with_records ? m->layout.record * sizeof(float) : 0;
    *c = (domain_contacts){.n = m->n > 0 ? m->graph.n_contacts : 0};
    size_t n = c->n;
    bool ok = domain_contacts_reserve(c, m, with_records, err) &&
              (n == 0 ||
               (motion_fetch(m, stage, LINKS, 0, c->links, n * sizeof *c->links, err) &&
                motion_fetch(m, stage, TOUCHES, 0, c->touches, n * sizeof *c->touches, err) &&
                read_colours(m, c->colours, n, err) &&
                (record == 0 || motion_fetch(m, stage, CONTACTS, 0, c->records, n * record, err))));
    if (!ok)
        domain_contacts_free(c);
    return ok;
}

static bool put(duet_motion *m, motion_buffer which, const void *from, size_t n, size_t size,
                duet_error *err)
{
    return motion_reserve(m, which, n + 1, size, err) &&
           (n == 0 ||
            timeline_write_at(&m->times, stage, &m->buffers[which], 0, from, n * size, err));
}

// Writes n rows behind those that a buffer has.
static bool append(duet_motion *m, motion_buffer which, uint32_t first, const void *from, size_t n,
                   size_t size, duet_error *err)
{
    return motion_extend(m, which, first * size, (first + n + 1) * size, err) &&
           (n == 0 || timeline_write_at(&m->times, stage, &m->buffers[which], first * size, from,
                                        n * size, err));
}

void domain_drop_contacts(duet_motion *m)
{
    m->graph.n_contacts = 0;
}

// Keeps contacts that are written behind others apart from these, for both ascend by themselves.
static bool part(duet_motion *m, duet_error *err)
{
    static const cl_uint2 none = {{NO_PLACE, NO_PLACE}};
    static const cl_uint untouched = 0;
    const uint32_t last = m->graph.n_contacts;
    m->graph.n_contacts += last > 0;
    return last == 0 || (append(m, LINKS, last, &none, 1, sizeof none, err) &&
                         append(m, TOUCHES, last, &untouched, 1, sizeof untouched, err) &&
                         timeline_finish(&m->times, err));
}

static bool write_contacts(duet_motion *m, const domain_contacts *c, duet_error *err)
{
    if (!part(m, err))
        return false;
    const uint32_t first = m->graph.n_contacts;
    m->graph.n_contacts += c->n;
    if (m->graph.n_contacts > 0)
        product_renew(&m->products, PRODUCT_ROWS); // made elsewhere, of no pairs here
    return append(m, LINKS, first, c->links, c->n, sizeof *c->links, err) &&
           append(m, TOUCHES, first, c->touches, c->n, sizeof *c->touches, err) &&
           (!responds(m) ||
            append(m, COLOUR_OF, first, c->colours, c->n, sizeof *c->colours, err)) &&
           append(m, CONTACTS, first, c->records, c->n, m->layout.record * sizeof(float), err);
}

bool domain_add_contacts(duet_motion *m, const domain_contacts *c, duet_error *err)
{
    return c->n == 0 || (write_contacts(m, c, err) && timeline_finish(&m->times, err));
}

// ---------------------------------------------------------------- bodies

// Given cells are all the one that others are counted from, which is that of all domains.
static bool take_cells(duet_motion *m, uint32_t n)
{
    if (!m->cells)
        return true;
    const cl_int4 base = m->cells[0];
    cl_int4 *more = realloc(m->cells, ((size_t)n + 1) * sizeof *more);
    m->cells = more ? more : m->cells;
    for (uint32_t i = 0; more && i <= n; ++i)
        more[i] = base;
    return more;
}

static bool take_bodies(duet_motion *m, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                        duet_error *err)
{
    size_t space = (size_t)n + 1;
    duet_pose *more_poses = realloc(m->poses, space * sizeof *poses);
    m->poses = more_poses ? more_poses : m->poses;
    duet_body *more_bodies = realloc(m->bodies, space * sizeof *bodies);
    m->bodies = more_bodies ? more_bodies : m->bodies;
    if (!more_poses || !more_bodies || !take_cells(m, n))
        return no_memory(err, "%u bodies", n);
    memcpy(m->poses, poses, n * sizeof *poses);
    memcpy(m->bodies, bodies, n * sizeof *bodies);
    m->n = n;
    return true;
}

bool domain_begin_bodies(duet_motion *m, const duet_pose *poses, const duet_body *bodies,
                         uint32_t n, duet_error *err)
{
    m->products = products_of_saved(false);
    m->graph.n_contacts = 0;
    return take_bodies(m, poses, bodies, n, err) && motion_grow(m, 0, err) &&
           motion_send_places(m, NULL, n, PART_ALL, err) && timeline_finish(&m->times, err);
}

// ---------------------------------------------------------------- replaced bodies

// Rows by object that last from step to step; a step makes the others. Long ones come first: each
// moves to the memory that the one before it left.
static const motion_buffer lasting[] = {FAR_BOXES,
                                        CENTRES,
                                        CELLS,
                                        VELOCITIES,
                                        ROTATIONS,
                                        ANGULAR_VELOCITIES,
                                        INERTIAS,
                                        HALVES,
                                        SURFACE_VELOCITIES,
                                        FILTERS,
                                        RESTITUTIONS,
                                        FRICTIONS,
                                        ROLLING_RESISTANCES,
                                        MATERIALS_OF,
                                        SENSORS,
                                        RESTS,
                                        ASLEEP};

enum { N_LASTING = sizeof lasting / sizeof lasting[0] };

static bool is_in(motion_buffer which, const motion_buffer *list, int n)
{
    for (int i = 0; i < n; ++i)
        if (list[i] == which)
            return true;
    return false;
}

static bool grow_others(duet_motion *m, duet_error *err)
{
    bool ok = true;
    for (int which = 0; ok && which < MOTION_BUFFERS; ++which)
        ok = is_in((motion_buffer)which, lasting, N_LASTING) ||
             motion_grow_rows(m, (motion_buffer)which, 0, err);
    return ok;
}

// A row of the state is part of a body's state, and a given row is what its pose and body say.
static void fill_fresh(duet_motion *m, motion_buffer which, const domain_bodies *b, char *rows)
{
    const size_t row = row_bytes(m, which), all = domain_state_bytes(m);
    if (which == FAR_BOXES)
        memcpy(rows, b->far_boxes, b->n_fresh * row);
    else if (!is_in(which, kept, N_KEPT))
        motion_fill_given(m, which, b->fresh, b->n_fresh, rows);
    else
        for (uint32_t i = 0; i < b->n_fresh; ++i)
            memcpy(rows + i * row, b->states + i * all + byte_of(m, which), row);
}

// Rows of fresh bodies go one buffer after the other, each from memory of its own, and their places
// with the first.
static bool write_fresh(duet_motion *m, motion_buffer which, const domain_bodies *b, char *rows,
                        bool is_first, duet_error *err)
{
    const domain_ids ids = {b->fresh, b->n_fresh, READ_IDS, 0, !is_first};
    fill_fresh(m, which, b, rows);
    return domain_unpack_listed(m, which, NULL, &ids, rows, err);
}

static size_t lasting_bytes(const duet_motion *m)
{
    size_t bytes = 0;
    for (int i = 0; i < N_LASTING; ++i)
        bytes += row_bytes(m, lasting[i]);
    return bytes;
}

static bool write_all_fresh(duet_motion *m, const domain_bodies *b, duet_error *err)
{
    bool ok = true, is_first = true;
    char *rows = calloc((size_t)b->n_fresh + 1, lasting_bytes(m)), *next = rows;
    if (!rows)
        return no_memory(err, "%u bodies", b->n_fresh);
    for (int i = 0; ok && b->n_fresh > 0 && i < N_LASTING; ++i) {
        const size_t row = row_bytes(m, lasting[i]);
        if (row == 0)
            continue;
        ok = write_fresh(m, lasting[i], b, next, is_first, err);
        next += row * b->n_fresh;
        is_first = false;
    }
    ok = domain_await_rows(m, err) && ok; // rows are freed
    free(rows);
    return ok;
}

// The end of the rows from i on that follow each other before and after.
static uint32_t end_of_run(const domain_bodies *b, uint32_t i)
{
    uint32_t end = i + 1;
    while (end < b->n && b->from[i] != NO_PLACE && b->from[end] == b->from[end - 1] + 1)
        ++end;
    return end;
}

static uint32_t begin_of_run(const domain_bodies *b, uint32_t end)
{
    uint32_t first = end - 1;
    while (first > 0 && b->from[first] != NO_PLACE && b->from[first] > 0 &&
           b->from[first - 1] == b->from[first] - 1)
        --first;
    return first;
}

static void move_run(const domain_bodies *b, char *rows, size_t row, uint32_t first, uint32_t end)
{
    memmove(rows + first * row, rows + b->from[first] * row, (end - first) * row);
}

// Rows that come nearer to the front are moved from there on, and the others from the end on: so
// none lies where another one still is to be read.
void domain_splice(const domain_bodies *b, void *rows, const void *fresh_rows, size_t row)
{
    for (uint32_t first = 0, end; first < b->n; first = end) {
        end = end_of_run(b, first);
        if (b->from[first] != NO_PLACE && b->from[first] > first)
            move_run(b, rows, row, first, end);
    }
    for (uint32_t first, end = b->n; end > 0; end = first) {
        first = begin_of_run(b, end);
        if (b->from[first] < first) // NO_PLACE is not
            move_run(b, rows, row, first, end);
    }
    for (uint32_t k = 0; k < b->n_fresh; ++k)
        memcpy((char *)rows + b->fresh[k] * row, (const char *)fresh_rows + k * row, row);
}

static bool grow_bodies(duet_motion *m, uint32_t n)
{
    const size_t space = (size_t)(n > m->n ? n : m->n) + 1;
    duet_pose *poses = realloc(m->poses, space * sizeof *poses);
    m->poses = poses ? poses : m->poses;
    duet_body *bodies = realloc(m->bodies, space * sizeof *bodies);
    m->bodies = bodies ? bodies : m->bodies;
    return poses && bodies && take_cells(m, n);
}

static bool own_bodies(duet_motion *m, const domain_bodies *b, duet_error *err)
{
    if (!grow_bodies(m, b->n))
        return no_memory(err, "%u bodies", b->n);
    domain_splice(b, m->poses, b->poses, sizeof *m->poses);
    domain_splice(b, m->bodies, b->bodies, sizeof *m->bodies);
    m->n = b->n;
    return true;
}

bool domain_replace_bodies(duet_motion *m, const domain_bodies *b, const domain_contacts *c,
                           duet_error *err)
{
    m->products = products_of_saved(false);
    altered_forget(&m->altered);
    motion_forget_events(&m->told);
    return own_bodies(m, b, err) && domain_take_commands(m, left_of(m, b->states), err) &&
           domain_move_rows(m, lasting, N_LASTING, b->from, b->n + FIXED, err) &&
           grow_others(m, err) && write_all_fresh(m, b, err) &&
           domain_take_forces(m, left_of(m, b->states), err) &&
           (!(m->effects & DUET_EFFECT_CONTACT) || write_contacts(m, c, err)) &&
           timeline_finish(&m->times, err);
}

void domain_set_carrier(duet_motion *m, uint32_t place)
{
    m->ground.carrier = place;
}

// ---------------------------------------------------------------- rows to be saved

// Rows of contacts, and of those that a body that moves is the other of.
typedef struct contact_rows {
    cl_uint *starts, *others, *return_starts, *returns;
} contact_rows;

static void free_rows(contact_rows *r)
{
    free(r->starts);
    free(r->others);
    free(r->return_starts);
    free(r->returns);
}

static bool reserve_rows(contact_rows *r, size_t n, size_t n_contacts, duet_error *err)
{
    r->starts = calloc(n + 2, sizeof *r->starts);
    r->return_starts = calloc(n + 2, sizeof *r->return_starts);
    r->others = calloc(n_contacts + 1, sizeof *r->others);
    r->returns = calloc(n_contacts + 1, sizeof *r->returns);
    return (r->starts && r->return_starts && r->others && r->returns) ||
           no_memory(err, "the rows of %zu contacts", n_contacts);
}

static bool returns(const duet_motion *m, uint32_t other)
{
    return other < m->n && m->bodies[other].mass > 0.0f;
}

// Starts lie one further on until rows are filled.
static void fill_rows(const duet_motion *m, const domain_contacts *c, contact_rows *r)
{
    for (uint32_t i = 0; i < c->n; ++i) {
        r->others[i] = c->links[i].s[1];
        ++r->starts[c->links[i].s[0] + 1];
        if (returns(m, r->others[i]))
            ++r->return_starts[r->others[i] + 2];
    }
    for (uint32_t id = 0; id < m->n; ++id) {
        r->starts[id + 1] += r->starts[id];
        r->return_starts[id + 2] += r->return_starts[id + 1];
    }
    for (uint32_t i = 0; i < c->n; ++i)
        if (returns(m, r->others[i]))
            r->returns[r->return_starts[r->others[i] + 1]++] = i;
}

static bool write_rows_of(duet_motion *m, const domain_contacts *c, const contact_rows *r,
                          duet_error *err)
{
    size_t n = (size_t)m->n + 1, word = sizeof(cl_uint);
    return put(m, STARTS, r->starts, n, word, err) && put(m, OTHERS, r->others, c->n, word, err) &&
           put(m, RETURN_STARTS, r->return_starts, n, word, err) &&
           put(m, RETURNS, r->returns, c->n, word, err) && timeline_finish(&m->times, err);
}

static uint32_t count_pairs(const duet_motion *m, const domain_contacts *c)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < c->n; ++i)
        n += c->links[i].s[1] < m->n;
    return n;
}

static bool lay_rows(duet_motion *m, const domain_contacts *c, duet_error *err)
{
    contact_rows r = {0};
    m->graph.n_without = 0;
    bool ok = reserve_rows(&r, m->n, c->n, err);
    if (ok) {
        fill_rows(m, c, &r);
        ok = write_rows_of(m, c, &r, err);
    }
    free_rows(&r);
    m->graph.n_pairs = count_pairs(m, c);
    m->products = products_of_saved(true);
    motion_alter_all(m);
    return ok;
}

bool domain_lay_rows(duet_motion *m, duet_error *err)
{
    domain_contacts c;
    if (!(m->effects & DUET_EFFECT_CONTACT) || m->n == 0)
        return true;
    if (!domain_read_contacts(m, false, &c, err))
        return false;
    bool ok = lay_rows(m, &c, err);
    domain_contacts_free(&c);
    return ok;
}

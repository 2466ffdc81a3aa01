// SPDX-License-Identifier: MIT
// What the host reads and replaces of a domain's motion between its stages.
#include "base/error.h"
#include "runtime/dynamics/domain_motion.h"
#include "runtime/dynamics/motion_commands.h"

#include <stdlib.h>
#include <string.h>

static const char stage[] = "domain";

// ---------------------------------------------------------------- states

static const motion_buffer kept[] = {CENTRES, VELOCITIES, ROTATIONS, ANGULAR_VELOCITIES,
                                     RESTS,   ASLEEP};

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
    return bytes;
}

size_t domain_rest_at(const duet_motion *m)
{
    size_t at = 0;
    for (int i = 0; kept[i] != RESTS; ++i)
        at += row_bytes(m, kept[i]);
    return at;
}

static char *rows_of_all(const duet_motion *m, motion_buffer which, duet_error *err)
{
    char *rows = malloc(m->n * row_bytes(m, which) + 1);
    if (!rows)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for the states of %u bodies", m->n);
    return rows;
}

// A buffer's rows lie at byte `at` of each state.
static bool read_rows(duet_motion *m, motion_buffer which, char *at, duet_error *err)
{
    size_t row = row_bytes(m, which), all = domain_state_bytes(m);
    char *rows = rows_of_all(m, which, err);
    bool ok = rows && motion_fetch(m, stage, which, 0, rows, m->n * row, err);
    for (uint32_t i = 0; ok && i < m->n; ++i)
        memcpy(at + i * all, rows + i * row, row);
    free(rows);
    return ok;
}

static bool write_rows(duet_motion *m, motion_buffer which, const char *at, duet_error *err)
{
    size_t row = row_bytes(m, which), all = domain_state_bytes(m);
    char *rows = rows_of_all(m, which, err);
    for (uint32_t i = 0; rows && i < m->n; ++i)
        memcpy(rows + i * row, at + i * all, row);
    bool ok = rows &&
              timeline_write_at(&m->times, stage, &m->buffers[which], 0, rows, m->n * row, err) &&
              timeline_finish(&m->times, err);
    free(rows);
    return ok;
}

bool domain_read_states(duet_motion *m, char *states, duet_error *err)
{
    bool ok = true;
    for (int i = 0; ok && m->n > 0 && i < N_KEPT; ++i)
        if (row_bytes(m, kept[i]) > 0) {
            ok = read_rows(m, kept[i], states, err);
            states += row_bytes(m, kept[i]);
        }
    return ok;
}

static bool write_states(duet_motion *m, const char *states, duet_error *err)
{
    bool ok = true;
    for (int i = 0; ok && m->n > 0 && i < N_KEPT; ++i)
        if (row_bytes(m, kept[i]) > 0) {
            ok = write_rows(m, kept[i], states, err);
            states += row_bytes(m, kept[i]);
        }
    return ok;
}

bool domain_read_asleep(duet_motion *m, cl_uint *asleep, duet_error *err)
{
    memset(asleep, 0, m->n * sizeof *asleep);
    return m->n == 0 || !(m->effects & DUET_EFFECT_SLEEP) ||
           motion_fetch(m, stage, ASLEEP, 0, asleep, m->n * sizeof *asleep, err);
}

// ---------------------------------------------------------------- contacts

bool domain_was_pushed(const duet_motion *m, const float *record, uint32_t n)
{
    bool pushed = false;
    for (uint32_t k = 0; k < n; ++k)
        pushed = pushed || record[m->layout.head + k * m->layout.point + OF_MAX_IMPULSE] > 0.0f;
    return pushed;
}

void domain_contacts_free(domain_contacts *c)
{
    free(c->links);
    free(c->touches);
    free(c->colours);
    free(c->records);
    *c = (domain_contacts){0};
}

static bool reserve(domain_contacts *c, size_t record, duet_error *err)
{
    size_t n = (size_t)c->n + 1;
    c->links = malloc(n * sizeof *c->links);
    c->touches = malloc(n * sizeof *c->touches);
    c->colours = malloc(n * sizeof *c->colours);
    c->records = malloc(n * record + 1);
    return (c->links && c->touches && c->colours && c->records) ||
           error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u contacts", c->n);
}

bool domain_read_contacts(duet_motion *m, bool with_records, domain_contacts *c, duet_error *err)
{
    size_t record = with_records ? m->layout.record * sizeof(float) : 0;
    *c = (domain_contacts){.n = m->n > 0 ? m->graph.n_contacts : 0};
    size_t n = c->n;
    bool ok = reserve(c, record, err) &&
              (n == 0 ||
               (motion_fetch(m, stage, LINKS, 0, c->links, n * sizeof *c->links, err) &&
                motion_fetch(m, stage, TOUCHES, 0, c->touches, n * sizeof *c->touches, err) &&
                motion_fetch(m, stage, COLOUR_OF, 0, c->colours, n * sizeof *c->colours, err) &&
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

static bool write_contacts(duet_motion *m, const domain_contacts *c, duet_error *err)
{
    m->graph.n_contacts = c->n;
    return put(m, LINKS, c->links, c->n, sizeof *c->links, err) &&
           put(m, TOUCHES, c->touches, c->n, sizeof *c->touches, err) &&
           put(m, COLOUR_OF, c->colours, c->n, sizeof *c->colours, err) &&
           put(m, CONTACTS, c->records, c->n, m->layout.record * sizeof(float), err);
}

// ---------------------------------------------------------------- bodies

static bool take_bodies(duet_motion *m, const duet_pose *poses, const duet_body *bodies, uint32_t n,
                        duet_error *err)
{
    size_t space = (size_t)n + 1;
    duet_pose *more_poses = realloc(m->poses, space * sizeof *poses);
    m->poses = more_poses ? more_poses : m->poses;
    duet_body *more_bodies = realloc(m->bodies, space * sizeof *bodies);
    m->bodies = more_bodies ? more_bodies : m->bodies;
    if (!more_poses || !more_bodies)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u bodies", n);
    memcpy(m->poses, poses, n * sizeof *poses);
    memcpy(m->bodies, bodies, n * sizeof *bodies);
    m->n = n;
    return true;
}

bool domain_replace_bodies(duet_motion *m, const duet_pose *poses, const duet_body *bodies,
                           const char *states, uint32_t n, const domain_contacts *c,
                           duet_error *err)
{
    m->products = products_of_saved(false);
    return take_bodies(m, poses, bodies, n, err) && motion_grow(m, 0, err) &&
           motion_send_places(m, NULL, n, PART_ALL, err) && write_states(m, states, err) &&
           (!(m->effects & DUET_EFFECT_CONTACT_RESPONSE) || write_contacts(m, c, err)) &&
           timeline_finish(&m->times, err);
}

// ---------------------------------------------------------------- rows to be saved

static bool clear_records(duet_motion *m, duet_error *err)
{
    const motion_layout *l = &m->layout;
    domain_contacts c;
    if (!domain_read_contacts(m, true, &c, err))
        return false;
    for (uint32_t i = 0; i < c.n; ++i) {
        uint32_t points = c.touches[i] & TOUCH_POINTS;
        uint32_t used = points > 0 ? l->head + points * l->point : 0;
        memset(c.records + (size_t)i * l->record + used, 0, (l->record - used) * sizeof(float));
    }
    bool ok = put(m, CONTACTS, c.records, c.n, l->record * sizeof(float), err) &&
              timeline_finish(&m->times, err);
    domain_contacts_free(&c);
    return ok;
}

// Contacts with what never moves have none.
static bool clear_returns(duet_motion *m, duet_error *err)
{
    cl_uint n = 0;
    return motion_fetch(m, stage, RETURN_STARTS, m->n * sizeof n, &n, sizeof n, err) &&
           motion_clear(m, stage, RETURNS, n, m->graph.n_contacts, err);
}

bool domain_settle_rows(duet_motion *m, duet_error *err)
{
    return !(m->effects & DUET_EFFECT_CONTACT_RESPONSE) || m->n == 0 ||
           (domain_make_rows(m, err) && clear_returns(m, err) && clear_records(m, err));
}

bool domain_forget_commands(duet_motion *m)
{
    motion_commands *c = m->commands;
    bool acts = c && (c->n_hidden > 0 || c->n_targets > 0 || c->n_pushed > 0);
    if (acts)
        return false;
    motion_forget_commands(c);
    m->commands = NULL;
    return true;
}

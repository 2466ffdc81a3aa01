// SPDX-License-Identifier: MIT
// Contacts that a domain's host looks at: the device finds and lists them, so that what the host
// does goes with what lies at the borders, and not with all contacts.
#include "base/error.h"
#include "kernels/dynamics/border.h"
#include "runtime/dynamics/domain_motion.h"

#include <stdlib.h>
#include <string.h>

static const char stage[] = "domain";

void domain_contacts_free(domain_contacts *c)
{
    free(c->rows);
    free(c->links);
    free(c->touches);
    free(c->colours);
    free(c->records);
    *c = (domain_contacts){0};
}

// A row of the device's list.
typedef struct border_row {
    cl_uint row, owner, other, colour;
} border_row;

bool domain_mark_places(duet_motion *m, const domain_place *places, duet_error *err)
{
    const size_t n = (size_t)m->n + FIXED;
    return motion_reserve(m, PLACES_OF, n, sizeof *places, err) &&
           timeline_write_at(&m->times, stage, &m->buffers[PLACES_OF], 0, places,
                             n * sizeof *places, err) &&
           timeline_finish(&m->times, err);
}

// No body has chosen a contact.
static bool clear_choices(duet_motion *m, duet_error *err)
{
    return timeline_fill(&m->times, stage, &m->buffers[CHOICES], UINT32_MAX, 0, m->n, err);
}

// ---------------------------------------------------------------- the list

// Reads how many the list has, and the flags.
static bool count_listed(duet_motion *m, uint32_t listed, cl_uint *n, duet_error *err)
{
    const uint32_t all = m->graph.n_contacts;
    buffer *starts = &m->buffers[BORDER_STARTS];
    m->border.listed = listed;
    return motion_reserve(m, BORDER_STARTS, (uint64_t)all + 1, sizeof(cl_uint), err) &&
           motion_launch(m, COUNT_BORDER, err) &&
           scan_run(&m->graph.scan, &m->times, stage, starts, starts, all + 1, err) &&
           motion_read_flags(m, err) &&
           motion_fetch(m, stage, BORDER_STARTS, all * sizeof *n, n, sizeof *n, err);
}

static bool reserve(domain_contacts *c, duet_error *err)
{
    const size_t n = (size_t)c->n + 1;
    c->rows = malloc(n * sizeof *c->rows);
    c->links = malloc(n * sizeof *c->links);
    c->colours = malloc(n * sizeof *c->colours);
    return (c->rows && c->links && c->colours) || no_memory(err, "%u contacts", c->n);
}

static void take(domain_contacts *c, const border_row *rows)
{
    for (uint32_t i = 0; i < c->n; ++i) {
        c->rows[i] = rows[i].row;
        c->links[i] = (cl_uint2){{rows[i].owner, rows[i].other}};
        c->colours[i] = rows[i].colour;
    }
}

// Lists so many contacts on the device.
static bool list(duet_motion *m, uint32_t n, duet_error *err)
{
    return n == 0 || (motion_reserve(m, BORDER, n, sizeof(border_row), err) &&
                      motion_launch(m, LIST_BORDER, err));
}

static bool fetch(duet_motion *m, domain_contacts *c, duet_error *err)
{
    const size_t bytes = c->n * sizeof(border_row);
    border_row *rows = malloc(bytes + 1);
    if (!rows)
        no_memory(err, "%u contacts", c->n);
    bool ok = rows && reserve(c, err) && list(m, c->n, err) &&
              (c->n == 0 || motion_fetch(m, stage, BORDER, 0, rows, bytes, err));
    if (ok)
        take(c, rows);
    free(rows);
    return ok;
}

static bool list_for_host(duet_motion *m, uint32_t listed, domain_contacts *c, duet_error *err)
{
    *c = (domain_contacts){0};
    bool ok = (m->n == 0 || m->graph.n_contacts == 0 || count_listed(m, listed, &c->n, err)) &&
              fetch(m, c, err);
    if (!ok)
        domain_contacts_free(c);
    return ok;
}

bool domain_list_waiting(duet_motion *m, domain_contacts *c, duet_error *err)
{
    return list_for_host(m, LISTED_WAITING, c, err);
}

bool domain_list_shared(duet_motion *m, domain_contacts *c, duet_error *err)
{
    return list_for_host(m, LISTED_SHARED, c, err);
}

bool domain_list_sent(duet_motion *m, domain_contacts *c, duet_error *err)
{
    return list_for_host(m, LISTED_SENT, c, err);
}

bool domain_list_ghosts(duet_motion *m, uint32_t *n, duet_error *err)
{
    return count_listed(m, LISTED_GHOSTS, n, err) && list(m, *n, err);
}

// ---------------------------------------------------------------- colours

bool domain_mark_border(duet_motion *m, duet_error *err)
{
    return m->n == 0 || m->graph.n_contacts == 0 ||
           (clear_choices(m, err) && motion_launch(m, MARK_BORDER, err));
}

// ---------------------------------------------------------------- contacts that stay

bool domain_keep_contacts(duet_motion *m, const uint32_t *moved, duet_error *err)
{
    const size_t n = (size_t)m->n + FIXED;
    return motion_reserve(m, MOVED_TO, n, sizeof *moved, err) &&
           timeline_write_at(&m->times, stage, &m->buffers[MOVED_TO], 0, moved, n * sizeof *moved,
                             err) &&
           motion_launch(m, KEEP_CONTACTS, err) && timeline_finish(&m->times, err);
}

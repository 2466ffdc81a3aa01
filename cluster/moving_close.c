// SPDX-License-Identifier: MIT
// Contacts of two ghosts that a domain solves, too, so that ghosts come less often (closure.h). The
// others are left at home, and are not solved here until they are as at home again.
#include "cluster/moving_domains.h"

#include "base/error.h"

typedef LIST_OF(border_contact, contacts) border_list;

// ---------------------------------------------------------------- left at home

static int compare(const void *left, const void *right)
{
    const left_contact *a = left, *b = right;
    if (a->owner != b->owner)
        return a->owner < b->owner ? -1 : 1;
    return a->other < b->other ? -1 : a->other > b->other;
}

bool moving_is_left(const moving_domain *d, uint32_t owner, uint32_t other)
{
    const left_contact key = {owner, other};
    return d->left.n > 0 && bsearch(&key, d->left.contacts, d->left.n, sizeof key, compare) != NULL;
}

// Notes a contact of two ghosts that is not solved here; one that pushes nothing stays as it is.
// Rows ascend, as ids do.
static void note_left(const moving *m, moving_domain *d, uint32_t row, left_list *now)
{
    const uint32_t *ends = d->told.links[row].s;
    const left_contact one = {moving_id(m, d, ends[0]), moving_id(m, d, ends[1])};
    if (d->told.colours[row] != COLOUR_NONE || moving_is_left(d, one.owner, one.other))
        list_add(&now->list, &one, 1, sizeof one);
    d->told.colours[row] = COLOUR_NONE;
}

// ---------------------------------------------------------------- near borders

static uint32_t ghost_of(const moving_domain *d, uint32_t place)
{
    return moving_is_ghost(d, place) ? d->ghost_at[place] : CLOSURE_NONE;
}

static void list_border(const moving_domain *d, border_list *border)
{
    for (uint64_t i = 0; i < d->border.n; ++i) {
        const uint32_t row = d->border.rows[i], *ends = d->told.links[row].s;
        const border_contact one = {.ghosts = {ghost_of(d, ends[0]), ghost_of(d, ends[1])},
                                    .colour = d->told.colours[row],
                                    .row = row,
                                    .is_solved = moving_decides_contact(d, ends)};
        if (one.colour <= COLOUR_OVERFLOW)
            list_add(&border->list, &one, 1, sizeof one);
    }
}

static bool has_solved(const ghost_colours *ghosts, uint32_t ghost)
{
    return ghost != CLOSURE_NONE && ghosts[ghost].here != 0;
}

// Both ghosts of a contact are watched if another one is solved of either.
static void watch(moving *m, const moving_domain *d, uint32_t row)
{
    ghost_colours *ghosts = m->halo.received.colours;
    const uint32_t *ends = d->told.links[row].s;
    const uint32_t both[2] = {ghost_of(d, ends[0]), ghost_of(d, ends[1])};
    bool watched = has_solved(ghosts, both[0]) || has_solved(ghosts, both[1]);
    for (int k = 0; watched && k < 2; ++k)
        if (both[k] != CLOSURE_NONE)
            ghosts[both[k]].watched = 1;
}

// Contacts of the list come as rows do.
static void leave_contacts(moving *m, moving_domain *d, const border_contact *list, uint64_t n,
                           duet_error *own)
{
    left_list now = {0};
    uint64_t at = 0;
    for (uint64_t i = 0; i < d->border.n; ++i) {
        const uint32_t row = d->border.rows[i];
        bool is_solved = at < n && list[at].row == row && list[at].is_solved;
        at += at < n && list[at].row == row;
        watch(m, d, row);
        if (!is_solved && !moving_decides_contact(d, d->told.links[row].s))
            note_left(m, d, row, &now);
    }
    if (now.failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "contacts of ghosts: no memory");
    free(d->left.contacts);
    d->left = now;
}

static void close_all(moving *m, const border_list *border, const uint64_t *first, duet_error *own)
{
    closure c = {.every = m->every,
                 .ghosts = m->halo.received.colours,
                 .n_ghosts = m->halo.received.items.n,
                 .contacts = border->contacts,
                 .n_contacts = border->n};
    bool ok = closure_find(&c, own);
    for (uint32_t k = 0; ok && m->every > 1 && k < m->parts; ++k)
        leave_contacts(m, &m->domains[k], border->contacts + first[k], first[k + 1] - first[k],
                       own);
}

uint32_t moving_get_every(const moving *m)
{
    return m->every;
}

// Ghosts lie deeper for more colours, and contacts of two of them are as at home after an exchange.
bool moving_set_every(moving *m, uint32_t every, duet_error *own)
{
    bool is_new = m->every != every;
    m->every = every;
    return !is_new || m->n_domains == 1 || moving_settle(m, own);
}

void moving_close(moving *m, duet_error *own)
{
    border_list border = {0};
    uint64_t *first = calloc((size_t)m->parts + 1, sizeof *first);
    for (uint32_t k = 0; first && k < m->parts; ++k) {
        list_border(&m->domains[k], &border);
        first[k + 1] = border.n;
    }
    if (!first || border.failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "the contacts at a border: no memory");
    if (is_well(own))
        close_all(m, &border, first, own);
    free(border.contacts);
    free(first);
}

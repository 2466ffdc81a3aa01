// SPDX-License-Identifier: MIT
// Colours over all domains: each finds those that its own contacts decide. The others wait, and
// ranks colour them together (waiting.h).
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "cluster/waiting.h"

#include <inttypes.h>

// ---------------------------------------------------------------- one domain

// Whether a contact that begins to push may be solved here: of two ghosts, only as at home.
static bool may_wait(const moving *m, const moving_domain *d, const uint32_t ends[2])
{
    return moving_decides_contact(d, ends) ||
           (m->every > 1 && !moving_is_left(d, moving_id(m, d, ends[0]), moving_id(m, d, ends[1])));
}

static void note_used(moving_domain *d, uint32_t i)
{
    const uint32_t *ends = d->told.links[i].s;
    for (int k = 0; k < 2; ++k)
        if (d->places[ends[k]].kind & PLACE_MOVES)
            d->used[ends[k]] |= 1u << d->told.colours[i];
}

// The device lets all that begins to push wait.
static void list_told(const moving *m, moving_domain *d)
{
    list_clear(&d->border.list);
    list_clear(&d->waiting.list);
    for (uint32_t i = 0; i < d->told.n; ++i) {
        const uint32_t *ends = d->told.links[i].s;
        uint32_t *colour = &d->told.colours[i];
        if (moving_is_ghost(d, ends[0]) || moving_is_ghost(d, ends[1]))
            row_list_add(&d->border, i);
        if (*colour == COLOUR_WAITS && !may_wait(m, d, ends))
            *colour = COLOUR_NONE;
        if (*colour == COLOUR_WAITS)
            row_list_add(&d->waiting, i);
    }
}

// The bodies whose colours others are told of: those that are ghosts elsewhere, and ends of what
// waits.
static void list_used(const moving *m, const moving_domain *d, row_list *places)
{
    const halo_item *sent = m->halo.sent.items.items;
    for (uint64_t i = 0; i < m->halo.sent.items.n; ++i)
        if (&m->domains[sent[i].domain] == d)
            row_list_add(places, sent[i].place);
    for (uint64_t i = 0; i < d->waiting.n; ++i)
        for (int k = 0; k < 2; ++k) {
            const uint32_t place = d->told.links[d->waiting.rows[i]].s[k];
            if (d->places[place].kind & PLACE_MOVES)
                row_list_add(places, place);
        }
}

static void read_used(const moving *m, moving_domain *d, duet_error *own)
{
    row_list places = {0};
    list_used(m, d, &places);
    uint32_t *used = malloc((places.n + 1) * sizeof *used);
    if (!used || places.failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "colours: no memory");
    else if (domain_read_used(d->motion, places.rows, (uint32_t)places.n, used, own))
        for (uint64_t i = 0; i < places.n; ++i)
            d->used[places.rows[i]] = used[i];
    free(places.rows);
    free(used);
}

// The colours that an end has, if all its contacts are here.
static uint32_t used_of(const moving_domain *d, uint32_t place)
{
    return moving_decides_at(d, place) ? d->used[place] : 0;
}

static void list_waiting(const moving *m, const moving_domain *d, waiting_list *waiting)
{
    for (uint64_t i = 0; i < d->waiting.n; ++i) {
        const uint32_t *ends = d->told.links[d->waiting.rows[i]].s;
        const waiting_contact one = {.owner = moving_id(m, d, ends[0]),
                                     .other = moving_id(m, d, ends[1]),
                                     .other_moves = (d->places[ends[1]].kind & PLACE_MOVES) != 0,
                                     .owner_used = used_of(d, ends[0]),
                                     .other_used = used_of(d, ends[1]),
                                     .colour = COLOUR_WAITS,
                                     .is_decided_here = 1};
        if (moving_decides_contact(d, ends))
            list_add(&waiting->list, &one, 1, sizeof one);
    }
}

// Lists the contacts that wait for other domains, once this one has coloured all that it can.
static void wait_for_colours(const moving *m, moving_domain *d, waiting_list *waiting,
                             duet_error *own)
{
    domain_contacts_free(&d->told);
    if (!domain_colour_inner(d->motion, &d->told, own))
        return;
    list_told(m, d);
    if (d->border.failed || d->waiting.failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "colours: no memory");
    else
        read_used(m, d, own);
    if (is_well(own))
        list_waiting(m, d, waiting);
}

// ---------------------------------------------------------------- all domains

typedef struct telling {
    const waiting_list *waiting;
    uint64_t n_ranks;
} telling;

static int listener_of(const void *context, uint64_t i)
{
    return (int)(i % ((const telling *)context)->n_ranks);
}

static void write_waiting(const void *context, uint64_t i, void *row)
{
    const telling *t = context;
    memcpy(row, &t->waiting->contacts[i / t->n_ranks], sizeof(waiting_contact));
}

// Every rank learns of all ranks' waiting contacts.
static bool tell_all(moving *m, const waiting_list *waiting, parcels *all, duet_error *own)
{
    const telling t = {waiting, (uint64_t)m->ranks->n};
    if (is_well(own) && waiting->failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "contacts that wait for colours: no memory");
    const parcels_def out = {.n = waiting->n * t.n_ranks,
                             .row_bytes = sizeof(waiting_contact),
                             .write = write_waiting,
                             .rank_of = listener_of,
                             .context = &t};
    return parcels_deal(m->ranks, is_well(own), &out, all, own);
}

// A contact of two ghosts that does not wait at home waits on: its colour is not known here.
static void take_colours(const moving *m, moving_domain *d, const waiting_contact *waiting,
                         uint64_t n)
{
    for (uint64_t i = 0; i < d->waiting.n; ++i) {
        const uint32_t row = d->waiting.rows[i], *ends = d->told.links[row].s;
        uint32_t found =
            colouring_find(waiting, n, moving_id(m, d, ends[0]), moving_id(m, d, ends[1]));
        if (found == COLOUR_NONE)
            continue;
        d->told.colours[row] = found;
        note_used(d, row);
    }
}

// A contact is counted by the domain whose own its owner is: those of others are among what the
// host looks at.
static void count(const moving_domain *d, tally *t)
{
    const contact_solver *s = &d->motion->solver;
    uint64_t n = s->n_pushing, colours = 0;
    for (uint32_t k = 0; k <= COLOUR_OVERFLOW; ++k)
        colours = s->colours[k].count > 0 ? k + 1 : colours;
    for (uint32_t i = 0; i < d->told.n; ++i)
        n -= d->told.colours[i] < COLOUR_WAITS &&
             !(d->places[d->told.links[i].s[0]].kind & PLACE_OWN);
    t->sums[0] += n;
    t->greatest[0] = t->greatest[0] > (double)colours ? t->greatest[0] : (double)colours;
}

// ---------------------------------------------------------------- without a colour

static void add_in_order(const moving *m, const moving_domain *d, const domain_contacts *c,
                         waiting_list *list)
{
    for (uint32_t i = 0; i < c->n; ++i) {
        const waiting_contact one = {.owner = moving_id(m, d, c->links[i].s[0]),
                                     .other = moving_id(m, d, c->links[i].s[1])};
        if (c->colours[i] == COLOUR_OVERFLOW)
            list_add(&list->list, &one, 1, sizeof one);
    }
}

static void note_in_order(const moving *m, moving_domain *d, const domain_contacts *c,
                          const waiting_contact *all, uint64_t n, duet_error *own)
{
    list_clear(&d->in_order.list);
    for (uint32_t i = 0; i < c->n; ++i)
        if (c->colours[i] == COLOUR_OVERFLOW)
            row_list_add(&d->in_order,
                         (uint32_t)colouring_place(all, n, moving_id(m, d, c->links[i].s[0]),
                                                   moving_id(m, d, c->links[i].s[1])));
    if (d->in_order.failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "contacts in order: no memory");
}

// All ranks learn which contacts are solved in order, and each domain where its own lie among them.
static bool order_contacts(moving *m, duet_error *own)
{
    waiting_list list = {0};
    parcels all = {0};
    for (uint32_t k = 0; k < m->parts; ++k)
        add_in_order(m, &m->domains[k], &m->domains[k].told, &list);
    bool ok = tell_all(m, &list, &all, own);
    m->n_in_order = ok ? colouring_sort(all.rows, all.n) : 0;
    for (uint32_t k = 0; ok && is_well(own) && k < m->parts; ++k)
        note_in_order(m, &m->domains[k], &m->domains[k].told, all.rows, m->n_in_order, own);
    free(list.contacts);
    parcels_end(&all);
    return ok;
}

// ---------------------------------------------------------------- all of it

static bool end_colouring(moving *m, tally *t, duet_error *own)
{
    if (!ranks_agree_and(m->ranks, is_well(own), t, own))
        return false;
    m->counts.colours = (uint32_t)t->greatest[0];
    m->counts.contacts = t->sums[0];
    m->n_in_order = 0;
    return m->counts.colours <= COLOUR_OVERFLOW || order_contacts(m, own);
}

// All domains' own contacts have colours: finds which others are solved here, and gives them to the
// motions.
static bool give_colours(moving *m, duet_error *own)
{
    tally t = {.sums = {0}};
    halo_tell_home(&m->halo, m);
    if (is_well(own))
        moving_close(m, own);
    halo_ask(&m->halo, m, own);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
        moving_domain *d = &m->domains[k];
        if (domain_take_colours(d->motion, &d->told, own))
            count(d, &t);
    }
    return end_colouring(m, &t, own);
}

bool moving_colour(moving *m, duet_error *own)
{
    waiting_list waiting = {0};
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        wait_for_colours(m, &m->domains[k], &waiting, own);
    bool ok = waiting_colour(m, &waiting, own);
    for (uint32_t k = 0; ok && is_well(own) && k < m->parts; ++k)
        take_colours(m, &m->domains[k], waiting.contacts, waiting.n);
    ok = ok && give_colours(m, own);
    free(waiting.contacts);
    return ok;
}

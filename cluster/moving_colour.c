// SPDX-License-Identifier: MIT
// Colours over all domains: each finds those that its own contacts decide. The others wait, and
// ranks colour them together (waiting.h).
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "cluster/waiting.h"

#include <inttypes.h>

// ---------------------------------------------------------------- one domain

// The bodies that waiting contacts have.
static void list_ends(const moving_domain *d, row_list *places)
{
    for (uint64_t i = 0; i < d->waiting.n; ++i)
        for (int k = 0; k < 2; ++k) {
            const uint32_t place = d->told.links[d->waiting.rows[i]].s[k];
            if (d->places[place].kind & PLACE_MOVES)
                row_list_add(places, place);
        }
}

// Returns the colours of their contacts, in that order, to be freed.
static uint32_t *read_used(const moving_domain *d, duet_error *own)
{
    row_list places = {0};
    list_ends(d, &places);
    uint32_t *used = malloc((places.n + 1) * sizeof *used);
    if (!used || places.failed)
        no_memory(own, "colours");
    else
        domain_read_used(d->motion, places.rows, (uint32_t)places.n, used, own);
    free(places.rows);
    return used;
}

// The colours that an end has, if all its contacts are here. Takes the next of a body that moves.
static uint32_t take_used(const moving_domain *d, uint32_t place, const uint32_t **used)
{
    const uint32_t colours = d->places[place].kind & PLACE_MOVES ? *(*used)++ : 0;
    return moving_decides_at(d, place) ? colours : 0;
}

static void list_waiting(const moving *m, const moving_domain *d, const uint32_t *used,
                         waiting_list *waiting)
{
    for (uint64_t i = 0; i < d->waiting.n; ++i) {
        const uint32_t *ends = d->told.links[d->waiting.rows[i]].s;
        const uint32_t owner_used = take_used(d, ends[0], &used),
                       other_used = take_used(d, ends[1], &used);
        const waiting_contact one = {.owner = moving_id(m, d, ends[0]),
                                     .other = moving_id(m, d, ends[1]),
                                     .other_moves = (d->places[ends[1]].kind & PLACE_MOVES) != 0,
                                     .owner_used = owner_used,
                                     .other_used = other_used,
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
    list_clear(&d->waiting.list);
    if (!domain_colour_inner(d->motion, m->every, &d->told, own))
        return;
    for (uint32_t i = 0; i < d->told.n; ++i)
        if (d->told.colours[i] == COLOUR_WAITS)
            row_list_add(&d->waiting, i);
    if (d->waiting.failed) {
        no_memory(own, "colours");
        return;
    }
    uint32_t *used = read_used(d, own);
    if (is_well(own))
        list_waiting(m, d, used, waiting);
    free(used);
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
        no_memory(own, "contacts that wait for colours");
    const parcels_def out = {.n = waiting->n * t.n_ranks,
                             .row_bytes = sizeof(waiting_contact),
                             .write = write_waiting,
                             .rank_of = listener_of,
                             .context = &t};
    return parcels_deal(m->ranks, is_well(own), &out, all, own);
}

// A contact of two ghosts that does not wait at home was left there: its colour is not known here.
static void take_colours(const moving *m, moving_domain *d, const waiting_contact *waiting,
                         uint64_t n)
{
    for (uint64_t i = 0; i < d->waiting.n; ++i) {
        const uint32_t row = d->waiting.rows[i], *ends = d->told.links[row].s;
        uint32_t found =
            colouring_find(waiting, n, moving_id(m, d, ends[0]), moving_id(m, d, ends[1]));
        d->told.colours[row] = found <= COLOUR_OVERFLOW ? found : COLOUR_LEFT | COLOUR_NONE;
    }
}

// A contact is counted by the domain whose own its owner is.
static void count(const moving_domain *d, const domain_closed *closed, tally *t)
{
    const contact_solver *s = &d->motion->solver;
    uint64_t colours = 0;
    for (uint32_t k = 0; k <= COLOUR_OVERFLOW; ++k)
        colours = s->colours[k].count > 0 ? k + 1 : colours;
    t->sums[0] += s->n_pushing - closed->n_foreign;
    t->sums[1] += closed->n_mistaken;
    t->greatest[0] = t->greatest[0] > (double)colours ? t->greatest[0] : (double)colours;
}

// ---------------------------------------------------------------- without a colour

static void add_in_order(const moving *m, const moving_domain *d, const domain_contacts *c,
                         waiting_list *list)
{
    for (uint32_t i = 0; i < c->n; ++i) {
        const waiting_contact one = {.owner = moving_id(m, d, c->links[i].s[0]),
                                     .other = moving_id(m, d, c->links[i].s[1])};
        if (c->colours[i] == COLOUR_OVERFLOW && moving_decides_contact(d, c->links[i].s))
            list_add(&list->list, &one, 1, sizeof one);
    }
}

static void note_in_order(const moving *m, moving_domain *d, const domain_contacts *c,
                          const waiting_contact *all, uint64_t n, duet_error *own)
{
    list_clear(&d->in_order.list);
    for (uint32_t i = 0; i < c->n; ++i)
        if (c->colours[i] == COLOUR_OVERFLOW && moving_decides_contact(d, c->links[i].s))
            row_list_add(&d->in_order,
                         (uint32_t)colouring_place(all, n, moving_id(m, d, c->links[i].s[0]),
                                                   moving_id(m, d, c->links[i].s[1])));
    if (d->in_order.failed)
        no_memory(own, "contacts in order");
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

static void list_colours(const moving *m, moving_domain *d, tally *t, duet_error *own)
{
    domain_closed closed;
    if (domain_count_closed(d->motion, &closed, own) &&
        domain_take_colours(d->motion, m->least_inner, own))
        count(d, &closed, t);
}

// Finds which contacts of ghosts are solved here, and lists contacts by colour.
static bool close_all(moving *m, tally *t, duet_error *own)
{
    *t = (tally){0};
    moving_enter(m, PHASE_CLOSURE);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        domain_close(m->domains[k].motion, m->every, own);
    halo_ask(&m->halo, m, own);
    if (!halo_bring_asked(&m->halo, m, own))
        return false;
    moving_enter(m, PHASE_LISTS);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        list_colours(m, &m->domains[k], t, own);
    return ranks_agree_and(m->ranks, is_well(own), t, own);
}

// All domains' own contacts have colours. Contacts that came instead of those that were meant are
// known from now on, so that few rounds end it.
static bool give_colours(moving *m, duet_error *own)
{
    tally t = {.sums = {0, 1}};
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        domain_write_colours(m->domains[k].motion, &m->domains[k].told, own);
    halo_tell_home(&m->halo, m, own);
    while (t.sums[1] > 0)
        if (!close_all(m, &t, own))
            return false;
    m->counts.colours = (uint32_t)t.greatest[0];
    m->counts.contacts = t.sums[0];
    m->n_in_order = 0;
    return m->counts.colours <= COLOUR_OVERFLOW || order_contacts(m, own);
}

bool moving_colour(moving *m, duet_error *own)
{
    waiting_list waiting = {0};
    moving_enter(m, PHASE_COLOURS);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        wait_for_colours(m, &m->domains[k], &waiting, own);
    moving_enter(m, PHASE_WAITING);
    bool ok = waiting_colour(m, &waiting, own);
    for (uint32_t k = 0; ok && is_well(own) && k < m->parts; ++k)
        take_colours(m, &m->domains[k], waiting.contacts, waiting.n);
    moving_enter(m, PHASE_CLOSURE);
    ok = ok && give_colours(m, own);
    free(waiting.contacts);
    return ok;
}

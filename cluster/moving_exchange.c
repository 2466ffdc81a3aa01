// SPDX-License-Identifier: MIT
// Bodies, contacts and ghosts go to the domains where the next step needs them.
#include "cluster/moving_domains.h"

#include "base/compare.h"
#include "base/error.h"
#include "runtime/bodies/ground_def.h"

static item_list *came_of(moving_domain *d)
{
    return &d->came;
}

static item_list *contacts_of(moving_domain *d)
{
    return &d->contacts;
}

// ---------------------------------------------------------------- own bodies

bool moving_migrate(moving *m, item_list *bodies, duet_error *own)
{
    for (uint64_t i = 0; !bodies->failed && i < bodies->n; ++i) {
        moving_traveller *t = moving_traveller_at(m, bodies, i);
        t->body.own = t->domain;
    }
    bool ok = moving_deal(m, bodies, m->traveller_bytes, came_of, own);
    for (uint32_t k = 0; k < m->parts; ++k)
        m->domains[k].n_came_own = m->domains[k].came.n;
    return ok;
}

// ---------------------------------------------------------------- ghosts

// The ground goes with its carrier, so all domains have that.
static bool is_ghost_of(const moving *m, const moving_traveller *t, const extent *box, uint32_t to)
{
    return extents_meet(box, &m->reaches[to]) || t->body.id + 1 == ground_def_carrier(&m->def);
}

static void add_ghosts_of(moving *m, const moving_domain *d, const moving_traveller *t,
                          item_list *out)
{
    const extent box = extent_of_box(t->far_box);
    for (uint32_t to = 0; to < m->n_domains; ++to) {
        if (to == d->number || !is_ghost_of(m, t, &box, to))
            continue;
        list_add(out, t, 1, m->traveller_bytes);
        if (!out->failed)
            moving_traveller_at(m, out, out->n - 1)->domain = to;
        halo_add(&m->halo.sent.items, &(halo_item){.rank = to / m->parts,
                                                   .to = to,
                                                   .from = d->number,
                                                   .id = t->body.id,
                                                   .domain = d->number % m->parts});
    }
}

static bool stays(const moving_domain *d, uint32_t place)
{
    return d->gone.n == 0 ||
           !bsearch(&place, d->gone.rows, d->gone.n, sizeof *d->gone.rows, compare_uint32);
}

// Own bodies that stay and are near to others, of those that the device lists, and the ground's
// carrier.
static void choose_staying(const moving *m, const moving_domain *d, const domain_near *near,
                           uint32_t n, row_list *places)
{
    const uint32_t carrier = moving_carrier_place(m, d);
    for (uint32_t i = 0; i < n; ++i)
        if (near[i].place != carrier && stays(d, near[i].place))
            row_list_add(places, near[i].place);
    if (carrier != UINT32_MAX && moving_owns(d, carrier) && stays(d, carrier))
        row_list_add(places, carrier);
    row_list_sort(places);
}

static void list_staying(const moving *m, const moving_domain *d, row_list *places, duet_error *own)
{
    float(*extents)[6] = malloc(m->n_domains * sizeof *extents);
    domain_near *near = NULL;
    uint32_t n = 0, n_extents = 0;
    if (!extents)
        no_memory(own, "%u domains", m->n_domains);
    for (uint32_t k = 0; extents && k < m->n_domains; ++k)
        if (k != d->number && extent_widest(&m->reaches[k]) >= 0.0)
            moving_round_extent(m, &m->reaches[k], false, extents[n_extents++]);
    if (is_well(own) && domain_list_meeting(d->motion, extents[0], n_extents, &near, &n, own))
        choose_staying(m, d, near, n, places);
    free(extents);
    free(near);
}

static void send_ghosts(moving *m, moving_domain *d, item_list *out, duet_error *own)
{
    row_list places = {0};
    item_list rows = {0};
    if (!moving_all_travel(m) && d->bodies.n > 0)
        list_staying(m, d, &places, own);
    moving_read_bodies(m, d, &places, &rows, own);
    for (uint64_t i = 0; is_well(own) && !rows.failed && i < rows.n; ++i)
        add_ghosts_of(m, d, moving_traveller_at(m, &rows, i), out);
    for (uint64_t i = 0; is_well(own) && i < d->n_came_own; ++i)
        add_ghosts_of(m, d, moving_traveller_at(m, &d->came, i), out);
    if (rows.failed)
        no_memory(own, "ghosts");
    free(places.rows);
    free(rows.items);
}

static void note_ghosts(moving *m)
{
    m->n_ghosts = 0;
    for (uint32_t k = 0; k < m->parts; ++k) {
        const moving_domain *d = &m->domains[k];
        for (uint64_t i = d->n_came_own; i < d->came.n; ++i) {
            const moving_body *b = &moving_traveller_at(m, &d->came, i)->body;
            halo_add(&m->halo.received.items, &(halo_item){.rank = b->own / m->parts,
                                                           .to = d->number,
                                                           .from = b->own,
                                                           .id = b->id,
                                                           .domain = k});
            ++m->n_ghosts;
        }
    }
}

static bool exchange_ghosts(moving *m, duet_error *own)
{
    item_list out = {0};
    halo_clear(&m->halo);
    if (!moving_find_reaches(m, own))
        return false;
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        send_ghosts(m, &m->domains[k], &out, own);
    m->counts.sent += out.n;
    bool ok = moving_deal(m, &out, m->traveller_bytes, came_of, own);
    if (ok && is_well(own))
        note_ghosts(m);
    free(out.items);
    return ok;
}

// ---------------------------------------------------------------- places

// If contacts of two ghosts are solved, too, their colours are told, by who has them as own ones.
static void mark_places(moving *m, duet_error *own)
{
    const halo_item *sent = m->halo.sent.items.items;
    const uint32_t bits = m->every > 1 ? PLACE_SENT | PLACE_SHARED : PLACE_SENT;
    for (uint64_t i = 0; i < m->halo.sent.items.n; ++i)
        m->domains[sent[i].domain].places[sent[i].place].kind |= bits;
    for (uint32_t k = 0; is_well(own) && moving_touches(m) && k < m->parts; ++k)
        domain_mark_places(m->domains[k].motion, m->domains[k].places, own);
}

// They are long, and here only while they are exchanged.
static void forget_travellers(moving_domain *d)
{
    free(d->came.items);
    d->came = (item_list){0};
    d->n_came_own = 0;
    list_clear(&d->gone.list);
}

bool moving_exchange(moving *m, item_list *bodies, item_list *contacts, duet_error *own)
{
    m->counts.sent += bodies->n;
    moving_enter(m, PHASE_TRAVEL);
    bool ok = moving_migrate(m, bodies, own);
    if (ok && moving_touches(m))
        ok =
            moving_deal(m, contacts, m->contact_bytes, contacts_of, own) && exchange_ghosts(m, own);
    moving_enter(m, PHASE_REPLACE);
    for (uint32_t k = 0; ok && is_well(own) && k < m->parts; ++k) {
        moving_replace(m, &m->domains[k], own);
        forget_travellers(&m->domains[k]);
    }
    moving_enter(m, PHASE_SHARE);
    ok = ok && halo_settle(&m->halo, m, own);
    if (ok && is_well(own))
        mark_places(m, own);
    ok = ok && moving_share_contacts(m, own);
    if (ok)
        moving_note_touching(m, own);
    tally t = {.sums = {m->n_ghosts}};
    ok = ok && ranks_agree_and(m->ranks, is_well(own), &t, own);
    m->counts.ghosts = t.sums[0];
    return ok;
}

// SPDX-License-Identifier: MIT
// A motion over ranks as a file: the saved motion (docs/formats.md) of all bodies in the order of
// their ids, so that its bytes are the same for any number of ranks, and any number goes on from
// it; and as one motion on rank 0.
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "cluster/parcels.h"

// ---------------------------------------------------------------- to rank 0

static bool gather(moving *m, const item_list *rows, size_t bytes, parcels *in, duet_error *own)
{
    const parcels_def out = {.n = rows->n, .row_bytes = bytes, .rows = rows->items};
    if (is_well(own) && rows->failed)
        no_memory(own, "rows that are saved");
    return parcels_deal(m->ranks, is_well(own), &out, in, own);
}

static void list_bodies(moving *m, moving_domain *d, item_list *bodies, duet_error *own)
{
    row_list places = {0};
    for (uint64_t i = 0; i < d->bodies.n; ++i)
        if (moving_is_own(d, &d->bodies.rows[i]))
            row_list_add(&places, (uint32_t)i);
    moving_read_bodies(m, d, &places, bodies, own);
    free(places.rows);
}

// An end that is far away now, and that of a contact which is none any more, is not here.
static void list_travelled(const moving *m, const moving_domain *d, item_list *contacts)
{
    for (uint64_t i = 0; i < d->contacts.n; ++i) {
        const moving_contact *c = moving_contact_at(m, &d->contacts, i);
        if (moving_owns(d, moving_place(d, c->owner)))
            list_add(contacts, c, 1, m->contact_bytes);
    }
}

static bool is_kept(const moving_domain *d, const domain_contacts *c, uint32_t i)
{
    const uint32_t owner = c->links[i].s[0];
    return owner != NO_PLACE && (d->places[owner].kind & PLACE_OWN) &&
           (c->touches[i] & TOUCH_POINTS);
}

// Lists the contacts in the motion; some of them have travelled, too.
static void list_kept(const moving *m, const moving_domain *d, item_list *contacts, duet_error *own)
{
    domain_contacts all;
    moving_contact *row = malloc(m->contact_bytes);
    if (!row)
        no_memory(own, "contacts that are saved");
    if (row && domain_read_contacts(d->motion, true, &all, own)) {
        for (uint32_t i = 0; i < all.n; ++i) {
            if (!is_kept(d, &all, i))
                continue;
            moving_write_contact(m, d, &all, i, row);
            list_add(contacts, row, 1, m->contact_bytes);
        }
        domain_contacts_free(&all);
    }
    free(row);
}

static void list_own(moving *m, item_list *bodies, item_list *contacts, duet_error *own)
{
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
        moving_domain *d = &m->domains[k];
        list_bodies(m, d, bodies, own);
        list_travelled(m, d, contacts);
        if (moving_touches(m) && !moving_sends_all(m))
            list_kept(m, d, contacts, own);
    }
}

// ---------------------------------------------------------------- on rank 0

// The rows are the domain's from now on, which orders them in memory of its own.
static item_list take_rows(parcels *p)
{
    item_list rows = {.items = p->rows, .n = p->n};
    p->rows = NULL;
    return rows;
}

// A motion of all bodies, as if it had made the steps.
static duet_motion *make_whole(moving *m, parcels *bodies, parcels *contacts, duet_error *own)
{
    moving_domain whole = {
        .motion = moving_create(m, own),
        .came = take_rows(bodies),
        .contacts = take_rows(contacts),
    };
    if (whole.motion)
        moving_replace(m, &whole, own);
    if (whole.motion && is_well(own))
        domain_lay_rows(whole.motion, own);
    moving_end_domain(&whole);
    return whole.motion;
}

bool moving_gather(moving *m, duet_motion **whole, duet_error *own)
{
    item_list bodies = {0}, contacts = {0};
    parcels all_bodies = {0}, all_contacts = {0};
    *whole = NULL;
    if (!moving_settle(m, own))
        return false;
    list_own(m, &bodies, &contacts, own);
    bool ok = gather(m, &bodies, m->traveller_bytes, &all_bodies, own) &&
              gather(m, &contacts, m->contact_bytes, &all_contacts, own);
    if (ok && is_well(own) && m->ranks->self == 0)
        *whole = make_whole(m, &all_bodies, &all_contacts, own);
    free(bodies.items);
    free(contacts.items);
    parcels_end(&all_bodies);
    parcels_end(&all_contacts);
    return ok;
}

bool moving_save(moving *m, const char *path, duet_error *own)
{
    duet_motion *whole;
    bool ok = moving_gather(m, &whole, own);
    if (ok && is_well(own) && whole)
        duet_motion_save(whole, path, own);
    duet_motion_destroy(whole);
    return ok && ranks_agree(m->ranks, is_well(own), own);
}

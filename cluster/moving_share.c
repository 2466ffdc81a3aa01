// SPDX-License-Identifier: MIT
// If contacts of two ghosts are solved here, too, they come with their bits once bodies were
// exchanged: from the domain whose own their first end that moves is, where the device lists them.
#include "cluster/moving_domains.h"

#include "base/error.h"

// ---------------------------------------------------------------- those that go

// Items ascend by the domain of this rank, and then by place.
static int compare_visits(const void *left, const void *right)
{
    const halo_item *a = left, *b = right;
    if (a->domain != b->domain)
        return a->domain < b->domain ? -1 : 1;
    return a->place < b->place ? -1 : a->place > b->place;
}

// A contact goes where its first end that moves is a ghost: the other one is there, too, or it is
// dropped.
static void send_contact(const moving *m, const moving_domain *d, const item_list *visits,
                         moving_contact *row, const uint32_t ends[2], item_list *out)
{
    const uint32_t place = ends[d->places[ends[0]].kind & PLACE_MOVES ? 0 : 1],
                   domain = d->number % m->parts;
    const halo_item key = {.domain = domain, .place = place}, *v = visits->items;
    for (uint64_t k = list_find(visits, sizeof key, &key, compare_visits);
         k < visits->n && v[k].domain == domain && v[k].place == place; ++k) {
        row->domain = v[k].to;
        list_add(out, row, 1, m->contact_bytes);
    }
}

static void list_sent(const moving *m, moving_domain *d, const item_list *visits, item_list *out,
                      duet_error *own)
{
    domain_contacts c = {0};
    moving_contact *row = malloc(m->contact_bytes);
    if (!row)
        no_memory(own, "contacts of ghosts");
    bool ok = row && domain_list_sent(d->motion, &c, own) &&
              domain_reserve_rows(&c, d->motion, own) && domain_read_rows(d->motion, &c, own);
    for (uint32_t i = 0; ok && i < c.n; ++i) {
        moving_write_contact(m, d, &c, i, row);
        send_contact(m, d, visits, row, c.links[i].s, out);
    }
    domain_contacts_free(&c);
    free(row);
}

static void list_all(moving *m, item_list *out, duet_error *own)
{
    item_list visits = {0};
    list_append(&visits, &m->halo.sent.items, sizeof(halo_item));
    if (visits.failed)
        no_memory(own, "contacts of ghosts");
    else if (visits.n > 0)
        qsort(visits.items, visits.n, sizeof(halo_item), compare_visits);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        list_sent(m, &m->domains[k], &visits, out, own);
    free(visits.items);
}

// ---------------------------------------------------------------- those that came

static void add_contact(const moving *m, const moving_domain *d, const moving_contact *c,
                        domain_contacts *to)
{
    const uint32_t owner = moving_place(d, c->owner), other = moving_end_place(m, d, c->other);
    if (owner != UINT32_MAX && other != UINT32_MAX &&
        !moving_decides_contact(d, (uint32_t[]){owner, other}))
        moving_put_contact(m, c, owner, other, to);
}

// Contacts of one sender ascend.
static void add_shared(const moving *m, moving_domain *d, duet_error *own)
{
    domain_contacts all = {.n = (uint32_t)d->shared.n};
    if (!moving_order_contacts(m, &d->shared))
        no_memory(own, "contacts of ghosts");
    else if (domain_contacts_reserve(&all, d->motion, true, own)) {
        all.n = 0;
        for (uint64_t i = 0; i < d->shared.n; ++i)
            add_contact(m, d, moving_contact_at(m, &d->shared, i), &all);
        domain_add_contacts(d->motion, &all, own);
    }
    domain_contacts_free(&all);
    free(d->shared.items);
    d->shared = (item_list){0};
}

// ---------------------------------------------------------------- all of it

static item_list *shared_of(moving_domain *d)
{
    return &d->shared;
}

bool moving_share_contacts(moving *m, duet_error *own)
{
    item_list out = {0};
    if (m->every == 1 || !moving_pushes(m))
        return true;
    list_all(m, &out, own);
    m->counts.shared += out.n;
    bool ok = moving_deal(m, &out, m->contact_bytes, shared_of, own);
    for (uint32_t k = 0; ok && is_well(own) && k < m->parts; ++k)
        add_shared(m, &m->domains[k], own);
    free(out.items);
    return ok;
}

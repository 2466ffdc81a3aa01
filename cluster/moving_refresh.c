// SPDX-License-Identifier: MIT
// Contacts that a step solved at home alone, and that the next one may need here, come with their
// bits: those of ghosts of which other contacts are solved here. Both sides know how many these
// are.
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "cluster/parcels.h"

// A contact that is sent, or that came.
typedef struct fresh_contact {
    uint64_t at;                         // in the order in which they travel
    uint32_t domain, row, place, colour; // the row is that of what the host was told of
} fresh_contact;

typedef LIST_OF(fresh_contact, contacts) fresh_list;

static const halo_item *sent_item(const moving *m, uint64_t i)
{
    return (const halo_item *)m->halo.sent.items.items + i;
}

// The colours of a ghost's contacts that are not solved where it is one.
static uint32_t colours_left(const ghost_colours *c)
{
    const uint32_t all = (1u << CLOSURE_COLOURS) - 1;
    return c->watched ? c->at_home & ~c->here & all : 0;
}

// ---------------------------------------------------------------- which are sent

static int by_place(const void *left, const void *right)
{
    const fresh_contact *a = left, *b = right;
    const uint32_t keys[][2] = {
        {a->domain, b->domain}, {a->place, b->place}, {a->colour, b->colour}};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i)
        if (keys[i][0] != keys[i][1])
            return keys[i][0] < keys[i][1] ? -1 : 1;
    return 0;
}

static int by_row(const void *left, const void *right)
{
    const fresh_contact *a = left, *b = right;
    if (a->domain != b->domain)
        return a->domain < b->domain ? -1 : 1;
    return a->row < b->row ? -1 : a->row > b->row;
}

static void sort(fresh_list *list, int (*compare)(const void *, const void *))
{
    if (list->n > 0)
        qsort(list->contacts, list->n, sizeof *list->contacts, compare);
}

static void list_sent(const moving *m, fresh_list *list, parcels *out)
{
    for (uint64_t i = 0; i < m->halo.sent.items.n; ++i) {
        const halo_item *item = sent_item(m, i);
        uint32_t colours = colours_left(&m->halo.sent.colours[i]);
        for (uint32_t k = 0; k < CLOSURE_COLOURS; ++k) {
            const fresh_contact one = {
                .at = list->n, .domain = item->domain, .place = item->place, .colour = k};
            if (!(colours >> k & 1u))
                continue;
            list_add(&list->list, &one, 1, sizeof one);
            ++out->counts[item->rank];
        }
    }
}

// A body has one contact of a colour, which may go to several domains.
static void note_row(fresh_list *list, const fresh_contact *key)
{
    fresh_contact *found = bsearch(key, list->contacts, list->n, sizeof *found, by_place);
    while (found && found > list->contacts && by_place(found - 1, key) == 0)
        --found;
    for (; found && found < list->contacts + list->n && by_place(found, key) == 0; ++found)
        found->row = key->row;
}

static void find_rows(const moving *m, fresh_list *list)
{
    sort(list, by_place);
    for (uint32_t k = 0; list->n > 0 && k < m->parts; ++k) {
        const domain_contacts *c = &m->domains[k].told;
        for (uint32_t i = 0; i < c->n; ++i)
            for (int end = 0; c->colours[i] < CLOSURE_COLOURS && end < 2; ++end)
                note_row(list, &(fresh_contact){.domain = k,
                                                .row = i,
                                                .place = c->links[i].s[end],
                                                .colour = c->colours[i]});
    }
    sort(list, by_row);
}

// ---------------------------------------------------------------- contacts of a domain

// Contacts of one domain, of those that travel.
typedef struct batch {
    const fresh_contact *list;
    domain_contacts all;
} batch;

// The next contacts of one domain, from `from` on.
static bool begin_batch(const moving *m, const fresh_list *list, uint64_t from, batch *b,
                        duet_error *own)
{
    const fresh_contact *one = &list->contacts[from];
    uint32_t n = 1;
    while (from + n < list->n && one[n].domain == one->domain)
        ++n;
    const moving_domain *d = &m->domains[one->domain];
    *b = (batch){.list = one, .all = {.n = n, .rows = malloc(n * sizeof *b->all.rows)}};
    if (!domain_contacts_reserve(&b->all, d->motion, true, own) || !b->all.rows)
        return error_set(own, DUET_STATUS_NO_MEMORY, "contacts of ghosts: no memory");
    for (uint32_t i = 0; i < n; ++i) {
        b->all.rows[i] = d->told.rows[one[i].row];
        b->all.links[i] = d->told.links[one[i].row];
    }
    return true;
}

static char *record_at(const moving *m, const batch *b, uint32_t i)
{
    return (char *)b->all.records + i * (m->contact_bytes - sizeof(moving_contact));
}

static void write_out(const moving *m, const batch *b, char *rows)
{
    const moving_domain *d = &m->domains[b->list->domain];
    for (uint32_t i = 0; i < b->all.n; ++i)
        moving_write_contact(m, d, &b->all, i, (void *)(rows + b->list[i].at * m->contact_bytes));
}

static void fill(moving *m, const fresh_list *list, parcels *out, duet_error *own)
{
    for (uint64_t from = 0; is_well(own) && from < list->n;) {
        batch b;
        bool ok = begin_batch(m, list, from, &b, own) &&
                  domain_read_rows(m->domains[b.list->domain].motion, &b.all, own);
        if (ok)
            write_out(m, &b, out->rows);
        from += b.all.n > 0 ? b.all.n : 1;
        domain_contacts_free(&b.all);
    }
}

// ---------------------------------------------------------------- those that came

static uint32_t row_of(const moving *m, const moving_domain *d, const moving_contact *c)
{
    const uint32_t n = (uint32_t)d->bodies.n, owner = moving_place(d, c->owner);
    const uint32_t other =
        c->other >= m->n_all ? n + (c->other - m->n_all) : moving_place(d, c->other);
    uint32_t low = 0, high = d->told.n;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        const uint32_t *at = d->told.links[middle].s;
        if (at[0] < owner || (at[0] == owner && at[1] < other))
            low = middle + 1;
        else
            high = middle;
    }
    bool found =
        low < d->told.n && d->told.links[low].s[0] == owner && d->told.links[low].s[1] == other;
    return found ? low : UINT32_MAX;
}

// The contacts that came, of which rows are here.
static void list_received(const moving *m, const parcels *in, fresh_list *list)
{
    uint64_t at = 0;
    for (uint64_t i = 0; i < m->halo.received.items.n; ++i) {
        const halo_item *item = (const halo_item *)m->halo.received.items.items + i;
        uint32_t n = (uint32_t)__builtin_popcount(colours_left(&m->halo.received.colours[i]));
        for (; n > 0; --n, ++at) {
            const void *row = (const char *)in->rows + at * m->contact_bytes;
            const fresh_contact one = {
                .at = at, .domain = item->domain, .row = row_of(m, &m->domains[item->domain], row)};
            if (one.row != UINT32_MAX)
                list_add(&list->list, &one, 1, sizeof one);
        }
    }
    sort(list, by_row);
}

static void read_in(const moving *m, const char *rows, batch *b)
{
    const size_t record = m->contact_bytes - sizeof(moving_contact);
    for (uint32_t i = 0; i < b->all.n; ++i) {
        moving_contact head;
        const char *from = rows + b->list[i].at * m->contact_bytes;
        memcpy(&head, from, sizeof head);
        memcpy(record_at(m, b, i), from + sizeof head, record);
        b->all.touches[i] = head.touch;
        b->all.colours[i] = head.colour;
    }
}

// Contacts that came are left no more; both lists ascend as rows do.
static void forget_left(const moving *m, moving_domain *d, const batch *b)
{
    uint64_t kept = 0;
    uint32_t at = 0;
    for (uint64_t i = 0; i < d->left.n; ++i) {
        const left_contact one = d->left.contacts[i];
        bool came = false;
        for (; at < b->all.n && !came; at += !came) {
            const uint32_t *ends = b->all.links[at].s;
            uint32_t owner = moving_id(m, d, ends[0]), other = moving_id(m, d, ends[1]);
            came = owner == one.owner && other == one.other;
            if (owner > one.owner || (owner == one.owner && other > one.other))
                break;
        }
        if (!came)
            d->left.contacts[kept++] = one;
    }
    d->left.n = kept;
}

static void take(moving *m, const fresh_list *list, const parcels *in, duet_error *own)
{
    for (uint64_t from = 0; is_well(own) && from < list->n;) {
        batch b;
        if (begin_batch(m, list, from, &b, own)) {
            read_in(m, in->rows, &b);
            if (domain_write_rows(m->domains[b.list->domain].motion, &b.all, own))
                forget_left(m, &m->domains[b.list->domain], &b);
        }
        from += b.all.n > 0 ? b.all.n : 1;
        domain_contacts_free(&b.all);
    }
}

// ---------------------------------------------------------------- all of it

bool moving_refresh(moving *m, duet_error *own)
{
    fresh_list sent = {0}, received = {0};
    parcels out = {0}, in = {0};
    if (m->every == 1)
        return true;
    if (is_well(own) && parcels_begin(&out, m->ranks, (uint32_t)m->contact_bytes, own)) {
        list_sent(m, &sent, &out);
        if (sent.failed)
            error_set(own, DUET_STATUS_NO_MEMORY, "contacts of ghosts: no memory");
        else if (parcels_reserve(&out, m->ranks, NULL, own))
            find_rows(m, &sent);
    }
    if (is_well(own))
        fill(m, &sent, &out, own);
    bool ok = parcels_exchange(m->ranks, is_well(own), &out, &in, own);
    if (ok)
        list_received(m, &in, &received);
    if (received.failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "contacts of ghosts: no memory");
    if (ok && is_well(own))
        take(m, &received, &in, own);
    free(sent.contacts);
    free(received.contacts);
    parcels_end(&out);
    parcels_end(&in);
    return ok;
}

// SPDX-License-Identifier: MIT
// Bodies, contacts and ghosts go to the domains where the next step needs them.
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "cluster/parcels.h"

// ---------------------------------------------------------------- rows that travel

typedef struct dealing {
    const moving *m;
    const item_list *rows;
    size_t bytes; // of a row, which begins with the domain that it goes to
} dealing;

static uint32_t row_domain(const void *row)
{
    uint32_t domain;
    memcpy(&domain, row, sizeof domain);
    return domain;
}

static int rank_of(const void *context, uint64_t i)
{
    const dealing *d = context;
    return (int)(row_domain((const char *)d->rows->items + i * d->bytes) / d->m->parts);
}

static void write_row(const void *context, uint64_t i, void *row)
{
    const dealing *d = context;
    memcpy(row, (const char *)d->rows->items + i * d->bytes, d->bytes);
}

typedef item_list *list_of_domain(moving_domain *d);

// Sends each row to its domain, and adds those that came to their domains' lists.
static bool deal(moving *m, item_list *rows, size_t bytes, list_of_domain *list, duet_error *own)
{
    const dealing d = {m, rows, bytes};
    parcels in = {0};
    if (is_well(own) && rows->failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "rows that travel: no memory");
    bool ok = parcels_deal(m->ranks, is_well(own), (uint32_t)bytes, rows->n, rank_of, write_row, &d,
                           &in, own);
    for (uint64_t i = 0; ok && i < in.n; ++i) {
        const char *row = (const char *)in.rows + i * bytes;
        list_add(list(&m->domains[row_domain(row) % m->parts]), row, 1, bytes);
    }
    for (uint32_t k = 0; ok && k < m->parts; ++k)
        if (list(&m->domains[k])->failed)
            error_set(own, DUET_STATUS_NO_MEMORY, "rows of a domain: no memory");
    parcels_end(&in);
    return ok;
}

static item_list *bodies_of(moving_domain *d)
{
    return &d->bodies;
}

static item_list *contacts_of(moving_domain *d)
{
    return &d->contacts;
}

// ---------------------------------------------------------------- own bodies

void moving_add_coming(const moving *m, const moving_body *b, uint32_t domain, item_list *out)
{
    list_add(out, b, 1, m->body_bytes);
    if (out->failed)
        return;
    moving_body *last = moving_body_at(m, out, out->n - 1);
    last->domain = domain;
    last->at = NO_PLACE;
}

// Ghosts go, and own bodies that another domain's box holds are sent there.
static void leave(moving *m, moving_domain *d, item_list *out)
{
    uint64_t kept = 0;
    for (uint64_t i = 0; i < d->bodies.n; ++i) {
        moving_body *b = moving_body_at(m, &d->bodies, i);
        if (!moving_is_own(d, b))
            continue;
        b->domain = b->own = moving_domain_of(m, b);
        if (!moving_is_own(d, b))
            moving_add_coming(m, b, b->domain, out);
        else
            memmove(moving_body_at(m, &d->bodies, kept++), b, m->body_bytes);
    }
    d->bodies.n = kept;
}

bool moving_migrate(moving *m, duet_error *own)
{
    item_list out = {0};
    for (uint32_t k = 0; k < m->parts; ++k)
        leave(m, &m->domains[k], &out);
    bool ok = deal(m, &out, m->body_bytes, bodies_of, own);
    for (uint32_t k = 0; k < m->parts; ++k)
        m->domains[k].n_own = (uint32_t)m->domains[k].bodies.n;
    free(out.items);
    return ok;
}

// ---------------------------------------------------------------- ghosts

// The bounds of a domain's own bodies that act: only these have contacts that change or tell
// something.
static extent reach_of(const moving *m, const moving_domain *d)
{
    extent reach = extent_none;
    for (uint64_t i = 0; i < d->bodies.n; ++i) {
        const moving_body *b = moving_body_at(m, &d->bodies, i);
        const double lower[3] = {b->bounds[0], b->bounds[1], b->bounds[2]};
        const double upper[3] = {b->bounds[3], b->bounds[4], b->bounds[5]};
        if (!b->acts)
            continue;
        extent_add(&reach, lower);
        extent_add(&reach, upper);
    }
    return reach;
}

// Ghosts lie so many bodies deep: a contact of colour k needs at most k others, one behind the
// other, and hardly ever more than some.
static double layers_of(const moving *m)
{
    const double most = 6.0;
    return lesser(m->every - 1.0, most);
}

static void add_ghosts_of(moving *m, const moving_domain *d, const moving_body *b, item_list *out)
{
    const extent box = {{b->bounds[0], b->bounds[1], b->bounds[2]},
                        {b->bounds[3], b->bounds[4], b->bounds[5]}};
    for (uint32_t to = 0; to < m->n_domains; ++to) {
        if (to == d->number || !extents_meet(&box, &m->reaches[to]))
            continue;
        moving_add_coming(m, b, to, out);
        halo_add(&m->halo.sent.items, &(halo_item){.rank = to / m->parts,
                                                   .to = to,
                                                   .from = d->number,
                                                   .id = b->id,
                                                   .domain = d->number % m->parts});
    }
}

static void note_ghosts(moving *m)
{
    m->n_ghosts = 0;
    for (uint32_t k = 0; k < m->parts; ++k) {
        const moving_domain *d = &m->domains[k];
        for (uint64_t i = d->n_own; i < d->bodies.n; ++i) {
            const moving_body *b = moving_body_at(m, &d->bodies, i);
            halo_add(&m->halo.received.items, &(halo_item){.rank = b->own / m->parts,
                                                           .to = d->number,
                                                           .from = b->own,
                                                           .id = b->id,
                                                           .domain = k});
            ++m->n_ghosts;
        }
    }
}

static void list_neighbours(const moving *m, moving_domain *d, duet_error *own)
{
    list_clear(&d->neighbours.list);
    for (uint32_t k = 0; k < m->n_domains; ++k)
        if (k != d->number && extents_meet(&m->reaches[k], &m->reaches[d->number]))
            row_list_add(&d->neighbours, k);
    if (d->neighbours.failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "%u domains: no memory", m->n_domains);
}

static bool find_reaches(moving *m, duet_error *own)
{
    extent *here = calloc(m->parts, sizeof *here);
    if (!m->reaches)
        m->reaches = calloc(m->n_domains, sizeof *m->reaches);
    if (!here || !m->reaches)
        error_set(own, DUET_STATUS_NO_MEMORY, "%u domains: no memory", m->n_domains);
    bool ok = ranks_agree(m->ranks, is_well(own), own);
    for (uint32_t k = 0; ok && k < m->parts; ++k)
        here[k] = extent_grown(reach_of(m, &m->domains[k]), layers_of(m) * m->extent);
    if (ok)
        ranks_gather(m->ranks, here, m->reaches, (int)(m->parts * sizeof *here));
    for (uint32_t k = 0; ok && k < m->parts; ++k)
        list_neighbours(m, &m->domains[k], own);
    free(here);
    return ok;
}

static bool exchange_ghosts(moving *m, duet_error *own)
{
    item_list out = {0};
    halo_clear(&m->halo);
    if (!find_reaches(m, own))
        return false;
    for (uint32_t k = 0; k < m->parts; ++k)
        for (uint64_t i = 0; i < m->domains[k].bodies.n; ++i)
            add_ghosts_of(m, &m->domains[k], moving_body_at(m, &m->domains[k].bodies, i), &out);
    bool ok = deal(m, &out, m->body_bytes, bodies_of, own);
    if (ok && is_well(own))
        note_ghosts(m);
    free(out.items);
    return ok;
}

// ---------------------------------------------------------------- contacts of ghosts

// Items ascend by the domain of this rank, and then by id.
static int compare_visits(const void *left, const void *right)
{
    const halo_item *a = left, *b = right;
    if (a->domain != b->domain)
        return a->domain < b->domain ? -1 : 1;
    return a->id < b->id ? -1 : a->id > b->id;
}

// The first of the visits that an own body makes; the n-th: it makes none.
static uint64_t first_visit(const item_list *visits, uint32_t domain, uint32_t id)
{
    const halo_item key = {.domain = domain, .id = id};
    uint64_t low = 0, high = visits->n;
    while (low < high) {
        uint64_t middle = low + (high - low) / 2;
        if (compare_visits((const halo_item *)visits->items + middle, &key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// A contact goes where its owner is a ghost: the other end is there, too, or it is dropped.
static void list_shared(const moving *m, uint32_t domain, const item_list *visits, item_list *out)
{
    const moving_domain *d = &m->domains[domain];
    for (uint64_t i = 0; i < d->contacts.n; ++i) {
        const moving_contact *c = moving_contact_at(m, &d->contacts, i);
        const halo_item *v = visits->items;
        for (uint64_t k = first_visit(visits, domain, c->owner);
             k < visits->n && v[k].domain == domain && v[k].id == c->owner; ++k) {
            list_add(out, c, 1, m->contact_bytes);
            if (!out->failed)
                moving_contact_at(m, out, out->n - 1)->domain = v[k].to;
        }
    }
}

// If contacts of two ghosts are solved, too, they must be as at home.
static bool share_contacts(moving *m, duet_error *own)
{
    item_list out = {0}, *visits = &m->halo.sent.items;
    if (m->every == 1)
        return true;
    if (is_well(own) && visits->n > 0 && !visits->failed)
        qsort(visits->items, visits->n, sizeof(halo_item), compare_visits);
    for (uint32_t k = 0; is_well(own) && !visits->failed && k < m->parts; ++k)
        list_shared(m, k, visits, &out);
    bool ok = deal(m, &out, m->contact_bytes, contacts_of, own);
    free(out.items);
    return ok;
}

// ---------------------------------------------------------------- places

// If contacts of two ghosts are solved, too, their colours are told, by who has them as own ones.
static void mark_places(moving *m, duet_error *own)
{
    const halo_item *sent = m->halo.sent.items.items;
    for (uint64_t i = 0; m->every > 1 && i < m->halo.sent.items.n; ++i)
        m->domains[sent[i].domain].places[sent[i].place].kind |= PLACE_SHARED;
    for (uint32_t k = 0; is_well(own) && moving_touches(m) && k < m->parts; ++k)
        domain_mark_places(m->domains[k].motion, m->domains[k].places, own);
}

static bool reserve_places(moving_domain *d, duet_error *own)
{
    domain_place *places = realloc(d->places, (d->bodies.n + FIXED) * sizeof *places);
    d->places = places ? places : d->places;
    return places || error_set(own, DUET_STATUS_NO_MEMORY, "the places of %u bodies: no memory",
                               (uint32_t)d->bodies.n);
}

void moving_note_places(const moving *m, moving_domain *d, duet_error *own)
{
    if (!reserve_places(d, own))
        return;
    for (uint32_t k = 0; k < FIXED; ++k)
        d->places[d->bodies.n + k] = (domain_place){.id = m->n_all + k};
    for (uint64_t i = 0; i < d->bodies.n; ++i) {
        const moving_body *b = moving_body_at(m, &d->bodies, i);
        domain_place *p = &d->places[i];
        *p = (domain_place){b->id, (moving_is_own(d, b) ? PLACE_OWN : 0) |
                                       (b->body.mass > 0.0f ? PLACE_MOVES : 0) |
                                       (b->body.sensor ? PLACE_SENSOR : 0)};
        p->kind |= moving_is_ghost(d, (uint32_t)i) ? PLACE_SHARED : 0;
    }
}

// All bodies are own ones until ghosts are noted.
static void reserve_colours(moving_domain *d, duet_error *own)
{
    const size_t bytes = (d->bodies.n + FIXED) * sizeof(uint32_t);
    uint32_t *used = realloc(d->used, bytes), *ghost_at = realloc(d->ghost_at, bytes);
    d->used = used ? used : d->used;
    d->ghost_at = ghost_at ? ghost_at : d->ghost_at;
    list_clear(&d->left.list);
    if (used && ghost_at) {
        memset(used, 0, bytes);
        memset(ghost_at, 0xFF, bytes);
    } else {
        error_set(own, DUET_STATUS_NO_MEMORY, "the colours of %u bodies: no memory",
                  (uint32_t)d->bodies.n);
    }
}

bool moving_exchange(moving *m, item_list *contacts, duet_error *own)
{
    bool ok = moving_migrate(m, own);
    if (ok && moving_touches(m))
        ok = deal(m, contacts, m->contact_bytes, contacts_of, own) && exchange_ghosts(m, own) &&
             share_contacts(m, own);
    for (uint32_t k = 0; ok && is_well(own) && k < m->parts; ++k) {
        reserve_colours(&m->domains[k], own);
        moving_replace(m, &m->domains[k], own);
        moving_note_places(m, &m->domains[k], own);
    }
    if (ok)
        moving_note_touching(m, own);
    ok = ok && halo_settle(&m->halo, m, own);
    if (ok && is_well(own))
        mark_places(m, own);
    tally t = {.sums = {m->n_ghosts}};
    ok = ok && ranks_agree_and(m->ranks, is_well(own), &t, own);
    m->counts.ghosts = t.sums[0];
    return ok;
}

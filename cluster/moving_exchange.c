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

// Adds a body that comes to a domain.
static void add_coming(const moving *m, const moving_body *b, uint32_t domain, item_list *out)
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
            add_coming(m, b, b->domain, out);
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
        add_coming(m, b, to, out);
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

// ---------------------------------------------------------------- order

static int compare_bodies(const void *left, const void *right)
{
    const moving_body *a = left, *b = right;
    return a->id < b->id ? -1 : a->id > b->id;
}

static int compare_contacts(const void *left, const void *right)
{
    const moving_contact *a = left, *b = right;
    if (a->owner != b->owner)
        return a->owner < b->owner ? -1 : 1;
    return a->other < b->other ? -1 : a->other > b->other;
}

// How many of the first bodies ascend: all that stayed do.
static uint64_t count_ascending(const moving *m, const item_list *bodies)
{
    uint64_t n = bodies->n > 0;
    while (n < bodies->n && moving_body_at(m, bodies, n - 1)->id < moving_body_at(m, bodies, n)->id)
        ++n;
    return n;
}

// The first of n bodies, which ascend, whose id is not below.
static uint64_t place_among(const moving *m, const item_list *bodies, uint64_t n, uint32_t id)
{
    uint64_t low = 0;
    while (low < n) {
        uint64_t middle = low + (n - low) / 2;
        if (moving_body_at(m, bodies, middle)->id < id)
            low = middle + 1;
        else
            n = middle;
    }
    return low;
}

// Merges n bodies that came with those that were there, from the last on: each moves once.
static void merge_bodies(const moving *m, item_list *bodies, uint64_t n_before, const char *came,
                         uint64_t n)
{
    for (uint64_t end = bodies->n; n > 0; --end) {
        const moving_body *last = (const void *)(came + (n - 1) * m->body_bytes);
        uint64_t place = place_among(m, bodies, n_before, last->id), moves = n_before - place;
        memmove(moving_body_at(m, bodies, end - moves), moving_body_at(m, bodies, place),
                moves * m->body_bytes);
        end -= moves;
        memcpy(moving_body_at(m, bodies, end - 1), last, m->body_bytes);
        n_before = place;
        --n;
    }
}

static bool sort_bodies(const moving *m, item_list *bodies)
{
    const uint64_t n_before = count_ascending(m, bodies), n = bodies->n - n_before;
    char *came = malloc(n * m->body_bytes + 1);
    if (came && n > 0) {
        memcpy(came, moving_body_at(m, bodies, n_before), n * m->body_bytes);
        qsort(came, n, m->body_bytes, compare_bodies);
        merge_bodies(m, bodies, n_before, came, n);
    }
    free(came);
    return came;
}

// Domains that each had an end of a contact send it to one that has both.
static void sort_contacts(const moving *m, item_list *c)
{
    uint64_t kept = 0;
    if (c->n > 0)
        qsort(c->items, c->n, m->contact_bytes, compare_contacts);
    for (uint64_t i = 0; i < c->n; ++i) {
        const moving_contact *one = moving_contact_at(m, c, i);
        if (kept == 0 || compare_contacts(moving_contact_at(m, c, kept - 1), one) != 0)
            memmove(moving_contact_at(m, c, kept++), one, m->contact_bytes);
    }
    c->n = kept;
}

uint32_t moving_place(const moving *m, const moving_domain *d, uint32_t id)
{
    const uint64_t place = place_among(m, &d->bodies, d->bodies.n, id);
    bool found = place < d->bodies.n && moving_body_at(m, &d->bodies, place)->id == id;
    return found ? (uint32_t)place : UINT32_MAX;
}

// ---------------------------------------------------------------- into the motions

typedef struct replacement {
    domain_bodies bodies;
    row_list waking; // own places that leant on what is not here
    domain_contacts contacts;
} replacement;

static uint32_t count_fresh(const moving *m, const moving_domain *d)
{
    uint32_t n = 0;
    for (uint64_t i = 0; i < d->bodies.n; ++i)
        n += moving_body_at(m, &d->bodies, i)->at == NO_PLACE;
    return n;
}

static bool reserve(const moving *m, const moving_domain *d, replacement *r)
{
    domain_bodies *b = &r->bodies;
    size_t n = d->bodies.n + FIXED, contacts = d->contacts.n + 1;
    b->n = (uint32_t)d->bodies.n;
    b->n_fresh = count_fresh(m, d);
    b->poses = malloc(n * sizeof *b->poses);
    b->bodies = malloc(n * sizeof *b->bodies);
    b->from = malloc(n * sizeof *b->from);
    b->fresh = malloc((b->n_fresh + 1) * sizeof *b->fresh);
    b->states = malloc(b->n_fresh * (m->body_bytes - sizeof(moving_body)) + 1);
    r->contacts.links = malloc(contacts * sizeof *r->contacts.links);
    r->contacts.touches = malloc(contacts * sizeof *r->contacts.touches);
    r->contacts.colours = malloc(contacts * sizeof *r->contacts.colours);
    r->contacts.records = malloc(contacts * (m->contact_bytes - sizeof(moving_contact)) + 1);
    return b->poses && b->bodies && b->from && b->fresh && b->states && r->contacts.links &&
           r->contacts.touches && r->contacts.colours && r->contacts.records;
}

static void fill_bodies(const moving *m, const moving_domain *d, replacement *r)
{
    const size_t state = m->body_bytes - sizeof(moving_body);
    domain_bodies *to = &r->bodies;
    to->n_fresh = 0;
    for (uint32_t i = 0; i < to->n; ++i) {
        moving_body *b = moving_body_at(m, &d->bodies, i);
        b->complete = b->acts || m->n_domains == 1;
        to->poses[i] = b->pose;
        to->bodies[i] = b->body;
        to->from[i] = b->at;
        if (b->at != NO_PLACE)
            continue;
        memcpy(to->states + to->n_fresh * state, moving_state(b), state);
        to->fresh[to->n_fresh++] = i;
    }
    for (uint32_t k = 0; k < FIXED; ++k)
        to->from[to->n + k] = NO_PLACE;
}

// An own sleeper that leant on what is far away now wakes, as in match_contacts.cl.
static void wake_end(const moving *m, const moving_domain *d, const moving_contact *c,
                     uint32_t place, replacement *r)
{
    const duet_motion *motion = d->motion;
    uint32_t points = c->touch & TOUCH_POINTS;
    bool leant = (motion->effects & DUET_EFFECT_SLEEP) &&
                 domain_was_pushed(motion, (const float *)(const void *)(c + 1), points);
    cl_uint asleep = 0;
    if (!leant || !moving_owns(m, d, place))
        return;
    const char *rest = moving_state(moving_body_at(m, &d->bodies, place)) + domain_rest_at(motion);
    memcpy(&asleep, rest + sizeof(float), sizeof asleep);
    if (asleep & SLEEPS)
        row_list_add(&r->waking, place);
}

// A contact of which an end is not here any more is none: bounds that meet are here.
static void fill_contacts(const moving *m, const moving_domain *d, replacement *r)
{
    const size_t record = m->contact_bytes - sizeof(moving_contact);
    domain_contacts *to = &r->contacts;
    to->n = 0;
    for (uint64_t i = 0; i < d->contacts.n; ++i) {
        const moving_contact *c = moving_contact_at(m, &d->contacts, i);
        bool fixed = c->other >= m->n_all;
        uint32_t owner = moving_place(m, d, c->owner);
        uint32_t other =
            fixed ? (uint32_t)d->bodies.n + (c->other - m->n_all) : moving_place(m, d, c->other);
        if (owner == UINT32_MAX || other == UINT32_MAX) {
            wake_end(m, d, c, owner != UINT32_MAX ? owner : other, r);
            continue;
        }
        to->links[to->n] = (cl_uint2){{owner, other}};
        to->touches[to->n] = c->touch;
        to->colours[to->n] = c->colour;
        memcpy((char *)to->records + to->n++ * record, c + 1, record);
    }
}

// They have no rest.
static bool wake(moving_domain *d, const row_list *places, duet_error *own)
{
    const row_parts whole = {.words = {1}};
    float *rests = calloc(places->n + 1, sizeof *rests);
    if (!rests || places->failed)
        error_set(own, DUET_STATUS_NO_MEMORY, "bodies that wake: no memory");
    else if (places->n > 0)
        domain_unpack_rows(d->motion, RESTS, &whole, places->rows, (uint32_t)places->n, rests, own);
    domain_await_rows(d->motion, own);
    free(rests);
    return is_well(own);
}

// The places that bodies get which were here before, as far as they still are.
static uint32_t *find_moved(const moving *m, const moving_domain *d)
{
    const uint32_t n = d->motion->n;
    uint32_t *moved = malloc(((size_t)n + FIXED) * sizeof *moved);
    uint64_t now = 0;
    for (uint32_t i = 0; moved && i < n; ++i) {
        while (now < d->bodies.n && moving_body_at(m, &d->bodies, now)->id < d->places[i].id)
            ++now;
        moved[i] = (uint32_t)now;
    }
    for (uint32_t k = 0; moved && k < FIXED; ++k)
        moved[n + k] = (uint32_t)d->bodies.n + k;
    return moved;
}

// Contacts that do not travel stay.
static void keep_contacts(const moving *m, const moving_domain *d, duet_error *own)
{
    if (moving_sends_all(m) || d->motion->graph.n_contacts == 0) {
        domain_drop_contacts(d->motion);
        return;
    }
    uint32_t *moved = find_moved(m, d);
    if (!moved)
        error_set(own, DUET_STATUS_NO_MEMORY, "%u bodies: no memory", d->motion->n);
    else
        domain_keep_contacts(d->motion, moved, own);
    free(moved);
}

void moving_replace(moving *m, moving_domain *d, duet_error *own)
{
    replacement r = {0};
    sort_contacts(m, &d->contacts);
    if (!sort_bodies(m, &d->bodies))
        error_set(own, DUET_STATUS_NO_MEMORY, "bodies that came: no memory");
    if (is_well(own))
        keep_contacts(m, d, own);
    moving_keep_base(m, d->motion);
    if (!reserve(m, d, &r)) {
        error_set(own, DUET_STATUS_NO_MEMORY, "a domain of %u bodies: no memory",
                  (uint32_t)d->bodies.n);
    } else if (is_well(own)) {
        fill_bodies(m, d, &r);
        fill_contacts(m, d, &r);
        if (domain_replace_bodies(d->motion, &r.bodies, &r.contacts, own))
            wake(d, &r.waking, own);
    }
    free(r.bodies.poses);
    free(r.bodies.bodies);
    free(r.bodies.from);
    free(r.bodies.fresh);
    free(r.bodies.states);
    free(r.waking.rows);
    domain_contacts_free(&r.contacts);
}

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

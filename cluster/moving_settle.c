// SPDX-License-Identifier: MIT
// Bodies and contacts are read as a step and commands left them, before they are exchanged.
#include "cluster/moving_domains.h"

#include "base/error.h"

// Ghosts are chosen by far boxes, which bodies stay in for about so many steps, so that pairs are
// searched more often than bodies are exchanged.
enum { STEPS_WITHIN = 8 };

// ---------------------------------------------------------------- bodies that leave

// Makes far boxes: further by the way of a body that keeps its velocity, and by the mean extent for
// one that does not.
static bool make_far_boxes(const moving *m, moving_domain *d, const extent *home,
                           domain_near **near, uint32_t *n, duet_error *own)
{
    domain_far far = {.time = (float)(STEPS_WITHIN * d->motion->def.dt),
                      .margin = (float)d->motion->extent};
    float reach[6];
    moving_round_extent(m, home, true, far.home);
    bool ok = domain_make_far_boxes(d->motion, &far, reach, near, n, own);
    d->reach = extent_of_box(reach);
    return ok;
}

void moving_read_all(moving *m, moving_domain *d, row_list *places, item_list *to, duet_error *own)
{
    domain_near *near = NULL;
    uint32_t n;
    for (uint64_t i = 0; i < d->bodies.n; ++i)
        row_list_add(places, (uint32_t)i);
    moving_note_places(m, d, own);
    if (is_well(own) && moving_touches(m) && domain_mark_places(d->motion, d->places, own))
        make_far_boxes(m, d, &extent_all, &near, &n, own);
    free(near);
    d->reach = extent_none;
    moving_read_bodies(m, d, places, to, own);
}

// The domain's box, counted as bounds are.
static extent home_of(const moving *m, const moving_domain *d)
{
    extent home = bisection_box(&m->cuts, d->number, &extent_all);
    for (int k = 0; k < 3; ++k) {
        const double base = m->base.s[k] * (double)m->def.origin_edge;
        home.lower[k] -= base;
        home.upper[k] -= base;
    }
    return home;
}

// Own bodies that may have left: their bounds have. These hold their centres.
static void list_near_home(const moving *m, moving_domain *d, row_list *places, duet_error *own)
{
    domain_near *near = NULL;
    uint32_t n = 0;
    const extent home = home_of(m, d);
    if (is_well(own) && make_far_boxes(m, d, &home, &near, &n, own))
        for (uint32_t i = 0; i < n; ++i)
            row_list_add(places, near[i].place);
    row_list_sort(places);
    free(near);
}

static void add_ghosts(const moving *m, moving_domain *d)
{
    const halo_item *ghosts = m->halo.received.items.items;
    for (uint64_t i = 0; i < m->halo.received.items.n; ++i)
        if (&m->domains[ghosts[i].domain] == d)
            row_list_add(&d->gone, ghosts[i].place);
    row_list_sort(&d->gone);
}

// Own bodies go to the domain that they are to be own ones of, or stay.
static void part_with(moving *m, moving_domain *d, const row_list *places, const item_list *rows,
                      item_list *out)
{
    const bool all = moving_all_travel(m);
    for (uint64_t i = 0; i < rows->n; ++i) {
        const moving_traveller *row = moving_traveller_at(m, rows, i);
        const extent box = extent_of_box(row->far_box);
        moving_body *b = &d->bodies.rows[places->rows[i]];
        b->next = row->domain;
        if (!moving_is_own(d, b))
            continue;
        if (b->next == d->number) {
            if (all)
                list_add(&d->came, row, 1, m->traveller_bytes);
            else if (b->acts)
                extent_join(&d->reach, &box);
            continue;
        }
        list_add(out, row, 1, m->traveller_bytes);
        if (!all)
            row_list_add(&d->gone, places->rows[i]);
    }
}

static void find_leaving(moving *m, moving_domain *d, item_list *out, duet_error *own)
{
    row_list places = {0};
    item_list rows = {0};
    list_clear(&d->gone.list);
    if (moving_all_travel(m)) {
        moving_read_all(m, d, &d->gone, &rows, own);
        part_with(m, d, &d->gone, &rows, out);
    } else {
        list_near_home(m, d, &places, own);
        moving_read_bodies(m, d, &places, &rows, own);
        part_with(m, d, &places, &rows, out);
        add_ghosts(m, d);
    }
    if (rows.failed || d->gone.failed || d->came.failed)
        no_memory(own, "bodies that leave");
    free(places.rows);
    free(rows.items);
}

// ---------------------------------------------------------------- contacts

enum { MOST_RECORD = HEAD_OF(1, 1, 4) + 4 * POINT_FLOATS_OF(1, 1, 3) };

typedef struct contact_row {
    moving_contact head;
    float record[MOST_RECORD];
} contact_row;

// The domain that a contact goes to for an end of it: the next one of an own body that acts, or is
// the owner, whose domain may tell that the contact ended; and of another's body which commands
// made act, since its own domain has not seen the contact. UINT32_MAX: none.
static uint32_t next_of(const moving_domain *d, const moving_body *b, bool is_owner)
{
    bool sends = b && (moving_is_own(d, b) ? b->acts || is_owner : b->acts && !b->complete);
    return sends ? b->next : UINT32_MAX;
}

// A contact is right where its owner is own, which acted, or an end whose contacts are all there.
static bool is_right(const moving_domain *d, const uint32_t ends[2])
{
    const moving_body *other = moving_body_or_wall(d, ends[1]);
    return moving_owns(d, ends[0]) || (other && moving_is_own(d, other) && other->complete);
}

// Domains of this rank get it at once.
static void send_contact(moving *m, moving_contact *row, const uint32_t next[2],
                         item_list *contacts)
{
    row->domain = UINT32_MAX;
    for (int k = 0; k < 2; ++k) {
        if (next[k] == UINT32_MAX || next[k] == row->domain)
            continue;
        row->domain = next[k];
        list_add(next[k] / m->parts == (uint32_t)m->ranks->self
                     ? &m->domains[next[k] % m->parts].contacts
                     : contacts,
                 row, 1, m->contact_bytes);
    }
}

static void add_contact(moving *m, const moving_domain *d, const domain_contacts *from, uint32_t i,
                        bool is_told, item_list *contacts)
{
    const uint32_t *ends = from->links[i].s;
    if (!is_right(d, ends))
        return;
    contact_row row;
    moving_write_contact(m, d, from, i, &row.head);
    if (is_told)
        row.head.told_by = moving_id(m, d, ends[moving_other_tells(d, ends[0], ends[1])]);
    const uint32_t next[2] = {next_of(d, moving_body_or_wall(d, ends[0]), true),
                              next_of(d, moving_body_or_wall(d, ends[1]), false)};
    send_contact(m, &row.head, next, contacts);
}

// Contacts of which an end is not here are in no motion, and stay until a step ends them: commands
// may bring it back.
static void send_parted(moving *m, const moving_domain *d, const item_list *parted,
                        item_list *contacts)
{
    for (uint64_t i = 0; i < parted->n; ++i) {
        moving_contact *c = moving_contact_at(m, parted, i);
        const uint32_t owner = moving_place(d, c->owner),
                       other = c->other < m->n_all ? moving_place(d, c->other) : 0;
        if (owner != UINT32_MAX && other != UINT32_MAX)
            continue;
        const uint32_t next[2] = {
            moving_owns(d, owner) ? next_of(d, &d->bodies.rows[owner], true) : UINT32_MAX,
            c->other < m->n_all && moving_owns(d, other) ? next_of(d, &d->bodies.rows[other], false)
                                                         : UINT32_MAX};
        send_contact(m, c, next, contacts);
    }
}

// A contact that does not touch has nothing to keep.
static void add_contacts(moving *m, const moving_domain *d, const domain_contacts *all,
                         item_list *contacts, duet_error *own)
{
    uint8_t *told = calloc((size_t)d->motion->graph.n_contacts + 1, 1);
    if (!told)
        no_memory(own, "%u contacts", all->n);
    else if (!all->rows && domain_note_touching(d->motion, own))
        domain_read_told(d->motion, told, own);
    for (uint32_t i = 0; is_well(own) && i < all->n; ++i)
        if (all->touches[i] & TOUCH_POINTS)
            add_contact(m, d, all, i, told[i], contacts);
    free(told);
}

void moving_read_contacts(moving *m, const moving_domain *d, item_list *contacts, duet_error *own)
{
    domain_contacts all;
    if (domain_read_contacts(d->motion, true, &all, own))
        add_contacts(m, d, &all, contacts, own);
    domain_contacts_free(&all);
}

// Ghosts and own bodies that leave take their contacts along.
static void mark_travelling(moving_domain *d, duet_error *own)
{
    for (uint64_t i = 0; i < d->gone.n; ++i) {
        const moving_body *b = &d->bodies.rows[d->gone.rows[i]];
        if (!moving_is_own(d, b) || b->next != d->number)
            d->places[d->gone.rows[i]].kind |= PLACE_SHARED;
    }
    domain_mark_places(d->motion, d->places, own);
}

// Reads the contacts that travel; the others stay in the motion.
static void read_travelling(moving *m, moving_domain *d, item_list *contacts, duet_error *own)
{
    domain_contacts listed = {0};
    mark_travelling(d, own);
    if (!is_well(own) || !domain_list_shared(d->motion, &listed, own))
        return;
    if (domain_reserve_rows(&listed, d->motion, own) && domain_read_rows(d->motion, &listed, own))
        add_contacts(m, d, &listed, contacts, own);
    domain_contacts_free(&listed);
}

// ---------------------------------------------------------------- all of it

static void forget_sent(moving *m)
{
    const halo_item *sent = m->halo.sent.items.items;
    for (uint64_t i = 0; i < m->halo.sent.items.n; ++i)
        m->domains[sent[i].domain].places[sent[i].place].kind &= ~(PLACE_SHARED | PLACE_SENT);
}

// The domains that contacts go to follow from where bodies are, and from the borders.
static bool read_all(moving *m, const item_list *parted, item_list *bodies, item_list *contacts,
                     duet_error *own)
{
    if (moving_cut_is_due(m) && !moving_cut(m, m->domains, m->parts, own))
        return false;
    forget_sent(m);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        find_leaving(m, &m->domains[k], bodies, own);
    for (uint32_t k = 0; is_well(own) && moving_touches(m) && k < m->parts; ++k) {
        if (moving_sends_all(m))
            moving_read_contacts(m, &m->domains[k], contacts, own);
        else
            read_travelling(m, &m->domains[k], contacts, own);
        send_parted(m, &m->domains[k], &parted[k], contacts);
    }
    return true;
}

bool moving_settle(moving *m, duet_error *own)
{
    item_list bodies = {0}, contacts = {0}, *parted = calloc(m->parts, sizeof *parted);
    if (!parted)
        no_memory(own, "%u domains", m->parts);
    const moving_phase before = m->phases.now;
    moving_enter(m, PHASE_LEAVE);
    ++m->phases.n_moves;
    for (uint32_t k = 0; parted && k < m->parts; ++k) {
        parted[k] = m->domains[k].contacts;
        m->domains[k].contacts = (item_list){0};
    }
    bool ok =
        read_all(m, parted, &bodies, &contacts, own) && moving_exchange(m, &bodies, &contacts, own);
    for (uint32_t k = 0; parted && k < m->parts; ++k)
        free(parted[k].items);
    free(parted);
    free(bodies.items);
    free(contacts.items);
    moving_enter(m, before);
    return ok;
}

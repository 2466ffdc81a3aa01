// SPDX-License-Identifier: MIT
// Bodies and contacts are read as a step and commands left them, before they are exchanged.
#include "cluster/moving_domains.h"

#include "base/error.h"

// ---------------------------------------------------------------- bodies

// Ghosts are chosen by bounds that bodies stay in for about so many steps, so that pairs are
// searched more often than bodies are exchanged.
enum { STEPS_WITHIN = 8 };

// Wider by the way of a body that keeps its velocity, and by the mean extent for one that does not.
static void widen(const moving *m, moving_body *b)
{
    const duet_motion *motion = m->domains[0].motion;
    double velocity[3];
    moving_velocity(m, b, velocity);
    for (int k = 0; k < 3; ++k) {
        double way = STEPS_WITHIN * motion->def.dt * velocity[k];
        b->bounds[k] -= (float)(motion->extent + greater(0, -way));
        b->bounds[k + 3] += (float)(motion->extent + greater(0, way));
    }
    if (motion->def.dims == 2)
        b->bounds[2] = b->bounds[5] = 0.0f;
}

void moving_read_bodies(moving *m, moving_domain *d, duet_error *own)
{
    const size_t state = m->body_bytes - sizeof(moving_body), n = d->bodies.n;
    char *states = malloc(n * state + 1);
    float *bounds = malloc((6 * n + 1) * sizeof *bounds);
    if (!states || !bounds)
        error_set(own, DUET_STATUS_NO_MEMORY, "the states of %zu bodies: no memory", n);
    domain_forget_bounds(d->motion); // others than those that the next step makes
    bool ok = is_well(own) && domain_read_states(d->motion, states, own) &&
              (!moving_touches(m) || domain_read_bounds(d->motion, bounds, own));
    for (uint64_t i = 0; ok && i < n; ++i) {
        moving_body *b = moving_body_at(m, &d->bodies, i);
        b->at =
            m->keeps_commands ? NO_PLACE : (uint32_t)i; // commands leave more than the motion has
        b->pose = d->motion->poses[i];
        b->body = d->motion->bodies[i];
        b->acts = (b->body.mass > 0.0f || b->body.sensor) &&
                  !domain_is_hidden(d->motion, states + i * state);
        memcpy(moving_state(b), states + i * state, state);
        if (!moving_touches(m))
            continue;
        memcpy(b->bounds, bounds + 6 * i, sizeof b->bounds);
        widen(m, b);
    }
    free(states);
    free(bounds);
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
static uint32_t next_of(const moving *m, const moving_domain *d, const moving_body *b,
                        bool is_owner)
{
    bool sends = b && (moving_is_own(d, b) ? b->acts || is_owner : b->acts && !b->complete);
    return sends ? moving_domain_of(m, b) : UINT32_MAX;
}

// A contact is right where its owner is own, which acted, or an end whose contacts are all there.
static bool is_right(const moving *m, const moving_domain *d, const uint32_t ends[2])
{
    const moving_body *other = moving_body_or_wall(m, d, ends[1]);
    return moving_owns(m, d, ends[0]) || (other && moving_is_own(d, other) && other->complete);
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

void moving_write_contact(const moving *m, const moving_domain *d, const domain_contacts *from,
                          uint32_t i, moving_contact *row)
{
    const size_t record = m->contact_bytes - sizeof(moving_contact);
    *row = (moving_contact){.owner = moving_id(m, d, from->links[i].s[0]),
                            .other = moving_id(m, d, from->links[i].s[1]),
                            .touch = from->touches[i],
                            .colour = from->colours[i],
                            .told_by = TOLD_BY_NONE};
    memcpy(row + 1, (const char *)from->records + i * record, record);
}

static void add_contact(moving *m, const moving_domain *d, const domain_contacts *from, uint32_t i,
                        bool is_told, item_list *contacts)
{
    const uint32_t *ends = from->links[i].s;
    if (!is_right(m, d, ends))
        return;
    contact_row row;
    moving_write_contact(m, d, from, i, &row.head);
    if (is_told)
        row.head.told_by = moving_id(m, d, ends[moving_other_tells(m, d, ends[0], ends[1])]);
    const uint32_t next[2] = {next_of(m, d, moving_body_or_wall(m, d, ends[0]), true),
                              next_of(m, d, moving_body_or_wall(m, d, ends[1]), false)};
    send_contact(m, &row.head, next, contacts);
}

// Contacts of which an end is not here are in no motion, and stay until a step ends them: commands
// may bring it back.
static void send_parted(moving *m, const moving_domain *d, const item_list *parted,
                        item_list *contacts)
{
    for (uint64_t i = 0; i < parted->n; ++i) {
        moving_contact *c = moving_contact_at(m, parted, i);
        const uint32_t owner = moving_place(m, d, c->owner),
                       other = c->other < m->n_all ? moving_place(m, d, c->other) : 0;
        if (owner != UINT32_MAX && other != UINT32_MAX)
            continue;
        const uint32_t next[2] = {moving_owns(m, d, owner)
                                      ? next_of(m, d, moving_body_at(m, &d->bodies, owner), true)
                                      : UINT32_MAX,
                                  c->other < m->n_all && moving_owns(m, d, other)
                                      ? next_of(m, d, moving_body_at(m, &d->bodies, other), false)
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
        error_set(own, DUET_STATUS_NO_MEMORY, "%u contacts: no memory", all->n);
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
static void mark_travelling(const moving *m, moving_domain *d, duet_error *own)
{
    moving_note_places(m, d, own);
    for (uint64_t i = 0; is_well(own) && i < d->bodies.n; ++i) {
        const moving_body *b = moving_body_at(m, &d->bodies, i);
        if (!moving_is_own(d, b) || moving_domain_of(m, b) != d->number)
            d->places[i].kind |= PLACE_SHARED;
    }
    if (is_well(own))
        domain_mark_places(d->motion, d->places, own);
}

// Leaves those contacts that travel of the ones that the host is told of.
static void leave_travelling(const moving_domain *d, domain_contacts *c)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < c->n; ++i) {
        const uint32_t *ends = c->links[i].s;
        if (!((d->places[ends[0]].kind | d->places[ends[1]].kind) & PLACE_SHARED))
            continue;
        c->rows[kept] = c->rows[i];
        c->links[kept++] = c->links[i];
    }
    c->n = kept;
}

// Reads the contacts that travel; the others stay in the motion.
static void read_travelling(moving *m, moving_domain *d, item_list *contacts, duet_error *own)
{
    domain_contacts listed = {0};
    mark_travelling(m, d, own);
    if (!is_well(own) || !domain_list_border(d->motion, &listed, own))
        return;
    leave_travelling(d, &listed);
    if (domain_reserve_rows(&listed, d->motion, own) && domain_read_rows(d->motion, &listed, own))
        add_contacts(m, d, &listed, contacts, own);
    domain_contacts_free(&listed);
}

// ---------------------------------------------------------------- all of it

// The domains that contacts go to follow from where bodies are, and from the borders.
static bool read_all(moving *m, const item_list *parted, item_list *contacts, duet_error *own)
{
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        moving_read_bodies(m, &m->domains[k], own);
    if (moving_cut_is_due(m) && !moving_cut(m, own))
        return false;
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
    item_list contacts = {0}, *parted = calloc(m->parts, sizeof *parted);
    if (!parted)
        error_set(own, DUET_STATUS_NO_MEMORY, "%u domains: no memory", m->parts);
    for (uint32_t k = 0; parted && k < m->parts; ++k) {
        parted[k] = m->domains[k].contacts;
        m->domains[k].contacts = (item_list){0};
    }
    bool ok = read_all(m, parted, &contacts, own) && moving_exchange(m, &contacts, own);
    for (uint32_t k = 0; parted && k < m->parts; ++k)
        free(parted[k].items);
    free(parted);
    free(contacts.items);
    return ok;
}

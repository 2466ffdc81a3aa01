// SPDX-License-Identifier: MIT
// Bodies and contacts as rows that travel: read from a domain's motion, and dealt to domains.
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "cluster/parcels.h"
#include "cluster/row_order.h"

// ---------------------------------------------------------------- bodies

// States and far boxes of bodies, and a row for one of them.
typedef struct reading {
    char *states;
    float *far_boxes;
    moving_traveller *row;
} reading;

static bool begin_reading(const moving *m, size_t n, reading *r, duet_error *own)
{
    r->states = malloc(n * (m->traveller_bytes - sizeof(moving_traveller)) + 1);
    r->far_boxes = calloc(6 * n + 1, sizeof *r->far_boxes);
    r->row = calloc(1, m->traveller_bytes);
    return (r->states && r->far_boxes && r->row) || no_memory(own, "the states of %zu bodies", n);
}

static bool read_rows(const moving *m, moving_domain *d, const row_list *places, reading *r,
                      duet_error *own)
{
    const uint32_t n = (uint32_t)places->n;
    return begin_reading(m, n, r, own) &&
           domain_read_states(d->motion, places->rows, n, r->states, own) &&
           (!moving_touches(m) ||
            domain_pack_rows(d->motion, FAR_BOXES, NULL, places->rows, n, r->far_boxes, own));
}

static void fill_row(const moving *m, moving_domain *d, uint32_t place, const char *state,
                     const float far_box[6], moving_traveller *row)
{
    moving_body *b = &d->bodies.rows[place];
    const duet_body *given = &d->motion->bodies[place];
    b->acts = (given->mass > 0.0f || given->sensor) && !domain_is_hidden(d->motion, state);
    row->domain = moving_domain_of(m, state);
    row->body = *b;
    row->pose = d->motion->poses[place];
    row->given = *given;
    memcpy(row->far_box, far_box, sizeof row->far_box);
    memcpy(moving_state(row), state, m->traveller_bytes - sizeof *row);
}

void moving_read_bodies(moving *m, moving_domain *d, const row_list *places, item_list *to,
                        duet_error *own)
{
    const size_t state = m->traveller_bytes - sizeof(moving_traveller);
    reading r = {0};
    if (is_well(own) && places->failed)
        no_memory(own, "places of bodies");
    bool ok = is_well(own) && read_rows(m, d, places, &r, own);
    for (uint64_t i = 0; ok && i < places->n; ++i) {
        fill_row(m, d, places->rows[i], r.states + i * state, r.far_boxes + 6 * i, r.row);
        list_add(to, r.row, 1, m->traveller_bytes);
    }
    m->counts.read += ok ? places->n : 0;
    free(r.states);
    free(r.far_boxes);
    free(r.row);
}

// ---------------------------------------------------------------- contacts

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

void moving_put_contact(const moving *m, const moving_contact *c, uint32_t owner, uint32_t other,
                        domain_contacts *to)
{
    const size_t record = m->contact_bytes - sizeof *c;
    to->links[to->n] = (cl_uint2){{owner, other}};
    to->touches[to->n] = c->touch;
    to->colours[to->n] = c->colour;
    memcpy((char *)to->records + to->n++ * record, c + 1, record);
}

static uint64_t key_of_contact(const void *row)
{
    const moving_contact *c = row;
    return (uint64_t)c->owner << 32 | c->other;
}

// Domains that each had an end of a contact send it to one that has both.
bool moving_order_contacts(const moving *m, item_list *contacts)
{
    return row_order(contacts, m->contact_bytes, key_of_contact);
}

// ---------------------------------------------------------------- to their domains

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

// All rows are the only domain's, which has none yet.
static void take_all(item_list *l, parcels *in)
{
    free(l->items);
    *l = (item_list){.items = in->rows, .n = in->n, .capacity = in->n};
    in->rows = NULL;
}

static void deal_out(moving *m, parcels *in, size_t bytes, moving_list_of *list)
{
    item_list *first = list(&m->domains[0]);
    if (m->parts == 1 && first->n == 0 && !first->failed) {
        take_all(first, in);
        return;
    }
    for (uint64_t i = 0; i < in->n; ++i) {
        const char *row = (const char *)in->rows + i * bytes;
        list_add(list(&m->domains[row_domain(row) % m->parts]), row, 1, bytes);
    }
}

bool moving_deal(moving *m, item_list *rows, size_t bytes, moving_list_of *list, duet_error *own)
{
    const dealing d = {m, rows, bytes};
    const parcels_def out = {
        .n = rows->n, .row_bytes = bytes, .rows = rows->items, .rank_of = rank_of, .context = &d};
    parcels in = {0};
    if (is_well(own) && rows->failed)
        no_memory(own, "rows that travel");
    bool ok = parcels_deal(m->ranks, is_well(own), &out, &in, own);
    if (ok)
        deal_out(m, &in, bytes, list);
    for (uint32_t k = 0; ok && k < m->parts; ++k)
        if (list(&m->domains[k])->failed)
            no_memory(own, "rows of a domain");
    parcels_end(&in);
    return ok;
}

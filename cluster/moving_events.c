// SPDX-License-Identifier: MIT
#include "cluster/moving_events.h"

#include "base/compare.h"
#include "cluster/moving_domains.h"

#include <stdlib.h>

void moving_events_end(moving_events *e)
{
    pair_list_free(&e->before);
    pair_list_free(&e->now);
    pair_changes_free(&e->changes);
    free(e->hits);
    *e = (moving_events){0};
}

// ---------------------------------------------------------------- what touches

// All contacts with the ground are one pair, and follow each other.
static bool add_pair(const moving *m, pair_list *list, uint32_t owner, uint32_t other,
                     duet_error *own)
{
    uint32_t ground = m->n_all + AT_GROUND;
    duet_pair p = {owner, other < ground ? other : ground};
    const duet_pair *last = list->n > 0 ? &list->pairs[list->n - 1] : NULL;
    if (last && last->a == p.a && last->b == p.b)
        return true;
    if (!pair_list_reserve(list, list->n + 1, own))
        return false;
    list->pairs[list->n++] = p;
    return true;
}

static void add_told(moving *m, const moving_domain *d, duet_error *own)
{
    for (uint64_t i = 0; is_well(own) && i < d->contacts.n; ++i) {
        const moving_contact *c = moving_contact_at(m, &d->contacts, i);
        if (moving_owns(d, moving_place(d, c->told_by)))
            add_pair(m, &m->events.now, c->owner, c->other, own);
    }
}

void moving_note_touching(moving *m, duet_error *own)
{
    m->events.now.n = 0;
    if (moving_tells(m) && m->n_domains == 1 && is_well(own))
        domain_recall_touching(m->domains[0].motion, own);
    for (uint32_t k = 0; moving_tells(m) && k < m->parts; ++k)
        add_told(m, &m->domains[k], own);
}

static void add_touching(moving *m, const moving_domain *d, duet_error *own)
{
    const motion_events *e = &d->motion->told;
    uint8_t *told = malloc(d->motion->graph.n_contacts + 1);
    if (!told)
        no_memory(own, "contacts that touch");
    else if (domain_read_told(d->motion, told, own))
        for (size_t i = 0; d->bodies.n > 0 && is_well(own) && i < e->links.n; ++i) {
            duet_pair link = e->links.pairs[i];
            uint32_t by = moving_other_tells(d, link.a, link.b) ? link.b : link.a;
            if (told[i] && moving_owns(d, by))
                add_pair(m, &m->events.now, moving_id(m, d, link.a), moving_id(m, d, link.b), own);
        }
    free(told);
}

// ---------------------------------------------------------------- hits

// Only what has a mass is pushed, and of two such bodies the lesser is the owner.
static uint32_t owner_of(const moving_domain *d, const duet_hit_event *hit)
{
    return d->motion->bodies[hit->a].mass > 0.0f ? hit->a : hit->b;
}

static bool add_hits(moving *m, const moving_domain *d, duet_error *own)
{
    moving_events *e = &m->events;
    const duet_hit_event *hits;
    size_t n;
    if (!domain_read_hits(d->motion, &hits, &n, own) ||
        !pair_list_grow((void **)&e->hits, &e->capacity, e->n_hits + n, sizeof *e->hits, own))
        return false;
    for (size_t i = 0; i < n; ++i) {
        duet_hit_event hit = hits[i];
        if (!moving_owns(d, owner_of(d, &hit)))
            continue;
        hit.a = moving_id(m, d, hit.a);
        hit.b = moving_id(m, d, hit.b);
        e->hits[e->n_hits++] = hit;
    }
    return true;
}

// ---------------------------------------------------------------- a step

static void begin(moving_events *e)
{
    pair_list before = e->before;
    e->before = e->now;
    e->now = before;
    e->now.n = e->n_hits = 0;
}

void moving_find_events(moving *m, duet_error *own)
{
    moving_events *e = &m->events;
    if (!moving_tells(m))
        return;
    begin(e);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
        add_touching(m, &m->domains[k], own);
        add_hits(m, &m->domains[k], own);
    }
    if (e->n_hits > 0)
        qsort(e->hits, e->n_hits, sizeof *e->hits, compare_uint32_pair);
    if (is_well(own) && pair_list_sort(&e->before, own) && pair_list_sort(&e->now, own))
        pair_changes_find(&e->changes, &e->before, &e->now, own);
}

// The only domain's motion tells of all itself.
moving_told moving_get_told(const moving *m)
{
    const motion_events *alone = &m->domains[0].motion->told;
    const moving_events *e = &m->events;
    return m->n_domains == 1 ? (moving_told){&alone->changes, alone->hits, alone->n_hits}
                             : (moving_told){&e->changes, e->hits, e->n_hits};
}

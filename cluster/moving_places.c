// SPDX-License-Identifier: MIT
// Places of a domain's bodies: of which id, and what the device is told of each.
#include "cluster/moving_domains.h"

#include "base/compare.h"
#include "base/error.h"
#include "runtime/bodies/ground_def.h"

#include <inttypes.h>

// ---------------------------------------------------------------- by id

// Bodies to a stretch of ids, about, that are searched.
enum { STRETCH = 8 };

void moving_index_places(const moving *m, moving_domain *d, duet_error *own)
{
    id_index *index = &d->index;
    const uint64_t n = d->bodies.n;
    uint32_t shift = 0;
    while ((uint64_t)m->n_all >> shift > n / STRETCH + 1)
        ++shift;
    const uint64_t stretches = ((uint64_t)m->n_all >> shift) + 2;
    uint32_t *firsts = realloc(index->firsts, stretches * sizeof *firsts);
    index->firsts = firsts ? firsts : index->firsts;
    index->n = 0;
    if (!firsts) {
        no_memory(own, "%" PRIu64 " bodies", n);
        return;
    }
    uint64_t stretch = 0;
    for (uint32_t i = 0; i < n; ++i)
        while (stretch < stretches && stretch <= d->bodies.rows[i].id >> shift)
            firsts[stretch++] = i;
    while (stretch < stretches)
        firsts[stretch++] = (uint32_t)n;
    index->n = stretches;
    index->shift = shift;
}

uint32_t moving_place(const moving_domain *d, uint32_t id)
{
    const uint64_t stretch = (uint64_t)id >> d->index.shift;
    const bool known = stretch + 1 < d->index.n;
    const uint64_t first = known ? d->index.firsts[stretch] : 0;
    const uint64_t end = known ? d->index.firsts[stretch + 1] : d->bodies.n;
    const item_list near = {.items = d->bodies.rows + first, .n = end - first};
    const uint64_t at = first + list_find(&near, sizeof *d->bodies.rows, &id, compare_uint32);
    return at < d->bodies.n && d->bodies.rows[at].id == id ? (uint32_t)at : UINT32_MAX;
}

uint32_t moving_carrier_place(const moving *m, const moving_domain *d)
{
    const uint32_t carrier = ground_def_carrier(&m->def);
    return carrier > 0 ? moving_place(d, carrier - 1) : UINT32_MAX;
}

uint32_t moving_end_place(const moving *m, const moving_domain *d, uint32_t id)
{
    return id < m->n_all ? moving_place(d, id) : (uint32_t)d->bodies.n + (id - m->n_all);
}

// ---------------------------------------------------------------- what is told of them

bool moving_reserve_places(moving_domain *d, uint64_t n, duet_error *own)
{
    domain_place *places = realloc(d->places, (n + FIXED) * sizeof *places);
    d->places = places ? places : d->places;
    return places || no_memory(own, "the places of %" PRIu64 " bodies", n);
}

domain_place moving_place_of(const moving_domain *d, const moving_body *b, const duet_body *given)
{
    const bool is_own = moving_is_own(d, b), moves = given->mass > 0.0f;
    return (domain_place){b->id, (is_own ? PLACE_OWN : 0) | (moves ? PLACE_MOVES : 0) |
                                     (given->sensor ? PLACE_SENSOR : 0) |
                                     (!is_own && moves ? PLACE_SHARED : 0)};
}

void moving_note_fixed(const moving *m, moving_domain *d, uint64_t n)
{
    for (uint32_t k = 0; k < FIXED; ++k)
        d->places[n + k] = (domain_place){.id = m->n_all + k};
}

void moving_note_places(const moving *m, moving_domain *d, duet_error *own)
{
    if (!moving_reserve_places(d, d->bodies.n, own))
        return;
    moving_note_fixed(m, d, d->bodies.n);
    for (uint64_t i = 0; i < d->bodies.n; ++i)
        d->places[i] = moving_place_of(d, &d->bodies.rows[i], &d->motion->bodies[i]);
}

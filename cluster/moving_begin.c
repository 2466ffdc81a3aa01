// SPDX-License-Identifier: MIT
// A scene's bodies are divided among domains. Each rank reads all of it and makes motions of all of
// it, so that what follows from the whole scene (effects, margins, substeps, the partition) is the
// same on all ranks; then each motion keeps its domain's bodies.
#include "cluster/moving_domains.h"

#include "base/error.h"

#include <stdlib.h>

// ---------------------------------------------------------------- motions

static bool check_effects(const duet_motion *motion, const char *scene, duet_error *own)
{
    const uint32_t contact = DUET_EFFECT_CONTACT | DUET_EFFECT_CONTACT_RESPONSE;
    return (motion->effects & contact) != DUET_EFFECT_CONTACT ||
           error_set(own, DUET_STATUS_BAD_ARGUMENT,
                     "%s: contact without response is not for several domains yet; expected "
                     "contact_response in wants",
                     scene);
}

static duet_motion_def def_of(const duet_scene *scene, const moving_start *start)
{
    duet_motion_def def = duet_scene_motion_def(scene, start->pair);
    if (start->plan)
        def.plan = *start->plan;
    return def;
}

static bool open_motions(moving *m, const moving_start *start, duet_error *own)
{
    m->def = def_of(m->scene, start);
    for (uint32_t k = 0; k < m->parts; ++k) {
        moving_domain *d = &m->domains[k];
        d->number = (uint32_t)m->ranks->self * m->parts + k;
        d->motion = duet_motion_create_from_scene(&m->def, m->scene, NULL, own);
        if (!d->motion)
            return false;
    }
    return check_effects(m->domains[0].motion, duet_scene_get_info(m->scene)->name, own) &&
           (!start->resume || moving_load(m, start->resume, own)) &&
           (m->n_domains == 1 || domain_begin_apart(m->domains[0].motion, own));
}

// ---------------------------------------------------------------- the partition

static bool cut(moving *m, const item_list *bodies, duet_error *own)
{
    bisection_point *points = malloc((bodies->n + 1) * sizeof *points);
    if (!points)
        return error_set(own, DUET_STATUS_NO_MEMORY, "a partition: no memory");
    for (uint64_t i = 0; i < bodies->n; ++i) {
        points[i].weight = 1;
        moving_centre(m, moving_body_at(m, bodies, i), points[i].at);
    }
    bool ok = bisection_begin(&m->cuts, m->n_domains, own);
    if (ok)
        bisection_cut(&m->cuts, NULL, points, bodies->n);
    free(points);
    return ok;
}

// Keeps the contacts that are for this rank's domains. Rank 0 has them all; the first domain of
// each rank lists the whole motion's, as if all bodies were its own.
static void divide_contacts(moving *m, item_list *contacts, duet_error *own)
{
    const moving_domain *first = &m->domains[0];
    uint64_t kept = 0;
    if (!moving_pushes(m))
        return;
    moving_read_contacts(m, first, contacts, own);
    for (uint64_t i = 0; is_well(own) && !contacts->failed && i < contacts->n; ++i) {
        moving_contact *c = moving_contact_at(m, contacts, i);
        c->told = c->told && m->counts.step > 0; // nothing touched before
        if (c->domain / m->parts == (uint32_t)m->ranks->self)
            memmove(moving_contact_at(m, contacts, kept++), c, m->contact_bytes);
    }
    contacts->n = kept;
}

// Gives this rank's domains their own of all bodies, which the first one has.
static bool divide(moving *m, item_list *contacts, duet_error *own)
{
    bool ok = cut(m, &m->domains[0].bodies, own);
    if (ok)
        divide_contacts(m, contacts, own);
    item_list all = m->domains[0].bodies;
    m->domains[0].bodies = (item_list){0};
    ok = ok && is_well(own);
    for (uint64_t i = 0; ok && i < all.n; ++i) {
        moving_body *b = moving_body_at(m, &all, i);
        b->own = b->domain = moving_domain_of(m, b);
        if (b->own / m->parts != (uint32_t)m->ranks->self)
            continue;
        moving_domain *to = &m->domains[b->own % m->parts];
        list_add(&to->bodies, b, 1, m->body_bytes);
        ok = !to->bodies.failed ||
             error_set(own, DUET_STATUS_NO_MEMORY, "a domain's bodies: no memory");
    }
    free(all.items);
    return ok;
}

static bool list_all(moving *m, duet_error *own)
{
    item_list *all = &m->domains[0].bodies;
    const duet_motion *motion = m->domains[0].motion;
    all->items = calloc((size_t)m->n_all + 1, m->body_bytes);
    if (!all->items)
        return error_set(own, DUET_STATUS_NO_MEMORY, "%u bodies: no memory", m->n_all);
    all->n = all->capacity = m->n_all;
    for (uint32_t i = 0; i < m->n_all; ++i) {
        moving_body *b = moving_body_at(m, all, i);
        b->id = i;
        b->own = m->domains[0].number;
        b->pose = motion->poses[i];
        b->body = motion->bodies[i];
    }
    moving_read_bodies(m, &m->domains[0], own);
    return is_well(own);
}

// ---------------------------------------------------------------- all of it

static bool load(moving *m, const moving_start *start, item_list *contacts, duet_error *own)
{
    m->scene = duet_scene_load(start->path, start->settings, start->n_settings, own);
    if (!m->scene)
        return false;
    m->domains = calloc(m->parts, sizeof *m->domains);
    if (!m->domains)
        return error_set(own, DUET_STATUS_NO_MEMORY, "%u domains: no memory", m->parts);
    if (!open_motions(m, start, own))
        return false;
    const duet_motion *first = m->domains[0].motion;
    m->n_all = first->n;
    m->counts.bodies = m->n_all;
    m->body_bytes = sizeof(moving_body) + domain_state_bytes(first);
    m->contact_bytes = sizeof(moving_contact) + first->layout.record * sizeof(float);
    return list_all(m, own) && divide(m, contacts, own);
}

moving *moving_begin(ranks *r, const moving_start *start, duet_error *own)
{
    moving *m = calloc(1, sizeof *m);
    item_list contacts = {0};
    if (!m)
        error_set(own, DUET_STATUS_NO_MEMORY, "a motion over ranks: no memory");
    if (!ranks_agree(r, is_well(own), own)) {
        free(m);
        return NULL;
    }
    m->ranks = r;
    m->parts = start->parts;
    m->n_domains = m->parts * (uint32_t)r->n;
    ranks_await_turn(r, true); // one rank of a host builds kernels
    load(m, start, &contacts, own);
    ranks_end_turn(r);
    bool ok = ranks_agree(r, is_well(own), own) && moving_exchange(m, &contacts, own);
    free(contacts.items);
    if (ok)
        return m;
    moving_end(m);
    return NULL;
}

void moving_end(moving *m)
{
    if (!m)
        return;
    for (uint32_t k = 0; m->domains && k < m->parts; ++k) {
        duet_motion_destroy(m->domains[k].motion);
        free(m->domains[k].bodies.items);
        free(m->domains[k].contacts.items);
        free(m->domains[k].used);
        free(m->domains[k].in_order.rows);
    }
    free(m->domains);
    halo_end(&m->halo);
    moving_events_end(&m->events);
    bisection_end(&m->cuts);
    duet_scene_destroy(m->scene);
    free(m);
}

moving_counts moving_get_counts(const moving *m)
{
    return m->counts;
}

duet_motion *moving_get_motion(const moving *m, uint32_t k)
{
    return m->domains[k].motion;
}

void moving_get_own_ids(const moving *m, uint32_t k, uint64_t *ids)
{
    const moving_domain *d = &m->domains[k];
    for (uint64_t i = 0; i < d->bodies.n; ++i) {
        const moving_body *b = moving_body_at(m, &d->bodies, i);
        ids[i] = moving_is_own(d, b) ? b->id : DUET_NO_BODY;
    }
}

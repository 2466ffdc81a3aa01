// SPDX-License-Identifier: MIT
// How far each domain reaches. Its ghosts are the bodies of others whose bounds meet its reach.
// They are chosen anew once one of its own bodies leaves the reach, or a body of another domain
// comes.
#include "cluster/moving_domains.h"

#include "base/error.h"

#include <math.h>

void moving_round_extent(const moving *m, const extent *e, bool inward, float to[6])
{
    for (int k = 0; k < 3; ++k) {
        const double lower = e->lower[k], upper = e->upper[k];
        to[k] = (float)lower;
        to[k + 3] = (float)upper;
        if (inward ? to[k] < lower : to[k] > lower)
            to[k] = nextafterf(to[k], inward ? INFINITY : -INFINITY);
        if (inward ? to[k + 3] > upper : to[k + 3] < upper)
            to[k + 3] = nextafterf(to[k + 3], inward ? -INFINITY : INFINITY);
    }
    if (m->def.dims == 2) {
        to[2] = -INFINITY;
        to[5] = INFINITY;
    }
}

// ---------------------------------------------------------------- when bodies are exchanged

// The far boxes of a domain's own bodies that act: only these have contacts that change or tell
// something.
static extent reach_of(const moving *m, const moving_domain *d)
{
    extent reach = d->reach;
    for (uint64_t i = 0; i < d->n_came_own; ++i) {
        const moving_traveller *t = moving_traveller_at(m, &d->came, i);
        const extent box = extent_of_box(t->far_box);
        if (t->body.acts)
            extent_join(&reach, &box);
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

static void list_neighbours(const moving *m, moving_domain *d, duet_error *own)
{
    list_clear(&d->neighbours.list);
    for (uint32_t k = 0; k < m->n_domains; ++k)
        if (k != d->number && extents_meet(&m->reaches[k], &m->reaches[d->number]))
            row_list_add(&d->neighbours, k);
    if (d->neighbours.failed)
        no_memory(own, "%u domains", m->n_domains);
}

bool moving_find_reaches(moving *m, duet_error *own)
{
    extent *here = calloc(m->parts, sizeof *here);
    if (!m->reaches)
        m->reaches = calloc(m->n_domains, sizeof *m->reaches);
    if (!here || !m->reaches)
        no_memory(own, "%u domains", m->n_domains);
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

// ---------------------------------------------------------------- until they are exchanged anew

bool moving_stays(const moving *m, const moving_domain *d, const extent *old, const extent *now)
{
    if (extent_within(now, old))
        return true;
    bool stays = extent_within(now, &m->reaches[d->number]);
    for (uint64_t i = 0; stays && i < d->neighbours.n; ++i) {
        const extent *reach = &m->reaches[d->neighbours.rows[i]];
        stays = !extents_meet(now, reach) || extents_meet(old, reach);
    }
    return stays;
}

static extent extent_of_bounds(const moving *m, const float bounds[6])
{
    extent e = extent_of_box(bounds);
    if (m->def.dims == 2)
        e.lower[2] = e.upper[2] = 0.0;
    return e;
}

// The far boxes of bodies that the device listed, to be freed.
static float *read_far_boxes(const moving_domain *d, const domain_near *near, uint32_t n,
                             duet_error *own)
{
    uint32_t *places = malloc((n + 1) * sizeof *places);
    float *boxes = malloc((6 * (size_t)n + 1) * sizeof *boxes);
    if (!places || !boxes)
        no_memory(own, "the bounds of %u bodies", n);
    for (uint32_t i = 0; places && i < n; ++i)
        places[i] = near[i].place;
    if (is_well(own))
        domain_pack_rows(d->motion, FAR_BOXES, NULL, places, n, boxes, own);
    free(places);
    return boxes;
}

static bool all_stay(const moving *m, const moving_domain *d, const domain_near *near, uint32_t n,
                     duet_error *own)
{
    float *boxes = read_far_boxes(d, near, n, own);
    bool stay = is_well(own);
    for (uint32_t i = 0; stay && i < n; ++i) {
        const extent old = extent_of_bounds(m, boxes + 6 * (size_t)i),
                     now = extent_of_bounds(m, near[i].bounds);
        stay = moving_stays(m, d, &old, &now);
    }
    free(boxes);
    return stay;
}

// The device looks for bodies that may have left, which are near borders.
static bool list_near(const moving *m, const moving_domain *d, domain_near **near, uint32_t *n,
                      duet_error *own)
{
    const uint32_t n_extents = (uint32_t)d->neighbours.n + 1;
    float(*extents)[6] = malloc(n_extents * sizeof *extents);
    if (!extents)
        return no_memory(own, "the bounds of bodies");
    moving_round_extent(m, &m->reaches[d->number], true, extents[0]);
    for (uint32_t i = 1; i < n_extents; ++i)
        moving_round_extent(m, &m->reaches[d->neighbours.rows[i - 1]], false, extents[i]);
    bool ok = domain_list_near(d->motion, extents[0], n_extents, near, n, own);
    free(extents);
    return ok;
}

bool moving_has_all_pairs(const moving *m, const moving_domain *d, duet_error *own)
{
    domain_near *near = NULL;
    uint32_t n = 0;
    if (domain_is_bounded(d->motion))
        return true;
    bool stay = list_near(m, d, &near, &n, own) && all_stay(m, d, near, n, own);
    free(near);
    return stay;
}

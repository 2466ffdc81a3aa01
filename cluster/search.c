// SPDX-License-Identifier: MIT
// The sets that a rank's workers search, in which order, and beside what.
#include "cluster/cluster.h"

#include "base/error.h"
#include "runtime/opencl/thread_pool.h"

#include <math.h>

// ---------------------------------------------------------------- one search

// Whether pairs of several domains are listed, because each is gone once the next one is copied.
static bool lists_copies(const duet_cluster *c)
{
    return c->search == SEARCH_COPIES && !c->def.drops_pairs;
}

static void search_set_now(void *search)
{
    set_search *s = search;
    s->ok = search_set_find(s->set, s->worker, s->counts, &s->found, &s->err);
}

// Begins to search a set, by a thread of `beside`; NULL: at once.
static void begin_search(duet_cluster *c, int i, thread_pool *beside)
{
    set_search *s = &c->searches[i];
    *s = (set_search){.set = &c->sets[i], .worker = c->workers[i], .beside = beside};
    s->counts = !lists_copies(c);
    if (beside)
        thread_pool_begin_call(beside, search_set_now, s);
    else
        search_set_now(s);
}

// Waits for it. It may be under way or over, or never have begun.
static bool end_search(set_search *s, duet_error *err)
{
    if (s->beside)
        thread_pool_end_call(s->beside);
    s->beside = NULL;
    return s->ok || error_copy(err, &s->err);
}

static bool count(duet_cluster *c, int i, duet_error *err)
{
    const set_search *s = &c->searches[i];
    return own_pairs_add(&c->own, s->set, &s->found, err);
}

// ---------------------------------------------------------------- inner and boundary

// Whether the domain can be searched while ghosts are exchanged: few objects lie at the boundary.
// With one thread nothing is gained.
static bool can_overlap(const duet_cluster *c)
{
    const owned *o = &c->owned;
    return o->n_domains == 1 && c->ranks.n > 1 && c->threads.n > 1 && c->step != STEP_COLD &&
           o->holder && o->boundary.n < o->rows.n / 4;
}

// Opens the second worker. Without it there is one search, of objects and ghosts.
static bool has_boundary_worker(duet_cluster *c)
{
    duet_world_def def = c->def.world;
    duet_error ignored;
    def.plan = c->workers[0]->plan(c->workers[0]);
    if (!c->workers[1])
        c->workers[1] = cluster_open_worker(c, &def, &ignored);
    return c->workers[1];
}

// Tells the workers if the objects lie elsewhere than before.
static void follow(duet_cluster *c)
{
    if (!extent_has_moved(&c->owned.fitted, &c->owned.around))
        return;
    for (int i = 0; i < 2; ++i)
        if (c->workers[i])
            c->workers[i]->forget_grids(c->workers[i]);
    c->owned.fitted = c->owned.around;
}

void cluster_choose_search(duet_cluster *c, bool may_overlap)
{
    duet_error ignored;
    c->search = c->owned.n_domains > 1 ? SEARCH_COPIES : SEARCH_WHOLE;
    if (!may_overlap || !can_overlap(c) || !has_boundary_worker(c) ||
        !search_set_inner(&c->sets[0], &c->owned, &c->ranks, &ignored))
        return;
    c->search = SEARCH_OVERLAPPED;
    follow(c);
    begin_search(c, 0, c->threads.team);
}

bool cluster_fill_sets(duet_cluster *c, duet_error *err)
{
    const owned *o = &c->owned;
    follow(c);
    if (!ghosts_sort(&c->ghosts, o, &c->ranks, err) ||
        (o->n_domains > 1 && !owned_sort_runs(&c->owned, err)))
        return false;
    if (c->search == SEARCH_WHOLE)
        return search_set_in_place(&c->sets[0], &c->owned, &c->ghosts, &c->ranks, err);
    return c->search != SEARCH_OVERLAPPED ||
           search_set_copy_boundary(&c->sets[1], o, &c->ghosts, &c->ranks, c->workers[1], err);
}

static bool search_overlapped(duet_cluster *c, duet_error *err)
{
    bool ok = is_well(err);
    if (ok && !c->searches[0].beside)
        begin_search(c, 0, c->threads.team);
    if (ok)
        begin_search(c, 1, NULL);
    ok = ok && end_search(&c->searches[1], err);
    ok = end_search(&c->searches[0], ok ? err : NULL) && ok;
    return ok && count(c, 0, err) && count(c, 1, err);
}

// ---------------------------------------------------------------- domains in turn

static bool copy_domain(duet_cluster *c, int i, uint32_t d, duet_error *err)
{
    worker *w = c->workers[i];
    return w->use_grid(w, d, err) &&
           search_set_copy_domain(&c->sets[i], &c->owned, &c->ghosts, &c->ranks, d, w, err);
}

// While a domain is searched the next one is copied, and the pairs of the one before are counted.
static bool search_copies(duet_cluster *c, duet_error *err)
{
    uint32_t n = c->owned.n_domains;
    thread_pool *beside = c->ranks.simulation ? NULL : c->threads.team;
    bool ok = copy_domain(c, 0, 0, err);
    for (uint32_t d = 0; ok && d < n; ++d) {
        int now = (int)(d % 2);
        begin_search(c, now, beside);
        ok = (d == 0 || count(c, 1 - now, err)) &&
             (d + 1 == n || copy_domain(c, 1 - now, d + 1, err));
        ok = end_search(&c->searches[now], ok ? err : NULL) && ok;
    }
    return ok && count(c, (int)((n - 1) % 2), err);
}

bool cluster_show_domain(duet_cluster *c, duet_error *err)
{
    const owned *o = &c->owned;
    uint32_t largest = 0;
    bool ok = true;
    for (uint32_t d = 1; d < o->n_domains; ++d)
        largest = o->domains[d].n > o->domains[largest].n ? d : largest;
    for (int i = 0; ok && o->n_domains > 1 && i < 2; ++i)
        ok = copy_domain(c, i, largest, err);
    return ok;
}

// ---------------------------------------------------------------- all of them

bool cluster_search_all(duet_cluster *c, duet_error *own)
{
    own_pairs_begin(&c->own, lists_copies(c));
    if (c->search == SEARCH_OVERLAPPED)
        return search_overlapped(c, own);
    if (!is_well(own))
        return false;
    if (c->search == SEARCH_COPIES)
        return search_copies(c, own);
    begin_search(c, 0, NULL);
    return end_search(&c->searches[0], own) && count(c, 0, own);
}

void cluster_cancel_search(duet_cluster *c)
{
    end_search(&c->searches[0], NULL);
}

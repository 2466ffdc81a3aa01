// SPDX-License-Identifier: MIT
// A step of a cluster is a list of phases. Ranks agree before objects travel, and after they
// searched: a failure of one rank in between ends the step of all at the next agreement.
//
//   migrate           objects go to the rank whose box holds them                  migrate.c
//   search the inner  a single domain, while ghosts travel, if its devices can     search_set.c
//   exchange ghosts   what other domains' objects may touch goes there             ghosts.c
//   search            each domain with its ghosts, or the boundary                 search_set.c
//   count             this rank's pairs, and all ranks' sums                       own_pairs.c
#include "cluster/cluster.h"

#include "base/budget.h"
#include "base/error.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static double ms_since(uint64_t begun_ns)
{
    return (double)(ranks_now_ns() - begun_ns) * 1e-6;
}

// ---------------------------------------------------------------- one search

static void search_set_now(void *search)
{
    set_search *s = search;
    s->ok = search_set_find(s->set, s->worker, s->counts, &s->found, &s->err);
}

// Begins to search a set, by a thread of `beside`; NULL: at once.
static void begin_search(duet_cluster *c, int i, parallel *beside)
{
    set_search *s = &c->searches[i];
    *s = (set_search){.set = &c->sets[i], .worker = c->workers[i], .beside = beside};
    s->counts = !c->own.lists;
    if (beside)
        parallel_call_begin(beside, search_set_now, s);
    else
        search_set_now(s);
}

// Waits for it. It may be under way or over, or never have begun.
static bool end_search(set_search *s, duet_error *err)
{
    if (s->beside)
        parallel_call_end(s->beside);
    s->beside = NULL;
    return s->ok || error_copy(err, &s->err);
}

static bool count(duet_cluster *c, int i, duet_error *err)
{
    const set_search *s = &c->searches[i];
    return own_pairs_add(&c->own, s->set, &s->found, err);
}

// ---------------------------------------------------------------- inner and boundary

// Whether devices with memory of their own can search the domain while the host exchanges ghosts,
// and few objects lie at the boundary. With one thread nothing is gained.
static bool can_overlap(const duet_cluster *c)
{
    const owned *o = &c->owned;
    return o->n_domains == 1 && c->ranks.n > 1 && c->threads.n > 1 && c->step != STEP_COLD &&
           o->holder && cluster_spares_host(c) && o->boundary.n < o->rows.n / 4;
}

// Opens the second worker. Without it there is one search, of objects and ghosts.
static bool has_boundary_worker(duet_cluster *c)
{
    duet_world_def def = c->def.world;
    duet_error unheard;
    def.plan = c->workers[0]->plan(c->workers[0]);
    if (!c->workers[1])
        c->workers[1] = cluster_open_worker(c, &def, &unheard);
    return c->workers[1];
}

// Whether the objects moved so far that a new grid pays: by a quarter of the width that they take,
// on any side.
static bool have_moved(const owned *o)
{
    bool moved = false;
    for (int k = 0; k < 3; ++k) {
        double far = 0.25 * (o->fitted.upper[k] - o->fitted.lower[k]);
        moved = moved || fabs(o->around.lower[k] - o->fitted.lower[k]) > far ||
                fabs(o->around.upper[k] - o->fitted.upper[k]) > far;
    }
    return moved;
}

// Tells the workers if the objects lie elsewhere than before.
static void follow(duet_cluster *c)
{
    if (!have_moved(&c->owned))
        return;
    for (int i = 0; i < 2; ++i)
        if (c->workers[i])
            c->workers[i]->forget_grids(c->workers[i]);
    c->owned.fitted = c->owned.around;
}

static void choose_search(duet_cluster *c, bool may_overlap)
{
    duet_error unheard;
    c->search = c->owned.n_domains > 1 ? SEARCH_COPIES : SEARCH_WHOLE;
    if (!may_overlap || !can_overlap(c) || !has_boundary_worker(c) ||
        !search_set_inner(&c->sets[0], &c->owned, &c->ranks, &unheard))
        return;
    c->search = SEARCH_OVERLAPPED;
    follow(c);
    begin_search(c, 0, &c->threads);
}

static bool search_overlapped(duet_cluster *c, bool ok, duet_error *err)
{
    if (ok && !c->searches[0].beside)
        begin_search(c, 0, &c->threads);
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
    parallel *beside = c->ranks.simulation ? NULL : &c->threads;
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

// ---------------------------------------------------------------- settling

static bool take_ghosts(duet_cluster *c, duet_error *err)
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

// Brings objects and ghosts to where they belong, on all ranks or on none. *settled: whether this
// rank is well, which may fail alone at the end.
static bool settle(duet_cluster *c, bool may_overlap, bool *settled, duet_error *own)
{
    bool are_new = c->owned.widest == 0; // and all of them travel
    uint64_t begun_ns = ranks_now_ns(), n = c->migration.n_partitions;
    *settled = true;
    bool ok = migrate(&c->migration, &c->ranks, settled, own);
    if (c->migration.n_partitions > n)
        balance_begin(&c->balance, are_new ? 0 : ms_since(begun_ns));
    if (ok && *settled)
        choose_search(c, may_overlap);
    ok = ok && ghosts_exchange(&c->ghosts, &c->owned, &c->ranks, *settled, own);
    if (ok)
        *settled = take_ghosts(c, own);
    return ok;
}

// Begins a call that needs all objects where they belong, and settles them if any rank's changed.
static bool begin_settled(duet_cluster *c, const char *call, bool may_overlap, bool ok,
                          bool *settled, duet_error *own)
{
    tally t = {.sums = {c->state == STATE_CHANGED || c->migration.unevenness == 0}};
    *settled = true;
    if (!ranks_agree_on(&c->ranks, call, ok, &t, own))
        return false;
    if (t.sums[0] == 0)
        return true;
    c->state = STATE_CHANGED; // until all of it is done, on all ranks
    own_pairs_begin(&c->own, false);
    return settle(c, may_overlap, settled, own);
}

bool cluster_settle_all(duet_cluster *c, const char *call, bool ok, duet_error *own,
                        duet_error *err)
{
    bool settled;
    ok = begin_settled(c, call, false, ok, &settled, own) && ranks_agree(&c->ranks, settled, own);
    if (ok && c->state == STATE_CHANGED)
        c->state = STATE_SETTLED;
    return ok || error_copy(err, own);
}

bool cluster_open_owned(duet_cluster *c, const char *call, bool ok, duet_error *own)
{
    owned *o = &c->owned;
    bool settled;
    if (!begin_settled(c, call, false, ok, &settled, own) && own->status != DUET_STATUS_BAD_OBJECT)
        return false;
    c->state = STATE_CHANGED;
    if (settled)
        owned_tidy(o);
    return ranks_agree(&c->ranks, settled && owned_map(o, own), own);
}

// ---------------------------------------------------------------- the step

static bool search_all(duet_cluster *c, bool ok, duet_error *own)
{
    own_pairs_begin(&c->own, c->search == SEARCH_COPIES && !c->def.drops_pairs);
    if (c->search == SEARCH_OVERLAPPED)
        return search_overlapped(c, ok, own);
    if (!ok || c->search == SEARCH_COPIES)
        return ok && search_copies(c, own);
    begin_search(c, 0, NULL);
    return end_search(&c->searches[0], own) && count(c, 0, own);
}

// The first time one rank of a host builds kernels, which the others then find in the cache. t
// becomes the sums that a result has, and how many ranks are asked to stop.
static bool find(duet_cluster *c, bool ok, tally *t, duet_error *own)
{
    if (c->step == STEP_COLD)
        ranks_await_turn(&c->ranks, owned_count(&c->owned) > 0);
    ok = search_all(c, ok, own);
    if (c->step == STEP_COLD)
        ranks_end_turn(&c->ranks);
    c->step = STEP_ENDED;
    if (ok && c->owned.n_domains == 1 && owned_count(&c->owned) > 0)
        owned_forget_renamed(&c->owned);
    *t = (tally){.sums = {c->ranks.stands_for * owned_count(&c->owned), c->own.n, c->own.hash,
                          !budget_check_stop(NULL)}};
    return ranks_agree_and(&c->ranks, ok, t, own);
}

// If weights are not given they follow from the steps. One that partitioned, or that may have built
// kernels, is no measure of others.
static void balance_ranks(duet_cluster *c, bool is_typical)
{
    if (is_typical && c->def.weight == 0 &&
        balance_note(&c->balance, &c->ranks, &c->partition, c->last.busy_ms,
                     owned_count(&c->owned)))
        c->migration.unevenness = 0;
}

static void keep_times(duet_cluster *c, uint64_t begun_ns)
{
    double total_ms = ms_since(begun_ns);
    double wait_ms = (double)c->ranks.wait_ns * 1e-6;
    uint64_t stands_for = c->ranks.stands_for;
    duet_cluster_rank *last = &c->last;
    *last = (duet_cluster_rank){.objects = stands_for * owned_count(&c->owned),
                                .ghosts = stands_for * ghosts_of_others(&c->ghosts, &c->ranks),
                                .pairs = c->own.n,
                                .sent_bytes = c->ranks.sent_bytes,
                                .busy_ms = fmax(total_ms - wait_ms, 0),
                                .wait_ms = wait_ms};
    snprintf(last->host, sizeof last->host, "%.63s", c->ranks.host_name);
    snprintf(last->pair, sizeof last->pair, "%s", c->workers[0]->name);
}

// Closes a boundary's worker, whose plan or level may be another than the first one's.
static void begin_cold(duet_cluster *c)
{
    if (cluster_workers(c) == 2 || !c->workers[1])
        return;
    c->workers[1]->close(c->workers[1]);
    c->workers[1] = NULL;
    c->state = c->search == SEARCH_OVERLAPPED ? STATE_CHANGED : c->state;
}

bool duet_cluster_step(duet_cluster *c, duet_cluster_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    tally t;
    bool settled = true, ok = error_given(result, __func__, "result", &own);
    bool was_cold = c->step == STEP_COLD;
    uint64_t begun_ns = ranks_now_ns(), n_partitions = c->migration.n_partitions;
    c->ranks.wait_ns = c->ranks.sent_bytes = 0;
    if (was_cold)
        begin_cold(c);
    parallel_be_keen(&c->threads, cluster_spares_host(c));
    ok = begin_settled(c, __func__, true, ok, &settled, &own) && find(c, settled, &t, &own);
    if (!ok) {
        end_search(&c->searches[0], NULL);
        c->state = STATE_CHANGED;
        own_pairs_end(&c->own);
        return error_copy(err, &own);
    }
    c->state = c->own.lists ? STATE_LISTED : STATE_FOUND;
    c->step = t.sums[3] > 0 ? STEP_STOPPED : STEP_ENDED;
    keep_times(c, begun_ns);
    double total_ms = ms_since(begun_ns);
    ranks_greatest(&c->ranks, &total_ms, 1);
    *result = (duet_cluster_result){
        .objects = t.sums[0], .pairs = t.sums[1], .hash = t.sums[2], .total_ms = total_ms};
    balance_ranks(c, !was_cold && c->migration.n_partitions == n_partitions);
    return true;
}

// SPDX-License-Identifier: MIT
// A step of a cluster is a list of phases. Ranks agree before objects travel, and after they
// searched: a failure of one rank in between ends the step of all at the next agreement.
//
//   migrate           objects go to the rank whose box holds them                  migrate.c
//   search the inner  a single domain, while ghosts travel, if its devices can     search.c
//   exchange ghosts   what other domains' objects may touch goes there             ghosts.c
//   search            each domain with its ghosts, or the boundary                 search.c
//   count             this rank's pairs, and all ranks' sums                       own_pairs.c
#include "cluster/cluster.h"

#include "base/budget.h"
#include "base/error.h"
#include "cluster/ghost_traffic.h"

#include <math.h>
#include <stdio.h>

static double ms_since(uint64_t begun_ns)
{
    return (double)(ranks_now_ns() - begun_ns) * 1e-6;
}

// ---------------------------------------------------------------- settling

static bool migrate_objects(duet_cluster *c, duet_error *own)
{
    bool are_new = c->owned.widest == 0; // and all of them travel
    uint64_t begun_ns = ranks_now_ns(), n = c->migration.n_partitions;
    bool ok = migrate(&c->migration, &c->ranks, own);
    if (c->migration.n_partitions > n)
        balance_begin(&c->balance, are_new ? 0 : ms_since(begun_ns));
    return ok;
}

// Brings objects and ghosts to where they belong, on all ranks or on none; after that this rank may
// fail alone.
static bool settle(duet_cluster *c, bool may_overlap, duet_error *own)
{
    if (!migrate_objects(c, own))
        return false;
    if (is_well(own))
        cluster_choose_search(c, may_overlap);
    if (!ghosts_exchange(&c->ghosts, &c->owned, &c->ranks, own))
        return false;
    cluster_fill_sets(c, own);
    return true;
}

// Begins a call that needs all objects where they belong, and settles them if any rank's changed.
static bool begin_settled(duet_cluster *c, const char *call, bool may_overlap, duet_error *own)
{
    tally t = {.sums = {c->state == STATE_CHANGED || c->migration.unevenness == 0}};
    if (!ranks_agree_on(&c->ranks, call, is_well(own), &t, own))
        return false;
    if (t.sums[0] == 0)
        return true;
    c->state = STATE_CHANGED; // until all of it is done, on all ranks
    return settle(c, may_overlap, own);
}

bool cluster_settle_all(duet_cluster *c, const char *call, duet_error *own, duet_error *err)
{
    bool ok = begin_settled(c, call, false, own) && ranks_agree(&c->ranks, is_well(own), own);
    if (ok && c->state == STATE_CHANGED)
        c->state = STATE_SETTLED;
    return ok || error_copy(err, own);
}

bool cluster_open_owned(duet_cluster *c, const char *call, duet_error *own)
{
    bool ok = begin_settled(c, call, false, own), are_bad = own->status == DUET_STATUS_BAD_OBJECT;
    if (!ok && !are_bad)
        return false;
    if (are_bad)
        *own = (duet_error){.calls = own->calls};
    c->state = STATE_CHANGED;
    if (is_well(own)) {
        owned_tidy(&c->owned);
        owned_map(&c->owned, own);
    }
    return ranks_agree(&c->ranks, is_well(own), own);
}

// ---------------------------------------------------------------- the step

// The first time one rank of a host builds kernels, which the others then find in the cache. t
// becomes the sums that a result has, and how many ranks are asked to stop.
static bool search(duet_cluster *c, tally *t, duet_error *own)
{
    const uint64_t n = owned_count(&c->owned);
    if (c->step == STEP_COLD)
        ranks_await_turn(&c->ranks, n > 0);
    bool ok = cluster_search_all(c, own);
    if (c->step == STEP_COLD)
        ranks_end_turn(&c->ranks);
    if (c->ranks.traffic && !ghost_traffic_take(c->ranks.traffic, &c->ghosts, &c->ranks, n, own))
        return false;
    c->step = STEP_ENDED;
    if (ok && c->owned.n_domains == 1 && n > 0)
        owned_forget_renamed(&c->owned);
    *t =
        (tally){.sums = {c->ranks.stands_for * n, c->own.n, c->own.hash, !budget_check_stop(NULL)}};
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
    if (c->owned.n_domains > 1 || !c->workers[1])
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
    error_given(result, __func__, "result", &own);
    bool was_cold = c->step == STEP_COLD;
    uint64_t begun_ns = ranks_now_ns(), n_partitions = c->migration.n_partitions;
    c->ranks.wait_ns = c->ranks.sent_bytes = 0;
    if (was_cold)
        begin_cold(c);
    const bool spares_host = cluster_spares_host(c);
    parallel_stay_awake(&c->threads, spares_host);
    if (!begin_settled(c, __func__, spares_host, &own) || !search(c, &t, &own)) {
        cluster_cancel_search(c);
        c->state = STATE_CHANGED;
        return error_copy(err, &own);
    }
    c->state = c->own.lists ? STATE_LISTED : STATE_FOUND;
    c->step = t.sums[3] > 0 ? STEP_STOPPED : STEP_ENDED;
    keep_times(c, begun_ns);
    double total_ms = ranks_greatest(&c->ranks, ms_since(begun_ns));
    *result = (duet_cluster_result){
        .objects = t.sums[0], .pairs = t.sums[1], .hash = t.sums[2], .total_ms = total_ms};
    balance_ranks(c, !was_cold && c->migration.n_partitions == n_partitions);
    return true;
}

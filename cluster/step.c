// SPDX-License-Identifier: MIT
// A step is a list of phases. Each ends on all ranks in the same way, so that what follows it
// is done by all or by none.
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

// ---------------------------------------------------------------- parts

// The part that comes i-th: first every other one, so that two that follow each other are seldom
// neighbours among the homes, where the ghosts of one lie in the other's place.
static uint32_t part_of_turn(const duet_cluster *c, uint32_t turn)
{
    uint32_t n_even = (c->parts.n + 1) / 2;
    return turn < n_even ? 2 * turn : 2 * (turn - n_even) + 1;
}

static bool fill_by_copies(duet_cluster *c, uint32_t turn, duet_error *own)
{
    sight from = parts_sight(&c->parts, part_of_turn(c, turn));
    return seen_fill(&c->seen[turn % 2], &c->homes, &from, c->workers[turn % 2], own);
}

static void lend_part(duet_cluster *c, uint32_t turn)
{
    worker *w = c->workers[turn % 2];
    seen *s = &c->seen[turn % 2];
    sight_in_place from = parts_sight_in_place(&c->parts, part_of_turn(c, turn));
    seen_in_place(s, &c->homes, &from);
    w->lend(w, s->rows.objects, s->rows.n);
    w->begin(w, s->rows.n, NULL);
}

// Parts take turns in the places that there are workers for.
static bool fill(duet_cluster *c, uint32_t turn, duet_error *own)
{
    uint32_t part = part_of_turn(c, turn);
    worker *w = c->workers[turn % 2];
    bool in_place = c->homes.n_ranges > 0;
    if (in_place)
        parts_open(&c->parts, &c->homes, part);
    if (c->filled[turn % 2] == part + 1)
        return true;
    c->filled[turn % 2] = 0;
    bool ok = !w->turn_to || w->turn_to(w, part, own);
    if (ok && in_place)
        lend_part(c, turn);
    else if (ok)
        ok = fill_by_copies(c, turn, own);
    c->filled[turn % 2] = ok ? part + 1 : 0;
    return ok;
}

static bool fill_by_ids(duet_cluster *c, duet_error *own)
{
    bool ok = parts_divide(&c->parts, &c->homes, &c->cut, &c->ranks, &c->ghosts.in, own);
    cluster_follow(c);
    for (int i = 0; ok && i < cluster_workers(c); ++i)
        ok = fill(c, (uint32_t)i, own);
    return ok;
}

// Without its ghosts, which others' homes are in the place of.
static bool lend_homes(duet_cluster *c, uint32_t part, worker *w, duet_error *own)
{
    sight_in_place from = parts_sight_in_place(&c->parts, part);
    if (w->turn_to && !w->turn_to(w, part, own))
        return false;
    w->lend(w, object_row(&c->homes.rows, &c->homes.form, from.first), from.n);
    return true;
}

// Within a part, homes lie as its worker has them best.
static bool cut_parts(duet_cluster *c, duet_error *own)
{
    if (!parts_cut_in_place(&c->parts, &c->homes, own))
        return false;
    cluster_follow(c);
    reordering memory = {0};
    bool ok = true;
    for (uint32_t i = 0; ok && i < c->parts.n; ++i) {
        worker *w = c->workers[i % 2];
        uint32_t part = part_of_turn(c, i);
        sight_in_place from = parts_sight_in_place(&c->parts, part);
        ok = lend_homes(c, part, w, own) &&
             homes_put_in_order(&c->homes, from.first, from.n, w, &memory, own);
    }
    reordering_end(&memory);
    return ok && homes_find_edges(&c->homes, &c->cut, own);
}

// So that each worker can be asked for its profile.
static bool lend_largest(duet_cluster *c, duet_error *own)
{
    uint32_t largest = parts_largest(&c->parts);
    return lend_homes(c, largest, c->workers[0], own) && lend_homes(c, largest, c->workers[1], own);
}

static bool fill_parts(duet_cluster *c, duet_error *own)
{
    bool even = true, ok;
    if (!walk_settle(c, own))
        return false;
    if (c->walk.done)
        return true;
    c->parts.is_cut_anew = false;
    ok = parts_look(&c->parts, &c->homes, &even, own);
    if (ok && !even)
        ok = cut_parts(c, own) && parts_look(&c->parts, &c->homes, &even, own);
    else
        cluster_follow(c);
    ok = ok && parts_settle(&c->parts, &c->homes, &c->ghosts.in, own);
    if (ok)
        homes_lock_ids(&c->homes);
    return ok && lend_largest(c, own);
}

static bool move_homes_in(duet_cluster *c, duet_error *own)
{
    worker *w = c->workers[0];
    if (!homes_move_in(&c->homes, w, own))
        return false;
    if (c->parts.n > 1)
        return true;
    reordering memory = {0};
    bool ok = homes_put_in_order(&c->homes, 0, c->homes.rows.n, w, &memory, own);
    reordering_end(&memory);
    return ok && w->map(w, c->homes.rows.n, own);
}

// Homes are where their worker has them.
static bool fill_in_place(duet_cluster *c, duet_error *own)
{
    if (!c->homes.holder && !move_homes_in(c, own))
        return false;
    if (c->parts.n > 1)
        return fill_parts(c, own);
    if (c->border.is_searching)
        return border_take_ghosts(c, own);
    cluster_follow(c);
    return seen_append(&c->seen[0], &c->homes, &c->ranks, &c->ghosts.in, own);
}

// ---------------------------------------------------------------- all to their places

// Brings homes and ghosts to where they belong, on all ranks or on none, and hands the first to
// this rank's workers. What fails in that is of this rank alone, and *settled is then false. Homes
// that left or came are known to both ranks where they lie in place on all, or on none: where
// one rank failed to bring its homes there, the others begin anew.
static bool settle(duet_cluster *c, uint64_t n_in_place, bool *settled, duet_error *own)
{
    bool in_place = seen_in_any_order(c->def.world.level);
    cluster_forget_found(c);
    memset(c->filled, 0, sizeof c->filled);
    c->walk.done = c->border.done = false;
    bool stay = in_place && n_in_place == (uint64_t)c->ranks.n;
    *settled = stay || !c->homes.holder || homes_move_out(&c->homes, own);
    bool are_new = c->homes.widest == 0; // and all of them travel
    uint64_t begun_ns = ranks_now_ns(), n_cuts = c->homes.n_cuts;
    bool ok = homes_settle(&c->homes, &c->ranks, &c->cut, c->def.imbalance, settled, own);
    if (c->homes.n_cuts > n_cuts)
        balance_begin(&c->balance, are_new ? 0 : ms_since(begun_ns));
    if (ok && *settled && stay && c->walk.wanted)
        border_begin(c);
    ok = ok && ghosts_exchange(&c->ghosts, &c->homes, &c->ranks, *settled, own);
    if (ok) {
        c->n_ghosts = c->ghosts.in.n + c->homes.n_gone;
        *settled = in_place ? fill_in_place(c, own) : fill_by_ids(c, own);
    }
    return ok;
}

// A call that needs all objects where they belong: begins it, and settles them. One that searches
// them, and may do so on the way, needs more than a step leaves that did.
static bool begin_settled(duet_cluster *c, const char *call, bool searches, bool ok, bool *settled,
                          duet_error *own)
{
    bool is_apart = c->walk.done || c->border.done;
    tally t = {.sums = {c->changed || (searches && is_apart), c->homes.holder != NULL}};
    c->walk.wanted = searches;
    *settled = true;
    if (!ranks_agree_on(&c->ranks, call, ok, &t, own))
        return false;
    if (t.sums[0] == 0)
        return true;
    c->changed = true; // until all of it is done, on all ranks
    return settle(c, t.sums[1], settled, own);
}

bool cluster_settle_all(duet_cluster *c, const char *call, bool ok, duet_error *own,
                        duet_error *err)
{
    bool settled;
    ok = begin_settled(c, call, false, ok, &settled, own) && ranks_agree(&c->ranks, settled, own);
    c->changed = c->changed && !ok;
    return ok || error_copy(err, own);
}

// ---------------------------------------------------------------- searching

global_ids cluster_ids_of_homes(const duet_cluster *c)
{
    const homes *h = &c->homes;
    return (global_ids){
        .list = h->rows.ids,
        .n = h->rows.n,
        .without = h->gone,
        .n_without = h->n_gone,
        .changed = h->renamed.rows,
        .n_changed = h->renamed.n,
        .all_changed = h->all_renamed || h->renamed.failed,
    };
}

// The ids of a part are told anew each time, and not where its pairs are listed.
static void begin_search(duet_cluster *c, uint32_t turn, worker_search *s)
{
    const seen *what = &c->seen[turn % 2];
    bool is_only = c->parts.n == 1;
    *s = (worker_search){.worker = c->workers[turn % 2], .seen = what};
    s->tells_ids = c->homes.holder && !c->own.lists;
    s->ids = is_only ? cluster_ids_of_homes(c)
                     : (global_ids){.list = what->rows.ids, .n = what->behind, .all_changed = true};
    worker_search_begin(s, is_only || c->ranks.simulation ? NULL : &c->threads);
    if (is_only && s->ok && seen_homes(what) > 0 && s->tells_ids)
        homes_forget_renamed(&c->homes);
}

// A search that has ended needs its ghosts no longer.
static bool leave(duet_cluster *c, uint32_t turn, worker_search *s, duet_error *own)
{
    bool ok = worker_search_end(s, own);
    if (c->homes.n_ranges > 0)
        parts_close(&c->parts, &c->homes, part_of_turn(c, turn));
    return ok;
}

// Nothing of any part is on its way any more.
static void give_up(duet_cluster *c)
{
    for (int i = 0; c->homes.n_ranges > 0 && i < cluster_workers(c); ++i)
        c->workers[i]->lend(c->workers[i], NULL, 0);
    for (uint32_t i = 0; c->homes.n_ranges > 0 && i < c->parts.n; ++i)
        parts_close(&c->parts, &c->homes, i);
    memset(c->filled, 0, sizeof c->filled);
}

// Whether a part cannot be written while the one before is searched.
static bool must_wait(const duet_cluster *c, uint32_t turn)
{
    return c->homes.n_ranges > 0 &&
           parts_clash(&c->parts, part_of_turn(c, turn - 1), part_of_turn(c, turn));
}

// While a part is searched the next one is written, and the pairs of the one before are taken.
static bool find_own(duet_cluster *c, duet_error *own)
{
    uint32_t n = c->parts.n;
    worker_search searches[2] = {{0}};
    bool ok = true;
    own_pairs_begin(&c->own, n > 1 && !c->def.drops_pairs);
    for (uint32_t i = 0; ok && i <= n; ++i) {
        worker_search *now = &searches[i % 2], *before = &searches[(i + 1) % 2];
        bool has_next = i < n, waits = has_next && i > 0 && must_wait(c, i);
        ok = !has_next || n == 1 || waits || fill(c, i, own);
        if (i > 0)
            ok = leave(c, i - 1, before, ok ? own : NULL) && ok;
        if (ok && waits)
            ok = own_pairs_add(&c->own, before->seen, &before->found, own) && fill(c, i, own);
        if (ok && has_next)
            begin_search(c, i, now);
        if (ok && i > 0 && !waits)
            ok = own_pairs_add(&c->own, before->seen, &before->found, own);
        if (!ok)
            worker_search_end(now, NULL);
    }
    if (!ok)
        give_up(c);
    c->is_found = ok && n == 1;
    c->found = searches[0].found;
    return ok;
}

// The first time one rank of a host builds kernels, which the others then find in the cache. t
// becomes the sums that a result has, and how many ranks are asked to stop.
static bool find(duet_cluster *c, bool ok, tally *t, duet_error *own)
{
    if (c->is_cold)
        ranks_await_turn(&c->ranks, homes_count(&c->homes) > 0);
    if (c->border.is_searching)
        ok = border_end(c, ok, own);
    else
        ok = ok && (c->walk.done ? walk_end(c, own) && lend_largest(c, own) : find_own(c, own));
    if (c->is_cold)
        ranks_end_turn(&c->ranks);
    c->is_cold = false;
    *t = (tally){.sums = {ranks_stand_for(&c->ranks) * homes_count(&c->homes), c->own.n,
                          c->own.hash, !budget_check_stop(NULL)}};
    return ranks_agree_and(&c->ranks, ok, t, own);
}

// ---------------------------------------------------------------- the step

// Where weights are not given they follow from the steps. One that cut, or that may have built
// kernels, is no measure of others.
static void balance_ranks(duet_cluster *c, bool is_typical)
{
    if (is_typical && c->def.weight == 0 &&
        balance_note(&c->balance, &c->ranks, &c->cut, c->last.busy_ms, homes_count(&c->homes))) {
        c->homes.is_cut = false;
        c->changed = true;
    }
}

static void keep_times(duet_cluster *c, uint64_t begun_ns)
{
    double total_ms = ms_since(begun_ns);
    double wait_ms = (double)c->ranks.wait_ns * 1e-6;
    uint64_t stands_for = ranks_stand_for(&c->ranks);
    duet_cluster_rank *last = &c->last;
    *last = (duet_cluster_rank){.objects = stands_for * homes_count(&c->homes),
                                .ghosts = stands_for * c->n_ghosts,
                                .pairs = c->own.n,
                                .sent_bytes = c->ranks.sent_bytes,
                                .busy_ms = fmax(total_ms - wait_ms, 0),
                                .wait_ms = wait_ms};
    snprintf(last->host, sizeof last->host, "%.63s", c->ranks.host_name);
    snprintf(last->pair, sizeof last->pair, "%s", c->workers[0]->name);
}

bool duet_cluster_step(duet_cluster *c, duet_cluster_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    tally t;
    bool settled = true, ok = error_given(result, __func__, "result", &own);
    bool was_cold = c->is_cold;
    uint64_t begun_ns = ranks_now_ns(), n_cuts = c->homes.n_cuts;
    c->ranks.wait_ns = c->ranks.sent_bytes = 0;
    if (was_cold) { // the plan or the level may be another
        c->changed |= c->border.done;
        border_close(&c->border);
    }
    parallel_be_keen(&c->threads,
                     c->workers[0]->spares_host && c->workers[0]->spares_host(c->workers[0]));
    ok = begin_settled(c, __func__, true, ok, &settled, &own) && find(c, settled, &t, &own);
    c->changed = c->changed && !ok;
    if (!ok) {
        if (c->border.is_searching)
            border_end(c, false, NULL);
        cluster_forget_found(c);
        own_pairs_end(&c->own);
        return error_copy(err, &own);
    }
    c->is_stopped = t.sums[3] > 0;
    keep_times(c, begun_ns);
    double total_ms = ms_since(begun_ns);
    ranks_greatest(&c->ranks, &total_ms, 1);
    balance_ranks(c, !was_cold && c->homes.n_cuts == n_cuts);
    *result = (duet_cluster_result){
        .objects = t.sums[0], .pairs = t.sums[1], .hash = t.sums[2], .total_ms = total_ms};
    return true;
}

// SPDX-License-Identifier: MIT
// A cluster is made, takes objects, and reports what its last step found.
#include "cluster/cluster.h"

#include "base/error.h"
#include "cluster/ids.h"
#include "cluster/moving.h"

#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7011, MOST_PARTS = 1024 };

// ---------------------------------------------------------------- owner

duet_cluster_def duet_default_cluster_def(void)
{
    return (duet_cluster_def){
        .world = duet_default_world_def(), .parts = 1, .imbalance = 1.2, .cookie = COOKIE};
}

static bool check_def(const duet_cluster_def *def, duet_error *err)
{
    if (def->world.has_accuracy)
        return bad_argument(
            err, "has_accuracy is for one world; expected a level, which all ranks share");
    if (def->world.keep_bad)
        return bad_argument(err, "keep_bad is for one world; expected false");
    if (def->world.pose_form)
        return bad_argument(err, "pose_form is for one world; expected DUET_POSE_WHOLE");
    if (def->parts < 1 || def->parts > MOST_PARTS)
        return bad_argument(err, "parts is %u; expected 1 to %d", def->parts, MOST_PARTS);
    return def->imbalance > 1 ||
           bad_argument(err, "imbalance is %g; expected a number above 1", def->imbalance);
}

void cluster_take_workers(duet_cluster *c, const duet_world_def *world, worker *workers[2])
{
    object_rows none = {0};
    owned_take(&c->owned, &none);
    cluster_close_workers(c->workers);
    memcpy(c->workers, workers, sizeof c->workers);
    c->def.world = *world;
    c->owned.form = object_form_of(world);
    c->state = STATE_CHANGED;
    c->step = STEP_COLD;
}

// If devices leave the processors to others, one thread waits for them and one does the rest.
static bool begin_threads(duet_cluster *c, duet_error *err)
{
    uint32_t least = cluster_spares_host(c) ? 2 : 1;
    return parallel_begin(&c->threads, c->ranks.processors, least, err);
}

duet_cluster *duet_cluster_create(const duet_cluster_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    return cluster_create(def, NULL, err);
}

duet_cluster *cluster_create(const duet_cluster_def *def, const simulation *s, duet_error *err)
{
    if (!def || def->cookie != COOKIE) {
        bad_argument(err, "the def of a cluster begins with duet_default_cluster_def");
        return NULL;
    }
    duet_error own = {0};
    worker *workers[2] = {NULL};
    duet_cluster *c = calloc(1, sizeof *c);
    if (!c)
        return null_no_memory(err, "a cluster");
    c->def = *def;
    double most_parts = def->parts < MOST_PARTS ? def->parts : MOST_PARTS;
    bool ok = ranks_begin(&c->ranks, def->comm, s, err);
    if (ok) {
        most_parts = ranks_greatest(&c->ranks, most_parts);
        c->migration.owned = &c->owned;
        c->migration.partition = &c->partition;
        c->migration.workers = c->workers;
        c->migration.imbalance = def->imbalance;
        ok = ranks_reserve(&c->ranks, &own) && check_def(def, &own) &&
             owned_begin(&c->owned, def->parts, (uint32_t)most_parts, &c->threads, &own) &&
             ghosts_begin(&c->ghosts, &c->owned, &c->ranks, &own) && cluster_open_pair(c, &own) &&
             cluster_open_workers(c, &c->def.world, workers, &own);
        if (ok)
            cluster_take_workers(c, &c->def.world, workers);
        ok = ok && begin_threads(c, &own);
        ok = ranks_agree(&c->ranks, ok, &own) &&
             partition_begin(&c->partition, &c->ranks, def->weight, &own);
        if (!ok)
            error_copy(err, &own);
    }
    if (!ok) {
        duet_cluster_destroy(c);
        return NULL;
    }
    return c;
}

void duet_cluster_destroy(duet_cluster *c)
{
    if (!c)
        return;
    ranks_await_end(&c->ranks, __func__);
    moving_end(c->moving);
    owned_end(&c->owned);
    classes_end(&c->migration.classes);
    cluster_close_workers(c->workers);
    duet_device_pair_destroy(c->own_pair);
    own_pairs_end(&c->own);
    for (int i = 0; i < 2; ++i)
        search_set_end(&c->sets[i]);
    ghosts_end(&c->ghosts);
    partition_end(&c->partition);
    parallel_end(&c->threads);
    ranks_end(&c->ranks);
    free(c->scene_name);
    free(c);
}

int duet_cluster_get_rank(const duet_cluster *c)
{
    return c ? c->ranks.self : -1;
}

int duet_cluster_get_rank_count(const duet_cluster *c)
{
    return c ? c->ranks.n : 0;
}

bool cluster_agree_on(duet_cluster *c, const char *call, bool ok, duet_error *own, duet_error *err)
{
    return ranks_agree_on(&c->ranks, call, ok, NULL, own) || error_copy(err, own);
}

// ---------------------------------------------------------------- objects

void cluster_take(duet_cluster *c, object_rows *rows)
{
    owned_take(&c->owned, rows);
    own_pairs_end(&c->own);
    c->state = STATE_CHANGED;
}

static bool check_kind(const duet_cluster *c, duet_object_kind kind, duet_error *err)
{
    duet_object_kind right = object_form_kind(&c->owned.form);
    static const char *const names[] = {[DUET_OBJECT_POSES] = "poses",
                                        [DUET_OBJECT_BOUNDS] = "bounds",
                                        [DUET_OBJECT_LARGE_POSES] = "large poses",
                                        [DUET_OBJECT_ROUNDED_BOXES] = "rounded boxes",
                                        [DUET_OBJECT_SPHERES] = "spheres"};
    return kind == right || bad_argument(err, "objects of kind %d; this cluster was made for %s",
                                         (int)kind, names[right]);
}

bool duet_cluster_set_objects(duet_cluster *c, duet_object_kind kind, const uint64_t *ids,
                              const void *objects, uint32_t n, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    object_rows rows = {0};
    bool ok = check_kind(c, kind, &own);
    ok = ok && (n == 0 || (error_given(ids, __func__, "ids", &own) &&
                           error_given(objects, __func__, "objects", &own)));
    ok = ok && object_rows_copy(&rows, &c->owned.form, ids, objects, n, &own);
    ok = ranks_agree_on(&c->ranks, __func__, ok, NULL, &own) &&
         ids_are_distinct(&c->ranks, rows.ids, rows.n, &own);
    if (ok)
        cluster_take(c, &rows);
    object_rows_end(&rows);
    return ok || error_copy(err, &own);
}

// ---------------------------------------------------------------- results

// Lists the pairs of a single domain, which its workers still have.
static bool list_found(duet_cluster *c, duet_error *err)
{
    set_search *s = c->searches;
    worker *w = c->workers[0];
    own_pairs_begin(&c->own, true);
    return (s[0].found.n_counted == 0 || w->bring(w, &s[0].found, err)) &&
           own_pairs_add(&c->own, s[0].set, &s[0].found, err) &&
           (c->search == SEARCH_WHOLE || own_pairs_add(&c->own, s[1].set, &s[1].found, err));
}

bool cluster_list_pairs(duet_cluster *c, duet_error *err)
{
    if (c->def.drops_pairs)
        return bad_argument(err,
                            "this cluster drops its pairs; expected a def without drops_pairs");
    if (c->state < STATE_FOUND)
        return bad_argument(err, "no pairs were found of the objects as they are; expected a step");
    if (c->state == STATE_FOUND)
        c->state = list_found(c, err) ? STATE_LISTED : STATE_SETTLED;
    return c->state == STATE_LISTED;
}

bool duet_cluster_get_own_pairs(duet_cluster *c, const duet_pair64 **pairs, uint64_t *n,
                                duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err) || !error_given(pairs, __func__, "pairs", err) ||
        !error_given(n, __func__, "n", err) || !cluster_list_pairs(c, err))
        return false;
    *pairs = c->own.pairs;
    *n = c->own.n;
    return true;
}

bool duet_cluster_get_ranks(duet_cluster *c, duet_cluster_rank *rows, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    if (!cluster_agree_on(c, __func__, error_given(rows, __func__, "ranks", &own), &own, err))
        return false;
    ranks_gather(&c->ranks, &c->last, rows, (int)sizeof c->last);
    return true;
}

// ---------------------------------------------------------------- between steps

void *duet_cluster_map_owned(duet_cluster *c, duet_object_kind kind, const uint64_t **ids,
                             uint32_t *n, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return NULL;
    duet_error own = {0};
    if (error_given(ids, __func__, "ids", &own) && error_given(n, __func__, "n", &own))
        check_kind(c, kind, &own);
    if (!cluster_open_owned(c, __func__, &own)) {
        error_copy(err, &own);
        return NULL;
    }
    *n = c->owned.rows.n;
    *ids = c->owned.rows.ids;
    return c->owned.rows.objects;
}

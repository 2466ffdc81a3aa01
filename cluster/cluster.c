// SPDX-License-Identifier: MIT
// A step is a list of phases. Each ends on all ranks in the same way, so that what follows it
// is done by all or by none.
#include "cluster/cluster.h"

#include "base/clock.h"
#include "base/error.h"
#include "cluster/ghosts.h"
#include "cluster/own_pair.h"
#include "runtime/scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7010 };

// ---------------------------------------------------------------- owner

duet_cluster_def duet_default_cluster_def(void)
{
    return (duet_cluster_def){
        .world = duet_default_world_def(), .weight = 1, .imbalance = 1.2, .cookie = COOKIE};
}

static bool check_def(const duet_cluster_def *def, duet_error *err)
{
    if (def->world.has_accuracy)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "has_accuracy is for one world; expected a level, which all ranks share");
    if (def->world.keep_bad)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "keep_bad is for one world; expected false");
    if (def->world.separate_sizes || def->world.compact_transforms)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s is for one world; expected false",
                         def->world.separate_sizes ? "separate_sizes" : "compact_transforms");
    return def->imbalance > 1 ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT, "imbalance is %g; expected a number above 1",
                     def->imbalance);
}

static bool open_worker(duet_cluster *c, duet_error *err)
{
    if (c->worker)
        c->worker->close(c->worker);
    c->worker =
        c->def.plain ? worker_open_plain(&c->def.world, err) : worker_open_pair(&c->def.world, err);
    c->homes.form = object_form_of(&c->def.world);
    c->changed = c->is_cold = true;
    return c->worker;
}

static bool open_pair(duet_cluster *c, duet_error *err)
{
    if (c->def.plain || c->def.world.pair)
        return true;
    c->own_pair = own_pair_open(&c->ranks, &c->def, err);
    c->def.world.pair = c->own_pair;
    return c->own_pair;
}

duet_cluster *duet_cluster_create(const duet_cluster_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE) {
        error_set(err, DUET_STATUS_BAD_ARGUMENT,
                  "the def of a cluster begins with duet_default_cluster_def");
        return NULL;
    }
    duet_error own = {0};
    duet_cluster *c = calloc(1, sizeof *c);
    if (!c) {
        error_set(err, DUET_STATUS_NO_MEMORY, "a cluster: no memory");
        return NULL;
    }
    c->def = *def;
    bool ok = ranks_begin(&c->ranks, def->comm, err);
    if (ok) {
        c->homes.threads = &c->threads;
        ok = parallel_begin(&c->threads, c->ranks.n_on_host, &own) && check_def(def, &own) &&
             open_pair(c, &own) && open_worker(c, &own);
        ok = ranks_agree(&c->ranks, ok, &own) && cut_begin(&c->cut, &c->ranks, def->weight, &own);
        if (!ok)
            error_set(err, own.status, "%s", own.text);
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
    if (c->worker)
        c->worker->close(c->worker);
    duet_device_pair_destroy(c->own_pair);
    own_pairs_end(&c->own);
    seen_end(&c->seen);
    homes_end(&c->homes);
    cut_end(&c->cut);
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

// A call's failure on one rank, NULL arguments included, becomes that of all.
static bool agree_on(duet_cluster *c, const char *call, bool ok, duet_error *own, duet_error *err)
{
    return ranks_agree_on(&c->ranks, call, ok, own) || error_set(err, own->status, "%s", own->text);
}

// ---------------------------------------------------------------- objects

static void take(duet_cluster *c, object_rows *rows)
{
    homes_take(&c->homes, rows);
    own_pairs_end(&c->own);
    c->changed = true;
}

// Ids count from `first` on where there are none.
static bool copy_rows(object_rows *rows, const object_form *form, const uint64_t *ids,
                      uint64_t first, const void *objects, uint32_t n, duet_error *err)
{
    const object_rows none = {0};
    arrival *arrivals = malloc(((size_t)n + 1) * sizeof *arrivals);
    bool ok = arrivals || error_set(err, DUET_STATUS_NO_MEMORY, "%u objects: no memory", n);
    for (uint32_t i = 0; ok && i < n; ++i)
        arrivals[i] =
            (arrival){ids ? ids[i] : first + i, (const char *)objects + (size_t)i * form->bytes, i};
    if (ok && ids)
        arrivals_sort(arrivals, n);
    ok = ok && object_rows_begin(rows, form, n, err);
    ok = ok && object_rows_merge(rows, form, &none, NULL, 0, arrivals, n, err);
    free(arrivals);
    return ok;
}

static bool check_kind(const duet_cluster *c, duet_object_kind kind, duet_error *err)
{
    duet_object_kind right = object_form_kind(&c->homes.form);
    static const char *const names[] = {"poses", "bounds", "large poses"};
    return kind == right ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "objects of kind %d; this cluster was made for %s", (int)kind, names[right]);
}

bool duet_cluster_set_objects(duet_cluster *c, duet_object_kind kind, const uint64_t *ids,
                              const void *objects, uint32_t n, duet_error *err)
{
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    object_rows rows = {0};
    bool ok = check_kind(c, kind, &own);
    ok = ok && (n == 0 || (error_given(ids, __func__, "ids", &own) &&
                           error_given(objects, __func__, "objects", &own)));
    ok = ok && copy_rows(&rows, &c->homes.form, ids, 0, objects, n, &own);
    ok = agree_on(c, __func__, ok, &own, err);
    if (ok)
        take(c, &rows);
    object_rows_end(&rows);
    return ok;
}

// ---------------------------------------------------------------- scenes

// What rank 0 tells the others of a scene.
typedef struct told_scene {
    duet_scene_info info; // without its name
    uint64_t name_bytes;
} told_scene;

static bool tell_scene(duet_cluster *c, const duet_scene *own_part, uint64_t n, duet_error *own)
{
    told_scene told = {0};
    uint64_t rotated = own_part && own_part->info.rotated; // some object of any rank's part
    ranks_sum(&c->ranks, &rotated, 1);
    if (c->ranks.self == 0)
        told.info = own_part->info;
    const char *name = told.info.name;
    told.name_bytes = name ? strlen(name) + 1 : 1;
    ranks_tell(&c->ranks, &told, sizeof told);
    char *copy = calloc(told.name_bytes, 1);
    if (!ranks_agree(&c->ranks, copy || error_set(own, DUET_STATUS_NO_MEMORY, "a name: no memory"),
                     own)) {
        free(copy);
        return false;
    }
    if (name)
        memcpy(copy, name, told.name_bytes);
    ranks_tell(&c->ranks, copy, told.name_bytes);
    free(c->scene_name);
    c->scene_name = copy;
    c->scene = told.info;
    c->scene.name = copy;
    c->scene.n = n < UINT32_MAX ? (uint32_t)n : UINT32_MAX;
    c->scene.rotated = rotated > 0;
    return true;
}

static duet_world_def def_of_scene(const duet_cluster *c)
{
    const duet_scene described = {.info = c->scene};
    duet_world_def def = duet_scene_world_def(&described, c->def.world.pair);
    def.plan = c->def.world.plan;
    def.max_pairs = c->def.world.max_pairs;
    def.has_accuracy = false;
    return def;
}

// Objects of a scene that rank 0 has read, or of a part that each rank has.
typedef struct scene_part {
    duet_scene *scene;
    uint64_t first; // the id of its first object
    uint64_t n;     // of all ranks' parts
} scene_part;

// Rank 0 reads the scene. Where objects are made by `each`, it only counts them, and each rank
// makes as many of them as the others.
static bool read_part(duet_cluster *c, const char *path, const duet_setting *settings,
                      uint32_t n_settings, bool whole, scene_part *part, duet_error *own)
{
    uint64_t told[2] = {0}; // objects, and those that are not made
    bool reads = c->ranks.self == 0;
    whole = whole || strcmp(path, "-") == 0; // which only rank 0 has
    *part = (scene_part){0};
    if (reads && whole)
        part->scene = duet_scene_load(path, settings, n_settings, own);
    else if (reads)
        part->scene = scene_load_deferred(path, settings, n_settings, &told[0], &told[1], own);
    if (!ranks_agree(&c->ranks, !reads || part->scene, own))
        return false;
    if (reads && whole)
        told[0] = part->scene->info.n;
    ranks_tell(&c->ranks, told, sizeof told);
    part->n = told[0];
    if (told[1] == 0)
        return true;
    uint64_t each = part->n / (uint64_t)c->ranks.n + 1, end;
    part->first =
        each * (uint64_t)c->ranks.self < part->n ? each * (uint64_t)c->ranks.self : part->n;
    end = part->first + each < part->n ? part->first + each : part->n;
    duet_scene_destroy(part->scene);
    part->scene = scene_load_range(path, settings, n_settings, part->first, end, &told[0], own);
    bool ok = part->scene && (told[0] == part->n ||
                              error_set(own, DUET_STATUS_BAD_INPUT,
                                        "%s: it has %llu objects here and %llu on rank 0", path,
                                        (unsigned long long)told[0], (unsigned long long)part->n));
    return ranks_agree(&c->ranks, ok, own);
}

static bool take_part(duet_cluster *c, const scene_part *part, duet_error *own)
{
    object_rows rows = {0};
    if (!tell_scene(c, part->scene, part->n, own))
        return false;
    c->def.world = def_of_scene(c);
    bool ok = open_worker(c, own);
    const void *objects =
        ok && part->scene ? duet_scene_get_objects(part->scene, object_form_kind(&c->homes.form))
                          : NULL;
    ok = ok && copy_rows(&rows, &c->homes.form, NULL, part->first, objects,
                         part->scene ? part->scene->info.n : 0, own);
    ok = ranks_agree(&c->ranks, ok, own);
    if (ok)
        take(c, &rows);
    object_rows_end(&rows);
    c->has_scene = c->has_scene || ok;
    return ok;
}

bool cluster_load_scene(duet_cluster *c, const char *path, const duet_setting *settings,
                        uint32_t n_settings, duet_scene **whole, duet_error *err)
{
    duet_error own = {0};
    scene_part part;
    bool ok =
        read_part(c, path, settings, n_settings, whole, &part, &own) && take_part(c, &part, &own);
    if (ok && whole) {
        *whole = part.scene;
        part.scene = NULL;
    }
    duet_scene_destroy(part.scene);
    return ok || error_set(err, own.status, "%s", own.text);
}

bool duet_cluster_load_scene(duet_cluster *c, const char *path, const duet_setting *settings,
                             uint32_t n_settings, duet_error *err)
{
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    return agree_on(c, __func__, error_given(path, __func__, "path", &own), &own, err) &&
           cluster_load_scene(c, path, settings, n_settings, NULL, err);
}

const duet_scene_info *duet_cluster_get_scene_info(const duet_cluster *c)
{
    return c && c->has_scene ? &c->scene : NULL;
}

// ---------------------------------------------------------------- a step

static bool check_worker_result(const duet_cluster *c, const worker_found *found, duet_error *err)
{
    return !found->has_bad ||
           error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %llu is not a number, infinite, negative or without rotation",
                     (unsigned long long)c->seen.rows.ids[found->first_bad]);
}

// Brings homes and ghosts to where they belong, and hands them to the worker.
static bool settle(duet_cluster *c, duet_error *own)
{
    uint64_t changed = c->changed;
    ranks_sum(&c->ranks, &changed, 1);
    if (changed == 0)
        return true;
    parcels ghosts = {0};
    c->changed = true; // until all of it is done, on all ranks
    bool ok = homes_settle(&c->homes, &c->ranks, &c->cut, c->def.imbalance, own);
    ok = ok && ghosts_exchange(&c->homes, &c->ranks, &ghosts, own);
    if (ok) {
        c->n_ghosts = ghosts.n;
        ok = ranks_agree(&c->ranks,
                         seen_fill(&c->seen, &c->homes, &c->ranks, &ghosts, c->worker, own), own);
    }
    parcels_end(&ghosts);
    c->changed = !ok;
    return ok;
}

// Without homes there are no pairs of this rank's, and nothing is built.
static bool find_own(duet_cluster *c, duet_error *own)
{
    worker_found found = {0};
    if (c->homes.rows.n > 0 && !c->worker->find(c->worker, &found, own))
        return false;
    return check_worker_result(c, &found, own) && own_pairs_take(&c->own, &c->seen, &found, own);
}

// The first time one rank of a host builds kernels, which the others then find in the cache.
static bool find(duet_cluster *c, duet_error *own)
{
    if (c->is_cold)
        ranks_await_turn(&c->ranks, c->homes.rows.n > 0);
    bool ok = find_own(c, own);
    if (c->is_cold)
        ranks_end_turn(&c->ranks);
    c->is_cold = false;
    return ranks_agree(&c->ranks, ok, own);
}

static void keep_times(duet_cluster *c, uint64_t begun_ns)
{
    double total_ms = clock_ms_since(begun_ns);
    double wait_ms = (double)c->ranks.wait_ns * 1e-6;
    duet_cluster_rank *last = &c->last;
    *last = (duet_cluster_rank){.objects = c->homes.rows.n,
                                .ghosts = c->n_ghosts,
                                .pairs = c->own.n,
                                .sent_bytes = c->ranks.sent_bytes,
                                .busy_ms = fmax(total_ms - wait_ms, 0),
                                .wait_ms = wait_ms};
    snprintf(last->host, sizeof last->host, "%s", c->ranks.host_name);
    snprintf(last->pair, sizeof last->pair, "%s", c->worker->name);
}

bool duet_cluster_step(duet_cluster *c, duet_cluster_result *result, duet_error *err)
{
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    if (!agree_on(c, __func__, error_given(result, __func__, "result", &own), &own, err))
        return false;
    uint64_t begun_ns = clock_steady_ns();
    c->ranks.wait_ns = c->ranks.sent_bytes = 0;
    bool ok = settle(c, &own) && find(c, &own);
    if (!ok) {
        own_pairs_end(&c->own);
        return error_set(err, own.status, "%s", own.text);
    }
    uint64_t sums[] = {c->homes.rows.n, c->own.n, c->own.hash};
    ranks_sum(&c->ranks, sums, 3);
    keep_times(c, begun_ns);
    double total_ms = clock_ms_since(begun_ns);
    ranks_greatest(&c->ranks, &total_ms, 1);
    *result = (duet_cluster_result){.objects = sums[0],
                                    .pairs = sums[1],
                                    .hash = sums[2],
                                    .total_ms = total_ms,
                                    .own_pairs = c->own.pairs,
                                    .n_own_pairs = c->own.n};
    return true;
}

bool duet_cluster_get_ranks(duet_cluster *c, duet_cluster_rank *rows, duet_error *err)
{
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    if (!agree_on(c, __func__, error_given(rows, __func__, "ranks", &own), &own, err))
        return false;
    ranks_gather(&c->ranks, &c->last, rows, (int)sizeof c->last);
    return true;
}

// ---------------------------------------------------------------- between steps

void *duet_cluster_map_homes(duet_cluster *c, duet_object_kind kind, const uint64_t **ids,
                             uint32_t *n, duet_error *err)
{
    if (!error_given(c, __func__, "cluster", err))
        return NULL;
    duet_error own = {0};
    bool ok = error_given(ids, __func__, "ids", &own) && error_given(n, __func__, "n", &own) &&
              check_kind(c, kind, &own);
    if (!agree_on(c, __func__, ok, &own, err))
        return NULL;
    if (!settle(c, &own)) {
        error_set(err, own.status, "%s", own.text);
        return NULL;
    }
    c->changed = true;
    *ids = c->homes.rows.ids;
    *n = c->homes.rows.n;
    return c->homes.rows.objects;
}

bool duet_cluster_set_plan(duet_cluster *c, const duet_plan *plan, duet_error *err)
{
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    bool ok =
        error_given(plan, __func__, "plan", &own) && c->worker->set_plan(c->worker, plan, &own);
    if (ok)
        c->def.world.plan = *plan;
    c->is_cold = true;
    return agree_on(c, __func__, ok, &own, err);
}

bool duet_cluster_set_level(duet_cluster *c, duet_level level, duet_error *err)
{
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    bool ok =
        duet_level_get_info(level) ||
        error_set(&own, DUET_STATUS_BAD_ARGUMENT, "level is %d; expected a duet_level", (int)level);
    ok = ok && c->worker->set_level(c->worker, level, &own);
    if (ok)
        c->def.world.level = level;
    c->is_cold = true;
    return agree_on(c, __func__, ok, &own, err);
}

bool duet_cluster_load_profile(duet_cluster *c, const char *path, duet_profile *profile,
                               duet_error *store_failed, duet_error *err)
{
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    if (!agree_on(c, __func__, error_given(profile, __func__, "profile", &own), &own, err))
        return false;
    if (!settle(c, &own))
        return error_set(err, own.status, "%s", own.text);
    *profile = (duet_profile){.grade = DUET_GRADE_DEFAULT};
    if (c->homes.rows.n > 0)
        c->worker->load_profile(c->worker, path, profile, store_failed);
    c->is_cold = true;
    return true;
}

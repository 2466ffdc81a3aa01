// SPDX-License-Identifier: MIT
// The objects of a scene come in: rank 0 reads it, or each rank a part.
#include "cluster/cluster.h"

#include "base/budget.h"
#include "base/error.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/scene_load.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { OBJECTS_AT_ONCE = 1 << 20 };

// The objects of a scene that a rank has read: rank 0 all of them, or each rank a part.
typedef struct scene_part {
    duet_scene *scene; // NULL: nothing; else it, or its first objects
    object_rows rows;
    uint64_t first_id;
    object_form form; // the form of its rows
    bool rotated;     // one of them
    uint64_t n;       // objects of all ranks' parts
} scene_part;

// Parts of one scene may have other shapes: boxes with radii beside boxes without, or spheres.
static duet_shape shape_of_all(const uint64_t n_ranks[DUET_SHAPES], duet_shape of_none)
{
    duet_shape shape = of_none;
    int n = 0;
    for (int i = 0; i < DUET_SHAPES; ++i)
        if (n_ranks[i] > 0) {
            shape = (duet_shape)i;
            ++n;
        }
    return n > 1 ? DUET_SHAPE_ROUNDED_BOXES : shape;
}

// *info and its name, which is to be freed, are those of rank 0, but what the parts are together.
static bool broadcast_scene(duet_cluster *c, const scene_part *part, duet_scene_info *info,
                            char **name, duet_error *own)
{
    bool reads = c->ranks.self == 0;
    uint64_t with[DUET_SHAPES + 1] = {[DUET_SHAPES] = part->rotated}; // how many ranks
    if (part->rows.n > 0)
        with[part->form.shape] = 1;
    ranks_sum(&c->ranks, with, DUET_SHAPES + 1);
    *info = reads ? part->scene->info : (duet_scene_info){0};
    *name = ranks_broadcast_text(&c->ranks, info->name, own);
    if (!*name)
        return false;
    ranks_broadcast(&c->ranks, info, sizeof *info);
    info->name = *name;
    info->n = part->n < UINT32_MAX ? (uint32_t)part->n : UINT32_MAX;
    info->shape = shape_of_all(with, info->shape);
    info->rotated = with[DUET_SHAPES] > 0;
    return true;
}

static duet_world_def def_of_scene(const duet_cluster *c, const duet_scene_info *info)
{
    const duet_scene described = {.info = *info};
    duet_world_def def = duet_scene_world_def(&described, c->def.world.pair);
    def.plan = c->def.world.plan;
    def.max_pairs = c->def.world.max_pairs;
    def.has_accuracy = false;
    return def;
}

static object_form form_of(const duet_scene *scene)
{
    duet_world_def def = duet_scene_world_def(scene, NULL);
    return object_form_of(&def);
}

// Whether both can be rows of one array, as they are or as rounded boxes.
static bool can_join(const object_form *a, const object_form *b)
{
    return a->dims == b->dims && a->origin == b->origin &&
           (a->shape == DUET_SHAPE_BOUNDS) == (b->shape == DUET_SHAPE_BOUNDS);
}

static void number_part(void *context, uint32_t unused, uint64_t first, uint64_t end)
{
    const scene_part *part = context;
    (void)unused;
    for (uint64_t i = first; i < end; ++i)
        part->rows.ids[i] = part->first_id + i;
}

// Rows for n objects, whose ids count from `first` on; those of the scene are the first.
static bool begin_rows(scene_part *part, uint64_t first, uint64_t n, parallel *threads,
                       duet_error *own)
{
    part->form = form_of(part->scene);
    part->first_id = first;
    bool ok = object_rows_begin(&part->rows, &part->form, n, own);
    if (ok)
        parallel_each(threads, n, number_part, part);
    part->rows.n = 0;
    return ok;
}

// Memory that is new is filled by all threads, for the system gives it page by page.
static bool add_objects(scene_part *part, const duet_scene *from, parallel *threads,
                        duet_error *own)
{
    object_form form = form_of(from);
    object_rows *to = &part->rows, rounded = {0};
    const uint64_t *ids = to->ids + to->n;
    const void *objects = duet_scene_get_objects(from, object_form_kind(&form));
    bool ok = true;
    part->rotated = part->rotated || from->info.rotated;
    if (form.shape != part->form.shape) {
        ok = object_rows_round(to, &part->form, own) &&
             object_rows_copy(&rounded, &form, ids, objects, from->info.n, own) &&
             object_rows_round(&rounded, &form, own);
        objects = rounded.objects;
    }
    if (ok) {
        parallel_copy(threads, object_row(to, &form, to->n), objects, from->info.n, form.bytes);
        to->n += from->info.n;
    }
    object_rows_end(&rounded);
    return ok;
}

// Objects that are read at one time, by several threads; so many that a part is not there twice.
typedef struct reading {
    const char *path;
    const duet_setting *settings;
    uint32_t n_settings;
    uint64_t at, end;
    duet_scene *some[PARALLEL_MOST];
    uint64_t n[PARALLEL_MOST]; // the number of all objects, as reported to each thread
    duet_error errs[PARALLEL_MOST];
} reading;

static void read_some(void *context, uint32_t job, uint64_t unused_first, uint64_t unused_end)
{
    reading *r = context;
    uint64_t from = r->at + (uint64_t)job * OBJECTS_AT_ONCE, to = from + OBJECTS_AT_ONCE;
    (void)unused_first, (void)unused_end;
    r->some[job] = scene_load_range(r->path, r->settings, r->n_settings, from,
                                    to < r->end ? to : r->end, &r->n[job], &r->errs[job]);
}

// The first ones say what rows all have.
static bool keep_some(scene_part *part, reading *r, uint32_t job, uint64_t first, parallel *threads,
                      duet_error *own)
{
    const duet_scene *some = r->some[job];
    uint64_t n = r->n[job];
    if (!some)
        return error_copy(own, &r->errs[job]);
    if (!part->scene) {
        part->scene = r->some[job];
        r->some[job] = NULL;
        if (!begin_rows(part, first, r->end - first, threads, own))
            return false;
    }
    object_form form = form_of(some);
    if (n != part->n || !can_join(&part->form, &form))
        return bad_input(
            own, "%s: it has %llu objects here and %llu on rank 0, or others each time it is read",
            r->path, (unsigned long long)n, (unsigned long long)part->n);
    return add_objects(part, some, threads, own);
}

static bool read_range(scene_part *part, reading *r, bool at_once, parallel *threads,
                       duet_error *own)
{
    uint64_t first = r->at;
    bool ok = true;
    while (ok && (r->at < r->end || !part->scene)) {
        uint64_t left = (r->end - r->at + OBJECTS_AT_ONCE - 1) / OBJECTS_AT_ONCE;
        uint64_t most = at_once ? threads->n : 1;
        uint32_t n = left == 0 ? 1 : (uint32_t)(left < most ? left : most);
        memset(r->errs, 0, sizeof r->errs);
        parallel_jobs(threads, n, read_some, r);
        for (uint32_t job = 0; job < n; ++job) {
            ok = ok && keep_some(part, r, job, first, threads, own);
            duet_scene_destroy(r->some[job]);
        }
        r->at += (uint64_t)n * OBJECTS_AT_ONCE;
        ok = ok && budget_check_stop(own);
    }
    return ok;
}

static bool is_array(const char *path)
{
    size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".npy") == 0;
}

// Stdin is rank 0's alone, and an array need not be on all hosts.
static bool is_of_one_rank(duet_cluster *c, const char *path)
{
    uint64_t lacking = strcmp(path, "-") == 0 || (is_array(path) && access(path, R_OK) != 0);
    ranks_sum(&c->ranks, &lacking, 1);
    return lacking > 0;
}

// Rank 0 reads the scene. If objects are made by `each`, or are rows of an array, it only counts
// them, and each rank makes or reads as many of them as the others.
static bool read_part(duet_cluster *c, const char *path, const duet_setting *settings,
                      uint32_t n_settings, bool whole, scene_part *part, duet_error *own)
{
    uint64_t counts[2] = {0}; // objects, and those that are not made
    bool ok = true, reads = c->ranks.self == 0;
    whole = is_of_one_rank(c, path) || whole;
    *part = (scene_part){0};
    if (reads && whole)
        part->scene = duet_scene_load(path, settings, n_settings, own);
    else if (reads)
        part->scene = scene_load_deferred(path, settings, n_settings, &counts[0], &counts[1], own);
    ok = !reads || part->scene;
    if (ok && reads && whole)
        counts[0] = part->scene->info.n;
    if (ok && reads && counts[1] == 0)
        ok = begin_rows(part, 0, counts[0], &c->threads, own) &&
             add_objects(part, part->scene, &c->threads, own);
    if (!ranks_agree(&c->ranks, ok, own))
        return false;
    ranks_broadcast(&c->ranks, counts, sizeof counts);
    part->n = counts[0];
    if (counts[1] == 0)
        return true;
    uint64_t each = part->n / (uint64_t)c->ranks.n + 1, first = each * (uint64_t)c->ranks.self;
    first = first < part->n ? first : part->n;
    duet_scene_destroy(part->scene);
    part->scene = NULL;
    reading r = {.path = path, .settings = settings, .n_settings = n_settings, .at = first};
    r.end = part->n - first < each ? part->n : first + each;
    // A script is watched by the thread that runs it: this one.
    ok = read_range(part, &r, is_array(path), &c->threads, own);
    return ranks_agree(&c->ranks, ok, own);
}

// The part's rows become such as all ranks have.
static bool fit_rows(scene_part *part, const object_form *form, const char *name, duet_error *own)
{
    if (part->rows.n == 0) {
        object_rows_end(&part->rows);
        return object_rows_begin(&part->rows, form, 0, own);
    }
    if (!can_join(&part->form, form))
        return bad_input(own, "%s: it has objects of another kind here than on other ranks", name);
    return part->form.shape == form->shape || object_rows_round(&part->rows, &part->form, own);
}

// All ranks have the scene then, or all what they had.
static bool take_part(duet_cluster *c, scene_part *part, duet_error *own)
{
    duet_scene_info info;
    char *name = NULL;
    worker *workers[2] = {NULL};
    if (!broadcast_scene(c, part, &info, &name, own))
        return false;
    duet_world_def world = def_of_scene(c, &info);
    object_form form = object_form_of(&world);
    bool ok =
        cluster_open_workers(c, &world, workers, own) && fit_rows(part, &form, info.name, own);
    if (!ranks_agree(&c->ranks, ok, own)) {
        cluster_close_workers(workers);
        free(name);
        return false;
    }
    cluster_take_workers(c, &world, workers);
    cluster_take(c, &part->rows);
    free(c->scene_name);
    c->scene_name = name;
    c->scene = info;
    return true;
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
    object_rows_end(&part.rows);
    return ok || error_copy(err, &own);
}

bool duet_cluster_load_scene(duet_cluster *c, const char *path, const duet_setting *settings,
                             uint32_t n_settings, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    return cluster_agree_on(c, __func__, error_given(path, __func__, "path", &own), &own, err) &&
           cluster_load_scene(c, path, settings, n_settings, NULL, err);
}

const duet_scene_info *duet_cluster_get_scene_info(const duet_cluster *c)
{
    return c && c->scene_name ? &c->scene : NULL;
}

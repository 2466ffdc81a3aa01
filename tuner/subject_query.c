// SPDX-License-Identifier: MIT
// A query of a scene's objects as a subject: of a plan only the share counts.
#include "tuner/subject.h"

#include "base/error.h"
#include "runtime/queries/any_query.h"
#include "runtime/queries/item_draw.h"
#include "runtime/scene/scene.h"

#include <stdlib.h>

typedef struct query {
    duet_tree *tree; // holds the scene's objects
    query_name name;
    void *items; // drawn among the objects
    uint64_t n;
    any_query *query;
} query;

// ---------------------------------------------------------------- def

static bool check(const duet_tune_def *def, duet_error *err)
{
    query_name name;
    return query_name_read(def->query, &name, err);
}

// ---------------------------------------------------------------- owner

static bool open_tree(subject *s, const duet_scene_info *info, const void *objects, duet_error *err)
{
    query *q = s->state;
    duet_tree_def def = duet_default_tree_def();
    def.pair = s->pair;
    def.dims = info->dims;
    def.shape = info->shape;
    def.origin_edge = info->origin_edge;
    q->tree = duet_tree_create(&def, err);
    return q->tree && duet_tree_set_objects(q->tree, scene_kind(info), objects, info->n, err);
}

static bool open_query(subject *s, const duet_scene_info *info, duet_error *err)
{
    query *q = s->state;
    const void *objects = duet_scene_get_objects(s->def->scene, scene_kind(info));
    if (q->n == 0 || q->n > UINT32_MAX || info->n == 0)
        return bad_argument(
            err,
            "%llu items of a query of %u objects; expected 1 or more of both, and fewer than 2^32",
            (unsigned long long)q->n, info->n);
    if (!open_tree(s, info, objects, err))
        return false;
    const item_objects among = {objects, info->n, info->dims, info->shape, info->origin_edge};
    if (!q->name.itself && !(q->items = item_draw(&q->name, q->n, &among, s->def->seed, err)))
        return false;
    q->query = any_query_create(q->tree, &(any_query_def){.name = q->name}, err);
    return q->query;
}

static bool open(subject *s, duet_error *err)
{
    const duet_scene_info *info = duet_scene_get_info(s->def->scene);
    query *q = s->state = calloc(1, sizeof *q);
    if (!q)
        return no_memory(err, "a query");
    if (!query_name_read(s->def->query, &q->name, err))
        return false;
    q->n = s->def->items && !q->name.itself ? s->def->items : info->n;
    s->units = q->n;
    return open_query(s, info, err);
}

static void close(subject *s)
{
    query *q = s->state;
    if (!q)
        return;
    any_query_destroy(q->query);
    duet_tree_destroy(q->tree);
    free(q->items);
    free(q);
}

static bool describe(subject *s, profile_subject *p, duet_error *err)
{
    const query *q = s->state;
    return profile_subject_read_query(q->tree, &q->name, q->n, p, err);
}

// ---------------------------------------------------------------- launches

static bool ask(query *q, uint32_t share, query_result *found, duet_error *err)
{
    return duet_tree_set_share(q->tree, share, err) &&
           (q->name.itself ? any_query_run_itself(q->query, NULL, 0, found, err)
                           : any_query_run(q->query, q->items, q->n, found, err));
}

// They come in order.
static uint64_t hash_of(const query *q, const query_result *found)
{
    uint64_t hash = found->n_hits;
    size_t words = found->n_hits * query_hit_bytes(q->name.item) / sizeof *found->hits;
    for (size_t i = 0; i < words; ++i)
        hash = (hash ^ found->hits[i]) * 0x9E3779B97F4A7C15u;
    return hash;
}

// A query has no stages.
static bool launch_query(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                         duet_error *err)
{
    subject *s = context;
    query_result found;
    (void)staged;
    measure_watch(s->cores, s->pair);
    if (!ask(s->state, plan->share, &found, err))
        return false;
    core_use use = core_watch_stop(s->cores);
    *launch = (measure_launch){.total_ns = measure_to_ns(found.total_ms),
                               .a_ns = measure_to_ns(found.device_ms[0]),
                               .b_ns = measure_to_ns(found.device_ms[1]),
                               .hash = hash_of(s->state, &found),
                               .use = use};
    return true;
}

// By device B alone: hits are the same at every share, which each launch is checked for.
static bool find_truth(subject *s, subject_truth *truth, duet_error *err)
{
    query_result found;
    if (!ask(s->state, 0, &found, err))
        return false;
    truth->hash = hash_of(s->state, &found);
    truth->pairs = found.n_hits;
    return true;
}

const subject_kind subject_query = {
    .has = "a query has",
    .asked_by = SUBJECT_QUERY,
    .takes = SUBJECT_SCENE | SUBJECT_QUERY | SUBJECT_ITEMS | SUBJECT_ORDER,
    .has_one_way = true, // the whole tree, and one way to walk down it
    .check = check,
    .open = open,
    .close = close,
    .describe = describe,
    .find_truth = find_truth,
    .machine = {.launch = launch_query},
};

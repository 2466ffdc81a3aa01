// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/queries/far_rows.h"
#include "runtime/queries/tree_query.h"

#include <stdlib.h>

enum { COOKIE = 0x0d0e700c };

struct duet_box_query {
    tree_query asked;
    tree_query itself; // the tree's objects'; without kind until it is asked for
    duet_level level;
};

_Static_assert(sizeof(duet_box_hit) == 2 * sizeof(uint32_t), "a hit is two words");
_Static_assert(sizeof(duet_filter) == 2 * sizeof(uint32_t), "a filter is two words");

duet_box_query_def duet_default_box_query_def(void)
{
    return (duet_box_query_def){.cookie = COOKIE};
}

static bool meets(const duet_tree *tree, const void *item, uint32_t *hit)
{
    return narrow_decide(item, (const duet_pose *)tree->objects + hit[1], tree->def.dims);
}

static bool meets_far(const duet_tree *tree, const void *item, uint32_t *hit)
{
    const duet_large_pose *box = item;
    const duet_large_pose *object = (const duet_large_pose *)tree->objects + hit[1];
    double shift[3];
    far_shift(shift, object, box->cell, tree->def.origin_edge);
    return narrow_decide_apart(&object->pose, &box->pose, shift, tree->def.dims);
}

static bool meets_rounded(const duet_tree *tree, const void *item, uint32_t *hit)
{
    return rounded_decide(item, (const duet_rounded_box *)tree->objects + hit[1], tree->def.dims);
}

#define BOXES(wrong_, meets_)                                                                  \
    .item = "box", .items = "boxes", .wrong = (wrong_), .kernel = "box_query", .hit_words = 2, \
    .meets = (meets_)

static const query_kind kinds[DUET_SHAPES] = {
    [DUET_SHAPE_POSES] = {BOXES(
        "not a number, infinite, negative, without rotation, or above 2^100", meets)},
    [DUET_SHAPE_BOUNDS] = {BOXES(
        "not a number, infinite, with a lower corner above its upper one, or above 2^100", NULL)},
    [DUET_SHAPE_ROUNDED_BOXES] = {BOXES(
        "not a number, infinite, negative, without rotation, or above 2^100", meets_rounded)},
    [DUET_SHAPE_SPHERES] =
        {BOXES("not a number, infinite, negative, without rotation, or above 2^100", meets_rounded),
         .copy = tree_copy_rows},
};

static const query_kind far_kind = {BOXES(
    "not a number, infinite, negative, without rotation, or beyond 2^30 origin cells", meets_far)};

static bool check_def(const duet_box_query_def *def, duet_error *err)
{
    bool ours = def && def->cookie == COOKIE;
    return tree_query_check_def(ours, ours ? def->tree : NULL, "duet_default_box_query_def", err) &&
           (duet_level_get_info(def->level) ||
            error_set(err, DUET_STATUS_BAD_ARGUMENT, "level is %d; expected a duet_level",
                      (int)def->level));
}

static bool open(tree_query *q, duet_tree *tree, duet_level level, const duet_filter *filter,
                 bool itself, duet_error *err)
{
    bool poses = tree->def.shape == DUET_SHAPE_POSES;
    bool far = tree->def.origin_edge > 0.0f;
    *q = (tree_query){.kind = far ? &far_kind : &kinds[tree->def.shape],
                      .tree = tree,
                      .wants = QUERY_EVERY,
                      .item_words = (uint32_t)(tree_row_bytes(tree) / sizeof(float)),
                      .item_cell = FAR_POSE_CELL,
                      .itself = itself};
    const gen_setting settings[] = {{"ACCURACY", poses ? level : DUET_LEVEL_CERTIFIED},
                                    {"ITSELF", itself}};
    return tree_query_open(q, &(query_name){.item = QUERY_BOXES, .itself = itself}, filter,
                           settings, 2, err);
}

duet_box_query *duet_box_query_create(const duet_box_query_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    duet_box_query *query = check_def(def, err) ? tree_query_new(sizeof *query, err) : NULL;
    if (!query)
        return NULL;
    query->level = def->level;
    if (open(&query->asked, def->tree, def->level, def->filter, false, err))
        return query;
    duet_box_query_destroy(query);
    return NULL;
}

void duet_box_query_destroy(duet_box_query *query)
{
    if (query && query->itself.kind)
        tree_query_close(&query->itself);
    if (query)
        tree_query_close(&query->asked);
    free(query);
}

bool duet_box_query_run(duet_box_query *query, duet_object_kind kind, const void *boxes, uint64_t n,
                        duet_box_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    query_result found;
    if (!error_given(query, __func__, "query", err) ||
        !error_given(result, __func__, "result", err) ||
        !tree_takes(query->asked.tree, kind, err) ||
        !tree_query_run(&query->asked, boxes, n, &found, err))
        return false;
    *result = QUERY_RESULT(duet_box_query_result, duet_box_hit, found);
    return true;
}

bool duet_box_query_run_itself(duet_box_query *query, const duet_filter *filters, uint64_t n,
                               duet_box_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    query_result found;
    if (!error_given(query, __func__, "query", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    tree_query *q = &query->itself;
    uint32_t n_objects = query->asked.tree->n;
    if (filters && n != n_objects)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%llu filters; expected one for each of the tree's %u objects",
                         (unsigned long long)n, n_objects);
    if (!q->kind && !open(q, query->asked.tree, query->level, NULL, true, err)) {
        tree_query_close(q);
        q->kind = NULL;
        return false;
    }
    q->filters = filters;
    if (!tree_query_run(q, q->tree->objects, n_objects, &found, err))
        return false;
    *result = QUERY_RESULT(duet_box_query_result, duet_box_hit, found);
    return true;
}

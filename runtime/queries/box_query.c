// SPDX-License-Identifier: MIT
#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/queries/far_rows.h"
#include "runtime/queries/tree_query.h"

enum { COOKIE = 0x0d0e700c };

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

static bool meets_ground(const tree_query *q, const void *item, uint32_t *hit)
{
    ground_entry entry;
    const duet_shape shape = q->tree->def.shape;
    const ground_probe probe = shape == DUET_SHAPE_BOUNDS  ? ground_probe_of_still_bounds(item)
                               : shape == DUET_SHAPE_POSES ? ground_probe_of_box(item)
                                                           : ground_probe_of_rounded_box(item);
    (void)hit;
    return ground_shape_meet(&q->tree->ground, &probe, &entry);
}

#define BOXES(type_, wrong_, meets_)                                              \
    .item = "box", .items = "boxes", .wrong = (wrong_), .kernel = "box_query",    \
    .item_words = QUERY_WORDS(type_), .item_cell = FAR_POSE_CELL, .hit_words = 2, \
    .meets = (meets_)

#define WRONG_BOX "not a number, infinite, negative, without rotation, or above 2^100"

const query_kinds box_kinds = {
    [DUET_SHAPE_POSES] = {BOXES(duet_pose, WRONG_BOX, meets), .meets_ground = meets_ground},
    [DUET_SHAPE_BOUNDS] =
        {BOXES(duet_bounds,
               "not a number, infinite, with a lower corner above its upper one, or above 2^100",
               NULL),
         .meets_ground = meets_ground},
    [DUET_SHAPE_ROUNDED_BOXES] = {BOXES(duet_rounded_box, WRONG_BOX, meets_rounded),
                                  .meets_ground = meets_ground},
    [DUET_SHAPE_SPHERES] = {BOXES(duet_rounded_box, WRONG_BOX, meets_rounded),
                            .copy = tree_copy_rows, .meets_ground = meets_ground},
    [DUET_SHAPES] = {BOXES(
        duet_large_pose,
        "not a number, infinite, negative, without rotation, or beyond 2^30 origin cells",
        meets_far)},
};

duet_box_query *duet_box_query_create(const duet_box_query_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_def(def && def->cookie == COOKIE, "query", "duet_default_box_query_def", err))
        return NULL;
    const any_query_def any = {
        .name = {.item = QUERY_BOXES}, .level = def->level, .filter = def->filter};
    return (duet_box_query *)tree_query_create(def->tree, box_kinds, &any, err);
}

void duet_box_query_destroy(duet_box_query *query)
{
    any_query_destroy((tree_query *)query);
}

bool duet_box_query_run(duet_box_query *query, duet_object_kind kind, const void *boxes, uint64_t n,
                        duet_box_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    query_result found;
    if (!error_given(query, __func__, "query", err) ||
        !error_given(result, __func__, "result", err) ||
        !tree_takes(((tree_query *)query)->tree, kind, err) ||
        !any_query_run((tree_query *)query, boxes, n, &found, err))
        return false;
    *result = QUERY_RESULT(duet_box_query_result, duet_box_hit, found);
    return true;
}

// The query of the tree's objects: it may be one itself.
static tree_query *own_of(tree_query *q, duet_error *err)
{
    const any_query_def def = {.name = {.item = QUERY_BOXES, .itself = true}, .level = q->level};
    if (!q->itself && !q->own)
        q->own = tree_query_create(q->tree, box_kinds, &def, err);
    return q->itself ? q : q->own;
}

bool any_query_run_itself(any_query *q, const duet_filter *filters, uint64_t n, query_result *found,
                          duet_error *err)
{
    uint32_t n_objects = q->tree->n;
    if (filters && n != n_objects)
        return bad_argument(err, "%llu filters; expected one for each of the tree's %u objects",
                            (unsigned long long)n, n_objects);
    tree_query *own = own_of(q, err);
    if (!own)
        return false;
    own->filters = filters;
    return any_query_run(own, own->tree->objects, n_objects, found, err);
}

bool duet_box_query_run_itself(duet_box_query *query, const duet_filter *filters, uint64_t n,
                               duet_box_query_result *result, duet_error *err)
{
    PUBLIC_CALL(err);
    query_result found;
    if (!error_given(query, __func__, "query", err) ||
        !error_given(result, __func__, "result", err) ||
        !any_query_run_itself((tree_query *)query, filters, n, &found, err))
        return false;
    *result = QUERY_RESULT(duet_box_query_result, duet_box_hit, found);
    return true;
}

// SPDX-License-Identifier: MIT
#include "runtime/queries/any_query.h"

#include "base/error.h"
#include "runtime/queries/tree_query.h"

#include <stdlib.h>

struct any_query {
    query_item item;
    void *asked; // the public query, which begins with a tree_query
};

static void *create(duet_tree *tree, const any_query_def *def, duet_error *err)
{
    const query_name *name = &def->name;
    duet_ray_query_def rays = duet_default_ray_query_def();
    duet_sweep_query_def sweeps = duet_default_sweep_query_def();
    duet_box_query_def boxes = duet_default_box_query_def();
    duet_point_query_def points = duet_default_point_query_def();
    rays.tree = sweeps.tree = boxes.tree = points.tree = tree;
    rays.wants = sweeps.wants = name->wants;
    rays.normals = def->normals;
    rays.filter = sweeps.filter = boxes.filter = points.filter = def->filter;
    boxes.level = def->level;
    points.nearest = name->nearest;
    switch (name->item) {
    case QUERY_RAYS:
        return duet_ray_query_create(&rays, err);
    case QUERY_SWEEPS:
        return duet_sweep_query_create(&sweeps, err);
    case QUERY_BOXES:
        return duet_box_query_create(&boxes, err);
    case QUERY_POINTS:
        return duet_point_query_create(&points, err);
    }
    return NULL;
}

any_query *any_query_create(duet_tree *tree, const any_query_def *def, duet_error *err)
{
    any_query *q = calloc(1, sizeof *q);
    if (!q)
        return error_null(err, DUET_STATUS_NO_MEMORY, "no memory for a query");
    *q = (any_query){def->name.item, create(tree, def, err)};
    if (q->asked)
        return q;
    free(q);
    return NULL;
}

void any_query_destroy(any_query *q)
{
    if (!q)
        return;
    switch (q->item) {
    case QUERY_RAYS:
        duet_ray_query_destroy(q->asked);
        break;
    case QUERY_SWEEPS:
        duet_sweep_query_destroy(q->asked);
        break;
    case QUERY_BOXES:
        duet_box_query_destroy(q->asked);
        break;
    case QUERY_POINTS:
        duet_point_query_destroy(q->asked);
        break;
    }
    free(q);
}

bool any_query_run(any_query *q, const void *items, uint64_t n, query_result *found,
                   duet_error *err)
{
    return tree_query_run(q->asked, items, n, found, err);
}

bool any_query_run_itself(any_query *q, const duet_filter *filters, uint64_t n, query_result *found,
                          duet_error *err)
{
    duet_box_query_result result;
    if (!duet_box_query_run_itself(q->asked, filters, n, &result, err))
        return false;
    *found = (query_result){.hits = (const uint32_t *)result.hits,
                            .n_hits = result.n_hits,
                            .undecided = result.undecided,
                            .total_ms = result.total_ms,
                            .device_ms = {result.device_ms[0], result.device_ms[1]}};
    return true;
}

size_t query_hit_bytes(query_item item)
{
    static const size_t bytes[] = {[QUERY_RAYS] = sizeof(duet_ray_hit),
                                   [QUERY_SWEEPS] = sizeof(duet_sweep_hit),
                                   [QUERY_BOXES] = sizeof(duet_box_hit),
                                   [QUERY_POINTS] = sizeof(duet_point_hit)};
    return bytes[item];
}

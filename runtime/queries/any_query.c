// SPDX-License-Identifier: MIT
#include "runtime/queries/tree_query.h"

static const query_kind *const kinds[] = {[QUERY_RAYS] = ray_kinds,
                                          [QUERY_SWEEPS] = sweep_kinds,
                                          [QUERY_BOXES] = box_kinds,
                                          [QUERY_POINTS] = point_kinds};

any_query *any_query_create(duet_tree *tree, const any_query_def *def, duet_error *err)
{
    return tree_query_create(tree, kinds[def->name.item], def, err);
}

size_t query_hit_bytes(query_item item)
{
    return kinds[item]->hit_words * sizeof(uint32_t);
}

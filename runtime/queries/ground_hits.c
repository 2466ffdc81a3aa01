// SPDX-License-Identifier: MIT
#include "runtime/queries/ground_hits.h"

#include "base/error.h"
#include "runtime/narrowphase/heights.h"
#include "runtime/narrowphase/mesh.h"
#include "runtime/queries/query_chunk.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- the tree's ground

bool tree_take_ground(duet_tree *tree, const duet_heights *heights, const duet_mesh *mesh,
                      duet_error *err)
{
    ground_shape ground;
    if (!ground_shape_copy(&ground, heights, mesh, err))
        return false;
    ground_shape_free(&tree->ground);
    tree->ground = ground;
    return true;
}

// Whether a tree can have that ground; NULL: none, which any can.
static bool takes_ground(const duet_tree *tree, const void *ground, const char *call,
                         const char *name, duet_error *err)
{
    if (!error_given(tree, call, "tree", err))
        return false;
    return !ground || (tree->def.dims == 3 && tree->def.origin_edge == 0.0f) ||
           bad_argument(err, "%s: %s are for trees in 3D without origin cells", call, name);
}

bool duet_tree_set_heights(duet_tree *tree, const duet_heights *h, duet_error *err)
{
    PUBLIC_CALL(err);
    return takes_ground(tree, h, __func__, "heights", err) && (!h || heights_check(h, err)) &&
           tree_take_ground(tree, h, NULL, err);
}

bool duet_tree_set_mesh(duet_tree *tree, const duet_mesh *m, duet_error *err)
{
    PUBLIC_CALL(err);
    return takes_ground(tree, m, __func__, "meshes", err) && (!m || mesh_check(m, err)) &&
           tree_take_ground(tree, NULL, m, err);
}

// ---------------------------------------------------------------- hits

static void find_some(void *arg, uint64_t first, uint64_t last)
{
    tree_query *q = arg;
    for (uint64_t i = first; i < last; ++i) {
        uint32_t *hit = q->on_ground + i * q->kind->hit_words;
        memset(hit, 0, query_hit_size(q));
        hit[0] = (uint32_t)i;
        bool meets = q->kind->meets_ground(q, query_item_at(q, i), hit);
        hit[1] = meets ? tree_ground_id(q->tree) : DUET_NO_OBJECT;
    }
}

static bool find(tree_query *q, uint64_t n, duet_error *err)
{
    thread_pool *a = q->sides[0].helpers, *b = q->sides[1].helpers;
    if (n > q->most_on_ground) {
        free(q->on_ground);
        q->on_ground = malloc((size_t)n * query_hit_size(q));
        q->most_on_ground = q->on_ground ? n : 0;
    }
    if (!q->on_ground)
        return no_memory(err, "%llu hits on the ground", (unsigned long long)n);
    thread_pool_share(b ? b : a, find_some, q, n, QUERY_PIECE);
    return true;
}

// A hit of an item among its `each` on objects, the best first.
static void insert(const tree_query *q, uint32_t *hits, const uint32_t *hit)
{
    uint32_t words = q->kind->hit_words, at = q->each;
    while (at > 0 && (hits[(at - 1) * words + 1] == DUET_NO_OBJECT ||
                      hits_compare(hit, hits + (at - 1) * words) < 0))
        --at;
    if (at == q->each)
        return;
    uint32_t *to = hits + at * words;
    memmove(to + words, to, (q->each - at - 1) * query_hit_size(q));
    memcpy(to, hit, query_hit_size(q));
    if (q->wants == QUERY_ANY)
        memset(to + 1, 0, query_hit_size(q) - sizeof *to);
}

static bool is_before(uint32_t words, const uint32_t *a, const uint32_t *b)
{
    return words > 2 ? hits_compare(a, b) < 0 : a[0] < b[0] || (a[0] == b[0] && a[1] < b[1]);
}

// Both lists by item, value and id.
static bool merge(tree_query *q, uint64_t n, query_result *found, duet_error *err)
{
    uint32_t words = q->kind->hit_words;
    hit_list *to = &q->with_ground;
    const uint32_t *hit = found->hits, *end = hit + found->n_hits * words;
    to->n = 0;
    if (!hits_reserve(to, words, NULL, found->n_hits + n, err))
        return false;
    for (uint64_t i = 0; i < n; ++i) {
        const uint32_t *ground = q->on_ground + i * words;
        if (ground[1] == DUET_NO_OBJECT)
            continue;
        for (; hit < end && is_before(words, hit, ground); hit += words)
            memcpy(hits_at(to, words, to->n++), hit, query_hit_size(q));
        memcpy(hits_at(to, words, to->n++), ground, query_hit_size(q));
    }
    if (hit < end)
        memcpy(hits_at(to, words, to->n), hit, (size_t)(end - hit) * sizeof *hit);
    found->n_hits = to->n + (uint64_t)(end - hit) / words;
    found->hits = to->block.bytes;
    return true;
}

// A filter without a group or a mask touches nothing.
static bool can_touch(const tree_query *q)
{
    return !q->filter || (q->filter->group && q->filter->mask);
}

bool ground_hits_add(tree_query *q, uint64_t n, query_result *found, duet_error *err)
{
    if (!ground_shape_is_there(&q->tree->ground) || !q->kind->meets_ground || q->itself ||
        !can_touch(q) || n == 0)
        return true;
    if (!find(q, n, err))
        return false;
    if (q->wants == QUERY_EVERY)
        return merge(q, n, found, err);
    uint32_t *hits = (uint32_t *)found->hits;
    for (uint64_t i = 0; i < n; ++i) {
        const uint32_t *ground = q->on_ground + i * q->kind->hit_words;
        if (ground[1] != DUET_NO_OBJECT)
            insert(q, hits + i * q->each * q->kind->hit_words, ground);
    }
    return true;
}

// SPDX-License-Identifier: MIT
#include "runtime/queries/ground_hits.h"

#include "base/error.h"
#include "runtime/narrowphase/heights.h"
#include "runtime/queries/query_chunk.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- the tree's ground

bool tree_take_ground(duet_tree *tree, const duet_heights *h, duet_error *err)
{
    float *values = NULL;
    size_t n = h ? (size_t)h->nx * h->ny : 0;
    if (h && !heights_check_places(h, err))
        return false;
    if (h && !(values = malloc(n * sizeof *values)))
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu heights", n);
    if (h)
        memcpy(values, h->heights, n * sizeof *values);
    free((float *)tree->ground.heights);
    tree->ground = h ? *h : (duet_heights){0};
    tree->ground.heights = values;
    return true;
}

bool duet_tree_set_heights(duet_tree *tree, const duet_heights *h, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(tree, __func__, "tree", err))
        return false;
    if (h && (tree->def.dims != 3 || tree->def.origin_edge > 0.0f))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%s: heights are for trees in 3D without origin cells", __func__);
    return (!h || heights_check(h, err)) && tree_take_ground(tree, h, err);
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
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %llu hits on the ground",
                         (unsigned long long)n);
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
    if (!q->tree->ground.heights || !q->kind->meets_ground || q->itself || !can_touch(q) || n == 0)
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

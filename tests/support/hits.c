// SPDX-License-Identifier: MIT
#include "support/hits.h"

#include "support/test.h"
#include "support/trees.h"

hit_list hit_list_of(const void *hits, uint64_t n, size_t bytes, uint32_t n_objects)
{
    return (hit_list){.next = hits,
                      .left = n,
                      .bytes = bytes,
                      .item = UINT32_MAX,
                      .n_objects = n_objects,
                      .met = test_alloc(n_objects * sizeof(bool))};
}

static uint32_t word(const char *row, int at)
{
    uint32_t value;
    memcpy(&value, row + 4 * at, sizeof value);
    return value;
}

static float order_of(const hit_list *l, const char *row)
{
    float value = 0;
    if (l->bytes > 8)
        memcpy(&value, row + 8, sizeof value);
    return value;
}

static void take(hit_list *l)
{
    const char *row = l->next, *last = row - l->bytes;
    uint32_t id = word(row, 1);
    assert_true(id < l->n_objects && !l->met[id]);
    if (l->n > 0)
        assert_true(order_of(l, last) < order_of(l, row) ||
                    (order_of(l, last) == order_of(l, row) && word(last, 1) < id));
    l->met[id] = true;
    l->next += l->bytes;
    ++l->n;
    --l->left;
}

const void *take_hits(hit_list *l, uint32_t item)
{
    const char *first = l->next;
    memset(l->met, 0, l->n_objects * sizeof *l->met);
    l->item = item;
    l->n = 0;
    while (l->left > 0 && word(l->next, 0) == item)
        take(l);
    l->taken += l->n;
    return l->n > 0 ? first : NULL;
}

bool has_hit(hit_list *l, uint32_t item, uint32_t id)
{
    if (l->item != item)
        take_hits(l, item);
    return l->met[id];
}

void expect_hit(hit_list *l, uint32_t item, uint32_t id, bool hit)
{
    if (has_hit(l, item, id) != hit)
        fail_msg("item %u %s object %u", item, hit ? "misses" : "hits", id);
}

void expect_no_more(const hit_list *l, uint64_t least)
{
    assert_int_equal(l->left, 0);
    assert_true(l->taken > least);
}

void closest_and_any_are_of_every(duet_tree *tree, duet_tree *other_share, duet_object_kind kind,
                                  const void *sweeps, uint32_t n, uint32_t n_objects)
{
    const duet_query_wants closest = DUET_QUERY_CLOSEST;
    duet_sweep_query_result all = run_sweeps(open_sweep_query(tree, DUET_QUERY_EVERY), kind, sweeps,
                                             n),
                            nearest = run_sweeps(open_sweep_query(tree, closest), kind, sweeps, n),
                            same =
                                run_sweeps(open_sweep_query(other_share, closest), kind, sweeps, n),
                            some =
                                run_sweeps(open_sweep_query(tree, DUET_QUERY_ANY), kind, sweeps, n);
    assert_int_equal(nearest.n_hits, n);
    assert_memory_equal(nearest.hits, same.hits, n * sizeof *same.hits);
    hit_list hits = HITS(all, n_objects);
    uint64_t n_same = 0, n_hit = 0;
    for (uint32_t i = 0; i < n; ++i) {
        const duet_sweep_hit *hit = &nearest.hits[i], *first = take_hits(&hits, i);
        const duet_sweep_hit yes = {i, first ? 0 : DUET_NO_OBJECT, 0, {0}};
        bool listed = false;
        assert_memory_equal(&some.hits[i], &yes, sizeof yes);
        for (uint32_t k = 0; k < hits.n; ++k)
            listed = listed || memcmp(&first[k], hit, sizeof *hit) == 0;
        assert_true(first ? listed : hit->id == DUET_NO_OBJECT);
        n_hit += first != NULL;
        n_same += first && first->id == hit->id;
        assert_true(!first || hit->t <= first->t + 0.05f); // a unit of t is a way of some units
    }
    assert_true(n_same * 50 >= n_hit * 49);
}

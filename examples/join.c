// SPDX-License-Identifier: MIT
// Which of a thousand boxes lie in three regions: a join of two sets.
//
// cc join.c $(pkg-config --cflags --libs duet) && ./a.out
#include <duet/duet.h>

#include <stdio.h>

enum { WIDE = 10, BOXES = WIDE * WIDE * WIDE };

static void fill(duet_bounds boxes[BOXES])
{
    for (int i = 0; i < BOXES; ++i) {
        const float corner[3] = {(float)(i % WIDE), (float)(i / WIDE % WIDE),
                                 (float)(i / WIDE / WIDE)};
        for (int k = 0; k < 3; ++k) {
            boxes[i].lower[k] = corner[k];
            boxes[i].upper[k] = corner[k] + 0.75f;
        }
    }
}

static bool join(duet_device_pair *pair, duet_error *err)
{
    static duet_bounds boxes[BOXES];
    const duet_bounds regions[] = {
        {{0, 0, 0}, {1, 1, 1}}, {{2.8f, 2.8f, 2.8f}, {2.9f, 2.9f, 2.9f}}, {{5, 5, 5}, {9, 5, 5}}};
    duet_tree_def def = duet_default_tree_def();
    duet_box_query_def query_def = duet_default_box_query_def();
    duet_box_query_result found;
    fill(boxes);
    def.pair = pair;
    def.shape = DUET_SHAPE_BOUNDS;
    duet_tree *tree = query_def.tree = duet_tree_create(&def, err);
    bool ok = tree && duet_tree_set_objects(tree, DUET_OBJECT_BOUNDS, boxes, BOXES, err);
    duet_box_query *query = ok ? duet_box_query_create(&query_def, err) : NULL;
    ok = query && duet_box_query_run(query, DUET_OBJECT_BOUNDS, regions, 3, &found, err);
    for (uint64_t i = 0; ok && i < found.n_hits; ++i)
        printf("region %u has box %u\n", found.hits[i].box, found.hits[i].id);
    duet_box_query_destroy(query);
    duet_tree_destroy(tree);
    return ok;
}

int main(void)
{
    duet_error err = {0};
    duet_device_pair_def def = duet_default_device_pair_def();
    duet_device_pair *pair = duet_device_pair_create(&def, &err);
    bool ok = pair && join(pair, &err);
    if (!ok)
        fprintf(stderr, "%s\n", err.text);
    duet_device_pair_destroy(pair);
    return !ok;
}

// SPDX-License-Identifier: MIT
// All hits of a query, taken item by item and held against what is true of each item and object.
// Rows of every kind begin with an item and an id; a third member is t or a distance, by which the
// hits of an item ascend, and by id where it is the same.
#ifndef TESTS_HITS_H
#define TESTS_HITS_H

#include "runtime/duet.h"

typedef struct hit_list {
    const char *next; // row of the items that were not taken
    uint64_t left, taken;
    size_t bytes;       // of a row
    uint32_t item, n;   // whose hits were taken last, and how many
    uint32_t n_objects; // ids are below
    bool *met;          // of each object: it is among the n
} hit_list;

#define HITS(found, n_objects) \
    hit_list_of((found).hits, (found).n_hits, sizeof *(found).hits, n_objects)

hit_list hit_list_of(const void *hits, uint64_t n, size_t bytes, uint32_t n_objects);

// Takes an item's hits; items ascend. Returns the first, NULL without any.
const void *take_hits(hit_list *list, uint32_t item);

// Whether the item has the object among its hits, which are taken.
bool has_hit(hit_list *list, uint32_t item, uint32_t id);
void expect_hit(hit_list *list, uint32_t item, uint32_t id, bool hit);

// None is left, and more than `least` were taken.
void expect_no_more(const hit_list *list, uint64_t least);

// The closest hit of a sweep is one of all, the same by another share, and none is closer by more
// than float is wrong by; any says whether there is one.
void closest_and_any_are_of_every(duet_tree *tree, duet_tree *other_share, duet_object_kind kind,
                                  const void *sweeps, uint32_t n, uint32_t n_objects);

#endif

// SPDX-License-Identifier: MIT
// Lists of hits: items' numbers, objects' ids and, where a hit has more than two words, a value.
#ifndef RUNTIME_QUERY_HITS_H
#define RUNTIME_QUERY_HITS_H

#include "runtime/opencl/buffer.h"

// In memory that the device reads and writes fast.
typedef struct hit_list {
    host_block block;
    uint64_t n, capacity; // hits
} hit_list;

// Takes hits of so many words. NULL of a list that never had a hit.
uint32_t *hits_at(const hit_list *list, uint32_t words, uint64_t i);

// Makes room for more hits. d: the device that reads and writes them; NULL: none.
bool hits_reserve(hit_list *list, uint32_t words, const device *d, uint64_t more, duet_error *err);

// By item, value and id.
int hits_compare(const void *x, const void *y);

// Sorts n hits, in any order, by item, value and id.
void hits_sort(uint32_t *hits, uint32_t words, uint64_t n);

// Sorts n hits of the items [first_item, first_item + n_items); false if there is no memory.
bool hits_sort_by_item(uint32_t *hits, uint32_t words, uint64_t n, uint32_t first_item,
                       uint32_t n_items);

#endif

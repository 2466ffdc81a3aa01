// SPDX-License-Identifier: MIT
// Lists that grow. One without memory for its items fails, and counts on, so that all ranks know.
#ifndef CLUSTER_LIST_H
#define CLUSTER_LIST_H

#include "base/compare.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct item_list {
    void *items;
    uint64_t n, capacity;
    bool failed;
} item_list;

// A list of items of that type, under a name of their own.
#define LIST_OF(type, items_)     \
    union {                       \
        item_list list;           \
        struct {                  \
            type *items_;         \
            uint64_t n, capacity; \
            bool failed;          \
        };                        \
    }

typedef LIST_OF(uint32_t, rows) row_list;

// Adds n items of so many bytes each.
static inline void list_add(item_list *l, const void *items, uint64_t n, size_t bytes)
{
    enum { LEAST = 256 };
    uint64_t all = l->n + n, more = 2 * l->capacity > LEAST ? 2 * l->capacity : LEAST;
    if (!l->failed && all > l->capacity) {
        l->capacity = all > more ? all : more;
        void *grown = realloc(l->items, l->capacity * bytes);
        l->failed = !grown;
        l->items = grown ? grown : l->items;
    }
    if (!l->failed && n > 0)
        memcpy((unsigned char *)l->items + l->n * bytes, items, n * bytes);
    l->n = all;
}

static inline void row_list_add(row_list *l, uint32_t row)
{
    list_add(&l->list, &row, 1, sizeof row);
}

// They ascend.
static inline void row_list_sort(row_list *l)
{
    if (l->n > 0 && !l->failed)
        qsort(l->rows, l->n, sizeof *l->rows, compare_uint32);
}

static inline void list_append(item_list *l, const item_list *more, size_t bytes)
{
    l->failed = l->failed || more->failed;
    list_add(l, more->items, more->n, bytes);
}

// Returns the first item that is not below the key, of those that ascend as the order does; n:
// none.
static inline uint64_t list_find(const item_list *l, size_t bytes, const void *key,
                                 int (*compare)(const void *, const void *))
{
    uint64_t low = 0, high = l->n;
    while (low < high) {
        uint64_t middle = low + (high - low) / 2;
        if (compare((const unsigned char *)l->items + middle * bytes, key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// Keeps the memory. One that has failed tries again.
static inline void list_clear(item_list *l)
{
    *l = (item_list){.items = l->items, .capacity = l->failed ? 0 : l->capacity};
}

#endif

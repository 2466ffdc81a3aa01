// SPDX-License-Identifier: MIT
// A chunk of a device's items: sent, ordered, asked about, and its hits settled. A query_side says
// which chunk by first_item and n, and its tree_side has the first failure.
#ifndef RUNTIME_QUERY_CHUNK_H
#define RUNTIME_QUERY_CHUNK_H

#include "runtime/queries/tree_query.h"

enum { QUERY_PIECE = 1 << 14 }; // rows that a thread takes at once

// Rows that threads share: hits of a query, or items and where they go.
typedef struct shared_rows {
    const tree_query *query;
    uint32_t *hits;
    const char *from;
    char *to;
} shared_rows;

static inline size_t query_hit_size(const tree_query *q)
{
    return q->kind->hit_words * sizeof(uint32_t);
}

static inline const char *query_item_at(const tree_query *q, uint64_t i)
{
    return q->items + i * q->kind->item_words * sizeof(float);
}

static inline uint64_t query_count_of(const cl_uint *words)
{
    return words[0] | (uint64_t)words[1] << 32;
}

// The tree's filters stay on the device from query to query, until a run of the objects with each
// other, which has filters of its own, needs their place.
bool query_send_filters(query_side *s);

// Sends the items of [first, first + n), asks about them and settles their hits.
bool query_run_chunk(query_side *s, uint64_t first, uint32_t n);

// ---------------------------------------------------------------- its parts, for query_flow.c

bool query_reserve_list(query_side *s, buffer *b, uint64_t hits);
bool query_order_items(query_side *s);
bool query_start(query_side *s); // the kernel is on its way afterwards
bool query_refuse_item(query_side *s, const cl_uint counters[QUERY_COUNTERS]); // false

// Takes the chunk's n hits, which are there, and the open ones, in any order.
bool query_settle(query_side *s, uint64_t n, uint32_t *open, uint64_t n_open);

#endif

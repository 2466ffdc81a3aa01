// SPDX-License-Identifier: MIT
#include "runtime/queries/query_flow.h"

#include "base/budget.h"
#include "runtime/queries/query_chunk.h"

#include <string.h>

// Items that are copied while others are traced are a quarter of all, between these: a launch and
// the first copy shall both cost little. Open hits are read without being counted first: a chunk
// seldom has as many. One thread copies 8 GB/s, a third of what the bus takes.
enum { LEAST_FLOW = 1 << 18, MOST_FLOW = 1 << 20, FLOW_OPEN = 1 << 12, HELPERS = 3 };

bool query_flows(const query_side *s)
{
    return s->each > 0 && !s->tree->device->info.host_memory;
}

uint64_t query_flow_items(const query_side *s)
{
    uint64_t quarter = (s->last - s->first) / 4 + 1;
    return quarter < LEAST_FLOW ? LEAST_FLOW : quarter > MOST_FLOW ? MOST_FLOW : quarter;
}

// Reserved and launched buffers are the flow's, until they are swapped back.
static void swap_buffers(query_side *s, query_flow *f)
{
    buffer_swap(&s->items, &f->items);
    buffer_swap(&s->hits, &f->hits);
    buffer_swap(&s->open, &f->open);
    buffer_swap(&s->counters, &f->counters);
}

static void select_chunk(query_side *s, const query_flow *f)
{
    s->first_item = (cl_uint)f->first;
    s->n = f->n;
}

static size_t item_bytes(const query_side *s, uint64_t n)
{
    return (size_t)n * s->query->kind->item_words * sizeof(float);
}

static size_t flow_hit_bytes(const query_side *s, const query_flow *f)
{
    return (size_t)f->n * s->each * query_hit_size(s->query);
}

static bool reserve_flow(query_side *s, query_flow *f)
{
    const device *d = s->tree->device;
    duet_error *err = &s->tree->err;
    size_t told = QUERY_COUNTERS * sizeof(cl_uint) + FLOW_OPEN * query_hit_size(s->query);
    return host_block_reserve(&f->staged, d, 1, item_bytes(s, f->n), err) &&
           host_block_reserve(&f->told, d, 1, told, err) &&
           buffer_reserve(&f->items, d, item_bytes(s, f->n), err) &&
           buffer_reserve(&f->counters, d, QUERY_COUNTERS * sizeof(cl_uint), err) &&
           query_reserve_list(s, &f->open, 0) &&
           query_reserve_list(s, &f->hits, (uint64_t)f->n * s->each);
}

static void copy_some(void *arg, uint64_t first, uint64_t last)
{
    const shared_rows *rows = arg;
    size_t bytes = rows->query->kind->item_words * sizeof(float);
    memcpy(rows->to + first * bytes, rows->from + first * bytes, (size_t)(last - first) * bytes);
}

// Nothing is waited for, here and in the next two.
static bool send_flow(query_side *s, query_flow *f, uint64_t first, uint32_t n)
{
    const tree_query *q = s->query;
    tree_side *t = s->tree;
    f->first = first;
    f->n = n;
    if (!reserve_flow(s, f))
        return false;
    shared_rows rows = {
        .query = q, .from = (const char *)query_item_at(q, first), .to = f->staged.bytes};
    thread_pool_share(s->helpers, copy_some, &rows, n, QUERY_PIECE);
    bool ok = timeline_write_beside(&t->times, "send items", &f->items, 0, f->staged.bytes,
                                    item_bytes(s, n), &t->err);
    f->over = timeline_last_event(&t->times);
    return ok;
}

static bool ask_flow(query_side *s, query_flow *f)
{
    tree_side *t = s->tree;
    select_chunk(s, f);
    swap_buffers(s, f);
    bool ok = timeline_follow(&t->times, f->over, &t->err) && query_order_items(s) &&
              query_start(s) && timeline_flush(&t->times, &t->err);
    swap_buffers(s, f);
    f->over = timeline_last_event(&t->times);
    return ok;
}

static bool fetch_flow(query_side *s, query_flow *f)
{
    const tree_query *q = s->query;
    tree_side *t = s->tree;
    cl_uint *counters = f->told.bytes;
    void *hits = hits_at(&s->found, q->kind->hit_words, (f->first - s->first) * s->each);
    bool ok = timeline_read_beside(&t->times, "fetch hits", &f->counters, counters,
                                   QUERY_COUNTERS * sizeof *counters, f->over, &t->err) &&
              timeline_read_beside(&t->times, "fetch hits", &f->open, counters + QUERY_COUNTERS,
                                   FLOW_OPEN * query_hit_size(q), NULL, &t->err) &&
              timeline_read_beside(&t->times, "fetch hits", &f->hits, hits, flow_hit_bytes(s, f),
                                   NULL, &t->err);
    f->over = timeline_last_event(&t->times);
    return ok;
}

static bool end_flow(query_side *s, query_flow *f)
{
    tree_side *t = s->tree;
    cl_uint *counters = f->told.bytes;
    select_chunk(s, f);
    timeline_spin(&t->times, f->over);
    if (!timeline_collect_to(&t->times, f->over, &t->err))
        return false;
    uint64_t n_open = query_count_of(counters + COUNT_OPEN);
    if (counters[BAD_LATEST] != 0)
        return query_refuse_item(s, counters);
    return n_open > FLOW_OPEN
               ? query_run_chunk(s, f->first, f->n)
               : query_settle(s, (uint64_t)f->n * s->each, counters + QUERY_COUNTERS, n_open);
}

// The events of a flow that is ended come before those of what is asked after it.
bool query_run_flows(query_side *s, uint64_t chunk)
{
    query_flow *before = NULL, *now = s->flows;
    if (!s->helpers && s->last - s->first >= chunk && thread_pool_spare(HELPERS) == HELPERS)
        s->helpers = thread_pool_open(HELPERS, NULL); // without them it takes longer
    for (uint64_t first = s->first; first < s->last; first += chunk) {
        uint64_t left = s->last - first;
        if (!budget_check(&s->tree->err) ||
            !send_flow(s, now, first, (uint32_t)(left < chunk ? left : chunk)) ||
            (before && !fetch_flow(s, before)) || !ask_flow(s, now) ||
            (before && !end_flow(s, before)))
            return false;
        before = now;
        now = now == s->flows ? s->flows + 1 : s->flows;
    }
    return fetch_flow(s, before) && end_flow(s, before);
}

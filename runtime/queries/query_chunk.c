// SPDX-License-Identifier: MIT
#include "runtime/queries/query_chunk.h"

#include "base/error.h"

#include <string.h>

// Fewer items are asked about sooner than sorted.
enum { LEAST_SORTED = 1 << 13, LEAST_LIST = 1 << 14 };

static cl_uint hits_in(const query_side *s, const buffer *b)
{
    size_t n = b->bytes / query_hit_size(s->query);
    return n > UINT32_MAX ? UINT32_MAX : (cl_uint)n;
}

bool query_reserve_list(query_side *s, buffer *b, uint64_t hits)
{
    hits = hits < LEAST_LIST ? LEAST_LIST : hits;
    return buffer_reserve(b, s->tree->device, (size_t)hits * query_hit_size(s->query),
                          &s->tree->err);
}

static bool write_filters(tree_side *t, const duet_filter *filters, size_t bytes)
{
    if (!buffer_reserve(&t->filters, t->device, bytes, &t->err))
        return false;
    return filters ? timeline_write(&t->times, "send filters", &t->filters, filters, bytes, &t->err)
                   : timeline_fill(&t->times, "clear", &t->filters, UINT32_MAX, 0,
                                   bytes / sizeof(cl_uint), &t->err);
}

bool query_send_filters(query_side *s)
{
    const tree_query *q = s->query;
    tree_side *t = s->tree;
    uint64_t known = q->itself ? 0 : q->tree->filters_set;
    if (!q->itself && (!q->filter || t->filters_known == known))
        return true;
    t->filters_known = 0;
    if (!write_filters(t, q->itself ? q->filters : q->tree->filters,
                       q->tree->n * sizeof *q->filters))
        return false;
    t->filters_known = known;
    return true;
}

// The device has the tree's objects.
static bool send_items(query_side *s)
{
    if (s->query->itself)
        return true;
    const char *items = query_item_at(s->query, s->first_item);
    size_t bytes = (size_t)s->n * s->query->kind->item_words * sizeof(float);
    return buffer_hold(&s->items, s->tree->device, (void *)items, bytes, &s->tree->err) &&
           timeline_write(&s->tree->times, "send items", &s->items, items, bytes, &s->tree->err);
}

bool query_order_items(query_side *s)
{
    box_tree *t = &s->tree->boxes;
    bool itself = s->query->itself;
    s->in_order = s->n < LEAST_SORTED;
    return s->in_order || box_tree_order(t, &s->tree->times, itself ? &t->objects : &s->items,
                                         s->query->kind->item_words, s->query->kind->item_cell,
                                         itself ? s->first_item : 0, s->n, &s->tree->err);
}

bool query_start(query_side *s)
{
    tree_side *t = s->tree;
    s->objects = t->boxes.objects;
    s->boxes = t->boxes.boxes;
    s->nodes = t->boxes.nodes;
    s->levels = t->boxes.levels;
    s->order = t->boxes.ids;
    s->filters = t->filters;
    s->n_levels = t->boxes.n_levels;
    s->hits_capacity = hits_in(s, &s->hits);
    s->open_capacity = hits_in(s, &s->open);
    return timeline_fill(&t->times, "clear", &s->counters, 0, 0, QUERY_COUNTERS, &t->err) &&
           timeline_launch(&t->times, s->query->kind->kernel, s->kernel, s->n, s, &t->err);
}

static bool ask_once(query_side *s, cl_uint counters[QUERY_COUNTERS])
{
    tree_side *t = s->tree;
    return query_start(s) && timeline_read(&t->times, "fetch hits", &s->counters, counters,
                                           QUERY_COUNTERS * sizeof *counters, &t->err);
}

// Hits that the device has written, by its counters.
static uint64_t hits_found(const query_side *s, const cl_uint counters[QUERY_COUNTERS])
{
    return s->each > 0 ? (uint64_t)s->n * s->each : query_count_of(counters + COUNT_HITS);
}

// Lists that are too short are made longer, and the chunk is asked about again.
static bool ask(query_side *s, cl_uint counters[QUERY_COUNTERS])
{
    bool ok = query_reserve_list(s, &s->open, 0) &&
              query_reserve_list(s, &s->hits, s->each > 0 ? (uint64_t)s->n * s->each : s->n);
    while (ok) {
        ok = ask_once(s, counters);
        uint64_t hits = hits_found(s, counters), open = query_count_of(counters + COUNT_OPEN);
        if (!ok || (hits <= s->hits_capacity && open <= s->open_capacity))
            return ok;
        if (hits > UINT32_MAX || open > UINT32_MAX)
            return error_set(&s->tree->err, DUET_STATUS_TOO_MANY,
                             "%s %llu and on meet %llu objects, more than can be listed at once",
                             s->query->kind->item, (unsigned long long)s->first_item,
                             (unsigned long long)(hits + open));
        ok = query_reserve_list(s, &s->hits, hits) && query_reserve_list(s, &s->open, open);
    }
    return false;
}

static bool is_better(const tree_query *q, const uint32_t *hit, const uint32_t *known)
{
    return q->wants != QUERY_ANY && hits_compare(hit, known) < 0;
}

// `hits` are those of the chunk.
static void take_open_hit(query_side *s, uint32_t *hits, uint32_t *open)
{
    const tree_query *q = s->query;
    uint32_t *known = s->each > 0 ? hits + (open[0] - s->first_item) * q->kind->hit_words : NULL;
    bool has_hit = known && known[1] != DUET_NO_OBJECT;
    if (has_hit && !is_better(q, open, known))
        return;
    ++s->undecided;
    if (!q->kind->meets(q->tree, query_item_at(q, open[0]), open) ||
        (has_hit && !is_better(q, open, known)))
        return;
    if (!known)
        known = hits_at(&s->found, q->kind->hit_words, s->found.n++); // reserved
    memcpy(known, open, query_hit_size(q));
    if (q->wants == QUERY_ANY)
        memset(known + 1, 0, query_hit_size(q) - sizeof *known);
}

static bool read_hits(query_side *s, buffer *from, uint32_t *to, uint64_t n)
{
    return n == 0 || timeline_read(&s->tree->times, "fetch hits", from, to,
                                   (size_t)n * query_hit_size(s->query), &s->tree->err);
}

static void finish_some(void *arg, uint64_t first, uint64_t last)
{
    const shared_rows *rows = arg;
    const tree_query *q = rows->query;
    for (uint64_t i = first; i < last; ++i) {
        uint32_t *hit = rows->hits + i * q->kind->hit_words;
        if (hit[1] != DUET_NO_OBJECT)
            q->kind->finish(q->tree, query_item_at(q, hit[0]), hit);
    }
}

static void finish_hits(query_side *s, uint64_t begin, uint64_t end)
{
    const tree_query *q = s->query;
    shared_rows rows = {.query = q, .hits = hits_at(&s->found, q->kind->hit_words, begin)};
    if (q->kind->finish && q->wants != QUERY_ANY)
        thread_pool_share(s->helpers, finish_some, &rows, end - begin, QUERY_PIECE);
}

// The place of the chunk's hits: one for each item, or behind the hits before.
static uint64_t hits_begin(const query_side *s)
{
    return s->each > 0 ? (s->first_item - s->first) * s->each : s->found.n;
}

// Takes those from `begin` on.
static bool sort_found(query_side *s, uint64_t begin)
{
    uint32_t words = s->query->kind->hit_words;
    uint64_t n = s->found.n - begin;
    return hits_sort_by_item(hits_at(&s->found, words, begin), words, n, s->first_item, s->n) ||
           no_memory(&s->tree->err, "%llu sorted hits", (unsigned long long)n);
}

bool query_settle(query_side *s, uint64_t n, uint32_t *open, uint64_t n_open)
{
    const tree_query *q = s->query;
    uint64_t begin = hits_begin(s);
    uint32_t *hits = hits_at(&s->found, q->kind->hit_words, begin);
    if (s->each == 0)
        s->found.n += n;
    if ((n_open > 0 || (n > 0 && q->kind->finish_reads)) &&
        !tree_fetch_objects(q->tree, &s->tree->err))
        return false;
    hits_sort(open, q->kind->hit_words, n_open);
    for (uint64_t i = 0; i < n_open; ++i)
        take_open_hit(s, hits, open + i * q->kind->hit_words);
    finish_hits(s, begin, s->each > 0 ? begin + n : s->found.n);
    return q->wants != QUERY_EVERY || sort_found(s, begin);
}

static bool fetch(query_side *s, const cl_uint counters[QUERY_COUNTERS])
{
    const tree_query *q = s->query;
    const device *d = s->tree->device;
    uint64_t n = hits_found(s, counters), n_open = query_count_of(counters + COUNT_OPEN);
    s->open_hits.n = 0;
    if ((s->each == 0 &&
         !hits_reserve(&s->found, q->kind->hit_words, d, n + n_open, &s->tree->err)) ||
        !hits_reserve(&s->open_hits, q->kind->hit_words, d, n_open, &s->tree->err))
        return false;
    uint32_t *open = s->open_hits.block.bytes;
    return read_hits(s, &s->hits, hits_at(&s->found, q->kind->hit_words, hits_begin(s)), n) &&
           read_hits(s, &s->open, open, n_open) && query_settle(s, n, open, n_open);
}

bool query_refuse_item(query_side *s, const cl_uint counters[QUERY_COUNTERS])
{
    return error_set(&s->tree->err, DUET_STATUS_BAD_OBJECT, "%s %llu: %s", s->query->kind->item,
                     (unsigned long long)s->first_item + ~counters[BAD_LATEST],
                     s->query->kind->wrong);
}

bool query_run_chunk(query_side *s, uint64_t first, uint32_t n)
{
    cl_uint counters[QUERY_COUNTERS];
    s->n = n;
    s->first_item = (cl_uint)first;
    return send_items(s) && query_order_items(s) && ask(s, counters) &&
           (counters[BAD_LATEST] == 0 || query_refuse_item(s, counters)) && fetch(s, counters);
}

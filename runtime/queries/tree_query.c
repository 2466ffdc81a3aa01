// SPDX-License-Identifier: MIT
// A takes the first share of the items and B the rest, at the same time; each has the whole tree.
// The host decides hits that float leaves open, a chunk of items at a time. While a device with
// memory of its own traces a chunk, the host copies the next one for it and decides the one before.
#include "runtime/queries/tree_query.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/compare.h"
#include "base/error.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/queries/far_rows.h"

#include <stdlib.h>
#include <string.h>

// Some 30 MB of items: launches cost nothing beside it, and few devices lack it.
enum { CHUNK = 1 << 20, LEAST_LIST = 1 << 14 };

// Items that are copied while others are traced are a quarter of all, between these: a launch and
// the first copy shall both cost little. Open hits are read without being counted first: a chunk
// seldom has as many. One thread copies 8 GB/s, a third of what the bus takes.
enum {
    LEAST_FLOW = 1 << 18,
    MOST_FLOW = 1 << 20,
    FLOW_OPEN = 1 << 12,
    HELPERS = 3,
    PIECE = 1 << 14
};

// Fewer items are asked about sooner than sorted.
enum { LEAST_SORTED = 1 << 13 };

static const binding side_bindings[] = {BIND_BUFFER(query_side, "items", "float *", items),
                                        BIND_BUFFER(query_side, "filters", "uint2 *", filters),
                                        BIND_BUFFER(query_side, "objects", "float *", objects),
                                        BIND_BUFFER(query_side, "boxes", "float *", boxes),
                                        BIND_BUFFER(query_side, "nodes", "float *", nodes),
                                        BIND_BUFFER(query_side, "levels", "uint *", levels),
                                        BIND_BUFFER(query_side, "hits", "uint *", hits),
                                        BIND_BUFFER(query_side, "open", "uint *", open),
                                        BIND_BUFFER(query_side, "counters", "uint *", counters),
                                        BIND_BUFFER(query_side, "order", "uint *", order),
                                        BIND_VALUE(query_side, "in_order", in_order),
                                        BIND_VALUE(query_side, "n", n),
                                        BIND_VALUE(query_side, "first_item", first_item),
                                        BIND_VALUE(query_side, "n_levels", n_levels),
                                        BIND_VALUE(query_side, "hits_capacity", hits_capacity),
                                        BIND_VALUE(query_side, "open_capacity", open_capacity),
                                        BIND_VALUE(query_side, "each", each),
                                        BIND_VALUE(query_side, "group", group),
                                        BIND_VALUE(query_side, "mask", mask),
                                        {0}};

bool tree_query_knows(duet_query_wants wants, duet_error *err)
{
    return duet_query_wants_name(wants) ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT, "wants is %d; expected a duet_query_wants",
                     (int)wants);
}

bool tree_query_check_def(bool is_ours, const duet_tree *tree, const char *maker, duet_error *err)
{
    if (!is_ours)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "the query's def does not come from %s",
                         maker);
    return tree || error_set(err, DUET_STATUS_BAD_ARGUMENT, "the query's def has no tree");
}

// ---------------------------------------------------------------- owner

void *tree_query_new(size_t bytes, duet_error *err)
{
    void *query = calloc(1, bytes);
    if (!query)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a query");
    return query;
}

static void close_flow(query_flow *f)
{
    host_block_release(&f->staged);
    host_block_release(&f->told);
    buffer *const all[] = {&f->items, &f->hits, &f->open, &f->counters};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        buffer_release(all[i]);
}

static void close_side(query_side *s)
{
    buffer *const all[] = {&s->items, &s->hits, &s->open, &s->counters};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        buffer_release(all[i]);
    close_flow(&s->flows[0]);
    close_flow(&s->flows[1]);
    thread_pool_close(s->helpers);
    host_block_release(&s->found.block);
    host_block_release(&s->open_hits.block);
    *s = (query_side){0};
}

static bool open_side(query_side *s, tree_query *q, tree_side *tree, duet_error *err)
{
    *s = (query_side){.query = q,
                      .tree = tree,
                      .each = q->each,
                      .group = q->own_filter.group,
                      .mask = q->own_filter.mask};
    s->kernel = program_set_kernel(tree->programs, q->kind->kernel, q->kind->kernel, q->settings,
                                   q->n_settings, side_bindings, err);
    if (s->kernel && program_set_build(tree->programs, err) &&
        buffer_reserve(&s->counters, tree->device, QUERY_COUNTERS * sizeof(cl_uint), err))
        return true;
    close_side(s);
    return false;
}

// Opens the sides that the tree got since the last run, too.
static bool open_sides(tree_query *q, duet_error *err)
{
    bool ok = true;
    for (int which = 0; ok && which < 2; ++which)
        ok = !q->tree->sides[which].device || q->sides[which].kernel ||
             open_side(&q->sides[which], q, &q->tree->sides[which], err);
    return ok;
}

bool tree_query_open(tree_query *q, const query_name *name, const duet_filter *filter,
                     const gen_setting *settings, uint32_t n_settings, duet_error *err)
{
    tree_hold(q->tree);
    query_name_write(name, q->name);
    if (filter) {
        q->own_filter = *filter;
        q->filter = &q->own_filter;
    }
    q->settings[0] = (gen_setting){"DIMS", q->tree->def.dims};
    q->settings[1] = (gen_setting){"SHAPE", box_tree_shape(q->tree->def.shape)};
    q->settings[2] = (gen_setting){"ORIGIN", origin_setting(q->tree->def.origin_edge)};
    q->settings[3] = (gen_setting){"FILTERED", filter != NULL};
    for (uint32_t i = 0; i < n_settings; ++i)
        q->settings[4 + i] = settings[i];
    q->n_settings = 4 + n_settings;
    return open_sides(q, err);
}

void tree_query_close(tree_query *q)
{
    close_side(&q->sides[0]);
    close_side(&q->sides[1]);
    host_block_release(&q->joined.block);
    free(q->own_items);
    free(q->normals);
    duet_tree_destroy(q->tree);
}

// ---------------------------------------------------------------- hits

static size_t hit_bytes(const tree_query *q)
{
    return q->kind->hit_words * sizeof(uint32_t);
}

// NULL of a list that never had a hit.
static uint32_t *hit_at(const tree_query *q, const hit_list *list, uint64_t i)
{
    uint32_t *hits = list->block.bytes;
    return hits ? hits + i * q->kind->hit_words : NULL;
}

// d: the device that reads and writes them; NULL: none.
static bool reserve_hits(const tree_query *q, hit_list *list, const device *d, uint64_t more,
                         duet_error *err)
{
    host_block grown = {0};
    uint64_t wanted = list->n + more;
    if (wanted <= list->capacity)
        return true;
    uint64_t capacity = wanted + wanted / 4;
    if (!host_block_reserve(&grown, d, d ? 1 : 0, (size_t)capacity * hit_bytes(q), err))
        return false;
    if (list->n > 0)
        memcpy(grown.bytes, list->block.bytes, (size_t)list->n * hit_bytes(q));
    host_block_release(&list->block);
    list->block = grown;
    list->capacity = capacity;
    return true;
}

static float value_of(const uint32_t *hit)
{
    float value;
    memcpy(&value, &hit[2], sizeof value);
    return value;
}

// By item, value and id.
static int compare_hits(const void *x, const void *y)
{
    const uint32_t *a = x, *b = y;
    float of_a = value_of(a), of_b = value_of(b);
    if (a[0] != b[0] || of_a == of_b)
        return compare_uint32_pair(a, b);
    return of_a < of_b ? -1 : 1;
}

typedef int comparison(const void *x, const void *y);

static comparison *comparison_of(const tree_query *q)
{
    return q->kind->hit_words > 2 ? compare_hits : compare_uint32_pair;
}

// The last n hits: by item first, which is a place, then the few of each item.
static bool sort_hits(query_side *s, uint64_t n)
{
    const tree_query *q = s->query;
    size_t width = hit_bytes(q);
    char *hits = (char *)hit_at(q, &s->found, s->found.n - n);
    uint64_t *end = calloc((size_t)s->n + 1, sizeof *end);
    char *by_item = malloc((size_t)(n + 1) * width);
    bool ok = end && by_item;
    for (uint64_t i = 0; ok && i < n; ++i)
        ++end[*(uint32_t *)(hits + i * width) - s->first_item + 1];
    for (cl_uint item = 0; ok && item < s->n; ++item)
        end[item + 1] += end[item];
    for (uint64_t i = 0; ok && i < n; ++i) {
        uint32_t item = *(uint32_t *)(hits + i * width) - s->first_item;
        memcpy(by_item + end[item]++ * width, hits + i * width, width);
    }
    for (cl_uint item = 0; ok && item < s->n; ++item) {
        uint64_t first = item > 0 ? end[item - 1] : 0;
        if (end[item] - first > 1)
            qsort(by_item + first * width, (size_t)(end[item] - first), width, comparison_of(q));
    }
    if (ok && n > 0)
        memcpy(hits, by_item, (size_t)n * width);
    free(end);
    free(by_item);
    return ok || error_set(&s->tree->err, DUET_STATUS_NO_MEMORY, "no host memory to sort %llu hits",
                           (unsigned long long)n);
}

// ---------------------------------------------------------------- a chunk of items

static cl_uint hits_in(const query_side *s, const buffer *b)
{
    size_t n = b->bytes / hit_bytes(s->query);
    return n > UINT32_MAX ? UINT32_MAX : (cl_uint)n;
}

static bool reserve_list(query_side *s, buffer *b, uint64_t hits)
{
    hits = hits < LEAST_LIST ? LEAST_LIST : hits;
    return buffer_reserve(b, s->tree->device, (size_t)hits * hit_bytes(s->query), &s->tree->err);
}

static const char *item_at(const tree_query *q, uint64_t i)
{
    return q->items + i * q->item_words * sizeof(float);
}

static bool write_filters(tree_side *t, const duet_filter *filters, size_t bytes)
{
    if (!buffer_reserve(&t->filters, t->device, bytes, &t->err))
        return false;
    return filters ? timeline_write(&t->times, "send filters", &t->filters, filters, bytes, &t->err)
                   : timeline_fill(&t->times, "clear", &t->filters, UINT32_MAX, 0,
                                   bytes / sizeof(cl_uint), &t->err);
}

// The tree's stay on the device from query to query, until a run of the objects with each other,
// which has filters of its own, needs their place.
static bool send_filters(query_side *s)
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
    const char *items = item_at(s->query, s->first_item);
    size_t bytes = (size_t)s->n * s->query->item_words * sizeof(float);
    return buffer_hold(&s->items, s->tree->device, (void *)items, bytes, &s->tree->err) &&
           timeline_write(&s->tree->times, "send items", &s->items, items, bytes, &s->tree->err);
}

static bool order_items(query_side *s)
{
    box_tree *t = &s->tree->boxes;
    bool itself = s->query->itself;
    s->in_order = s->n < LEAST_SORTED;
    return s->in_order || box_tree_order(t, &s->tree->times, itself ? &t->objects : &s->items,
                                         s->query->item_words, s->query->item_cell,
                                         itself ? s->first_item : 0, s->n, &s->tree->err);
}

static uint64_t count_of(const cl_uint *words)
{
    return words[0] | (uint64_t)words[1] << 32;
}

// The kernel is on its way afterwards.
static bool start_asking(query_side *s)
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
    return start_asking(s) && timeline_read(&t->times, "fetch hits", &s->counters, counters,
                                            QUERY_COUNTERS * sizeof *counters, &t->err);
}

// Hits that the device has written, by its counters.
static uint64_t hits_found(const query_side *s, const cl_uint counters[QUERY_COUNTERS])
{
    return s->each > 0 ? (uint64_t)s->n * s->each : count_of(counters + COUNT_HITS);
}

// Lists that are too short are made longer, and the chunk is asked about again.
static bool ask(query_side *s, cl_uint counters[QUERY_COUNTERS])
{
    bool ok = reserve_list(s, &s->open, 0) &&
              reserve_list(s, &s->hits, s->each > 0 ? (uint64_t)s->n * s->each : s->n);
    while (ok) {
        ok = ask_once(s, counters);
        uint64_t hits = hits_found(s, counters), open = count_of(counters + COUNT_OPEN);
        if (!ok || (hits <= s->hits_capacity && open <= s->open_capacity))
            return ok;
        if (hits > UINT32_MAX || open > UINT32_MAX)
            return error_set(&s->tree->err, DUET_STATUS_TOO_MANY,
                             "%s %llu and on meet %llu objects, more than can be listed at once",
                             s->query->kind->item, (unsigned long long)s->first_item,
                             (unsigned long long)(hits + open));
        ok = reserve_list(s, &s->hits, hits) && reserve_list(s, &s->open, open);
    }
    return false;
}

static bool is_better(const tree_query *q, const uint32_t *hit, const uint32_t *known)
{
    return q->wants != QUERY_ANY && compare_hits(hit, known) < 0;
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
    if (!q->kind->meets(q->tree, item_at(q, open[0]), open) ||
        (has_hit && !is_better(q, open, known)))
        return;
    if (!known)
        known = hit_at(q, &s->found, s->found.n++); // reserved
    memcpy(known, open, hit_bytes(q));
    if (q->wants == QUERY_ANY)
        memset(known + 1, 0, hit_bytes(q) - sizeof *known);
}

static bool read_hits(query_side *s, buffer *from, uint32_t *to, uint64_t n)
{
    return n == 0 || timeline_read(&s->tree->times, "fetch hits", from, to,
                                   (size_t)n * hit_bytes(s->query), &s->tree->err);
}

// Rows that threads share: hits of a query, or items and where they go.
typedef struct shared_rows {
    const tree_query *query;
    uint32_t *hits;
    const char *from;
    char *to;
} shared_rows;

static void finish_some(void *arg, uint64_t first, uint64_t last)
{
    const shared_rows *rows = arg;
    const tree_query *q = rows->query;
    for (uint64_t i = first; i < last; ++i) {
        uint32_t *hit = rows->hits + i * q->kind->hit_words;
        if (hit[1] != DUET_NO_OBJECT)
            q->kind->finish(q->tree, item_at(q, hit[0]), hit);
    }
}

static void finish_hits(query_side *s, uint64_t begin, uint64_t end)
{
    const tree_query *q = s->query;
    shared_rows rows = {.query = q, .hits = hit_at(q, &s->found, begin)};
    if (q->kind->finish && q->wants != QUERY_ANY)
        thread_pool_share(s->helpers, finish_some, &rows, end - begin, PIECE);
}

// The place of the chunk's hits: one for each item, or behind the hits before.
static uint64_t hits_begin(const query_side *s)
{
    return s->each > 0 ? (s->first_item - s->first) * s->each : s->found.n;
}

// The chunk's n hits are there, and the open ones, in any order.
static bool settle(query_side *s, uint64_t n, uint32_t *open, uint64_t n_open)
{
    const tree_query *q = s->query;
    uint64_t begin = hits_begin(s);
    uint32_t *hits = hit_at(q, &s->found, begin);
    if (s->each == 0)
        s->found.n += n;
    if ((n_open > 0 || (n > 0 && q->kind->finish_reads)) &&
        !tree_fetch_objects(q->tree, &s->tree->err))
        return false;
    if (n_open > 0)
        qsort(open, (size_t)n_open, hit_bytes(q), comparison_of(q));
    for (uint64_t i = 0; i < n_open; ++i)
        take_open_hit(s, hits, open + i * q->kind->hit_words);
    finish_hits(s, begin, s->each > 0 ? begin + n : s->found.n);
    return q->wants != QUERY_EVERY || sort_hits(s, s->found.n - begin);
}

static bool fetch(query_side *s, const cl_uint counters[QUERY_COUNTERS])
{
    const tree_query *q = s->query;
    const device *d = s->tree->device;
    uint64_t n = hits_found(s, counters), n_open = count_of(counters + COUNT_OPEN);
    s->open_hits.n = 0;
    if ((s->each == 0 && !reserve_hits(q, &s->found, d, n + n_open, &s->tree->err)) ||
        !reserve_hits(q, &s->open_hits, d, n_open, &s->tree->err))
        return false;
    uint32_t *open = s->open_hits.block.bytes;
    return read_hits(s, &s->hits, hit_at(q, &s->found, hits_begin(s)), n) &&
           read_hits(s, &s->open, open, n_open) && settle(s, n, open, n_open);
}

static bool refuse_item(query_side *s, const cl_uint counters[QUERY_COUNTERS])
{
    return error_set(&s->tree->err, DUET_STATUS_BAD_OBJECT, "%s %llu: %s", s->query->kind->item,
                     (unsigned long long)s->first_item + ~counters[BAD_LATEST],
                     s->query->kind->wrong);
}

static bool run_chunk(query_side *s, uint64_t first, uint32_t n)
{
    cl_uint counters[QUERY_COUNTERS];
    s->n = n;
    s->first_item = (cl_uint)first;
    return send_items(s) && order_items(s) && ask(s, counters) &&
           (counters[BAD_LATEST] == 0 || refuse_item(s, counters)) && fetch(s, counters);
}

// ---------------------------------------------------------------- chunks that follow each other

// While one is traced the next is copied and sent, and the one before is fetched and settled.
static bool flows(const query_side *s)
{
    return s->each > 0 && !s->tree->device->info.host_memory;
}

static uint64_t flow_items(const query_side *s)
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

static void show(query_side *s, const query_flow *f)
{
    s->first_item = (cl_uint)f->first;
    s->n = f->n;
}

static size_t item_bytes(const query_side *s, uint64_t n)
{
    return (size_t)n * s->query->item_words * sizeof(float);
}

static size_t flow_hit_bytes(const query_side *s, const query_flow *f)
{
    return (size_t)f->n * s->each * hit_bytes(s->query);
}

static bool reserve_flow(query_side *s, query_flow *f)
{
    const device *d = s->tree->device;
    duet_error *err = &s->tree->err;
    size_t told = QUERY_COUNTERS * sizeof(cl_uint) + FLOW_OPEN * hit_bytes(s->query);
    return host_block_reserve(&f->staged, d, 1, item_bytes(s, f->n), err) &&
           host_block_reserve(&f->told, d, 1, told, err) &&
           buffer_reserve(&f->items, d, item_bytes(s, f->n), err) &&
           buffer_reserve(&f->counters, d, QUERY_COUNTERS * sizeof(cl_uint), err) &&
           reserve_list(s, &f->open, 0) && reserve_list(s, &f->hits, (uint64_t)f->n * s->each);
}

static void copy_some(void *arg, uint64_t first, uint64_t last)
{
    const shared_rows *rows = arg;
    size_t bytes = rows->query->item_words * sizeof(float);
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
    shared_rows rows = {.query = q, .from = (const char *)item_at(q, first), .to = f->staged.bytes};
    thread_pool_share(s->helpers, copy_some, &rows, n, PIECE);
    bool ok = timeline_write_beside(&t->times, "send items", &f->items, 0, f->staged.bytes,
                                    item_bytes(s, n), &t->err);
    f->over = timeline_last_event(&t->times);
    return ok;
}

static bool ask_flow(query_side *s, query_flow *f)
{
    tree_side *t = s->tree;
    show(s, f);
    swap_buffers(s, f);
    bool ok = timeline_follow(&t->times, f->over, &t->err) && order_items(s) && start_asking(s) &&
              timeline_flush(&t->times, &t->err);
    swap_buffers(s, f);
    f->over = timeline_last_event(&t->times);
    return ok;
}

static bool fetch_flow(query_side *s, query_flow *f)
{
    const tree_query *q = s->query;
    tree_side *t = s->tree;
    cl_uint *counters = f->told.bytes;
    void *hits = hit_at(q, &s->found, (f->first - s->first) * s->each);
    bool ok = timeline_read_beside(&t->times, "fetch hits", &f->counters, counters,
                                   QUERY_COUNTERS * sizeof *counters, f->over, &t->err) &&
              timeline_read_beside(&t->times, "fetch hits", &f->open, counters + QUERY_COUNTERS,
                                   FLOW_OPEN * hit_bytes(q), NULL, &t->err) &&
              timeline_read_beside(&t->times, "fetch hits", &f->hits, hits, flow_hit_bytes(s, f),
                                   NULL, &t->err);
    f->over = timeline_last_event(&t->times);
    return ok;
}

static bool end_flow(query_side *s, query_flow *f)
{
    tree_side *t = s->tree;
    cl_uint *counters = f->told.bytes;
    show(s, f);
    timeline_spin(&t->times, f->over);
    if (!timeline_collect_to(&t->times, f->over, &t->err))
        return false;
    uint64_t n_open = count_of(counters + COUNT_OPEN);
    if (counters[BAD_LATEST] != 0)
        return refuse_item(s, counters);
    return n_open > FLOW_OPEN
               ? run_chunk(s, f->first, f->n)
               : settle(s, (uint64_t)f->n * s->each, counters + QUERY_COUNTERS, n_open);
}

// The events of a flow that is ended come before those of what is asked after it.
static bool run_flows(query_side *s, uint64_t chunk)
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

static bool run_chunks(query_side *s, uint64_t chunk)
{
    bool ok = true;
    for (uint64_t first = s->first; ok && first < s->last; first += chunk) {
        uint64_t left = s->last - first;
        ok = budget_check(&s->tree->err) &&
             run_chunk(s, first, (uint32_t)(left < chunk ? left : chunk));
    }
    return ok;
}

static void run_side(void *arg)
{
    query_side *s = arg;
    tree_side *t = s->tree;
    uint64_t begun = clock_steady_ns();
    uint64_t items = flows(s) ? flow_items(s) : CHUNK;
    uint64_t chunk = s->each > 1 ? items / s->each + 1 : items;
    uint64_t n_hits = (s->last - s->first) * s->each;
    timeline_begin(&t->times, t->device, true);
    t->ok = send_filters(s) && reserve_hits(s->query, &s->found, t->device, n_hits, &t->err) &&
            (flows(s) ? run_flows(s, chunk) : run_chunks(s, chunk));
    s->found.n = s->each > 0 ? n_hits : s->found.n;
    t->ok = timeline_finish(&t->times, &t->err) && t->ok; // nothing is read any more
    timeline_clear(&t->times);
    if (s->items.borrowed) // the caller may free it
        buffer_release(&s->items);
    s->wall_ms = clock_ms_since(begun);
}

// ---------------------------------------------------------------- all items

static query_side *begin_side(tree_query *q, int which, uint64_t first, uint64_t last)
{
    query_side *s = &q->sides[which];
    s->first = first;
    s->last = last;
    s->found.n = 0;
    s->undecided = 0;
    s->wall_ms = 0;
    return first < last ? s : NULL;
}

// A's items are the first ones.
static bool join_hits(tree_query *q, query_result *result, duet_error *err)
{
    hit_list *a = &q->sides[0].found, *b = &q->sides[1].found, *to = &q->joined;
    result->n_hits = a->n + b->n;
    if (a->n == 0 || b->n == 0) {
        result->hits = a->n ? a->block.bytes : b->block.bytes;
        return true;
    }
    to->n = 0;
    if (!reserve_hits(q, to, NULL, result->n_hits, err))
        return false;
    memcpy(to->block.bytes, a->block.bytes, (size_t)a->n * hit_bytes(q));
    memcpy(hit_at(q, to, a->n), b->block.bytes, (size_t)b->n * hit_bytes(q));
    result->hits = to->block.bytes;
    return true;
}

static void find_some_normals(void *arg, uint64_t first, uint64_t last)
{
    const shared_rows *rows = arg;
    const tree_query *q = rows->query;
    for (uint64_t i = first; i < last; ++i) {
        const uint32_t *hit = rows->hits + i * q->kind->hit_words;
        float *normal = q->normals + 3 * i;
        memset(normal, 0, 3 * sizeof *normal);
        if (hit[1] != DUET_NO_OBJECT)
            q->normal(q->tree, item_at(q, hit[0]), hit, normal);
    }
}

// No device computes them, so that a query without normals pays nothing.
static bool find_normals(tree_query *q, query_result *result, duet_error *err)
{
    uint64_t n = result->n_hits;
    shared_rows rows = {.query = q, .hits = (uint32_t *)result->hits};
    thread_pool *a = q->sides[0].helpers, *b = q->sides[1].helpers;
    if (!q->normal || n == 0)
        return true;
    if (n > q->most_normals) {
        free(q->normals);
        q->normals = malloc((size_t)n * 3 * sizeof *q->normals);
        q->most_normals = q->normals ? n : 0;
    }
    if (!q->normals)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %llu normals",
                         (unsigned long long)n);
    if (!tree_fetch_objects(q->tree, err))
        return false;
    thread_pool_share(b ? b : a, find_some_normals, &rows, n, PIECE);
    result->normals = q->normals;
    return true;
}

bool tree_query_is_far(const tree_query *q, bool far, duet_error *err)
{
    bool is_far = q->tree->def.origin_edge > 0.0f;
    if (is_far == far)
        return true;
    return far ? error_set(err, DUET_STATUS_BAD_ARGUMENT,
                           "%s with origin cells; the tree's origin_edge is 0", q->kind->items)
               : error_set(err, DUET_STATUS_BAD_ARGUMENT,
                           "%s without origin cells; the tree's origin_edge is %g", q->kind->items,
                           (double)q->tree->def.origin_edge);
}

// The tree's objects count from its middle already.
static bool take_items(tree_query *q, const void *items, uint64_t n, duet_error *err)
{
    size_t bytes = (size_t)n * q->item_words * sizeof(float);
    bool is_far = q->tree->def.origin_edge > 0.0f;
    q->items = items;
    if ((!is_far && !q->kind->copy) || q->itself || n == 0)
        return true;
    void *copies = realloc(q->own_items, bytes);
    if (!copies)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %llu %s",
                         (unsigned long long)n, q->kind->items);
    q->items = q->own_items = copies;
    if (q->kind->copy) {
        q->kind->copy(q->tree, items, n, copies);
        return true;
    }
    const far_rows far = {memcpy(copies, items, bytes), n, q->item_words, q->item_cell};
    far_rows_settle(&far, q->tree->def.origin_edge);
    far_rows_count_from(&far, q->tree->middle);
    return true;
}

bool tree_query_run(tree_query *q, const void *items, uint64_t n, query_result *result,
                    duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    const char *plural = q->kind->items;
    if (n > 0 && !items)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%llu %s, but no memory with them",
                         (unsigned long long)n, plural);
    if (n > UINT32_MAX)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu %s; expected fewer than 2^32",
                         (unsigned long long)n, plural);
    if (!open_sides(q, err) || !take_items(q, items, n, err))
        return false;
    uint64_t cut = n * tree_share_of(q->tree, q->name) / DUET_SHARE_ONE;
    query_side *a = begin_side(q, 0, 0, cut), *b = begin_side(q, 1, cut, n);
    query_result found = {0};
    if (!tree_run(q->tree, run_side, a, b, err) || !join_hits(q, &found, err) ||
        !find_normals(q, &found, err))
        return false;
    for (int which = 0; which < 2; ++which) {
        found.undecided += q->sides[which].undecided;
        found.device_ms[which] = q->sides[which].wall_ms;
    }
    found.total_ms = clock_ms_since(begun);
    *result = found;
    return true;
}

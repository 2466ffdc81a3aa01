// SPDX-License-Identifier: MIT
// A takes the first share of the items and B the rest, at the same time; each has the whole
// tree. What float leaves open the host decides, a chunk of items at a time.
#include "runtime/queries/tree_query.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"

#include <stdlib.h>
#include <string.h>

// Some 30 MB of items: launches cost nothing beside it, and few devices lack it.
enum { CHUNK = 1 << 20, LEAST_LIST = 1 << 14 };

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
                                        {0}};

static const char *const wants_names[] = {"closest", "any", "every"};

enum { N_WANTS = sizeof wants_names / sizeof *wants_names };

const char *duet_query_wants_name(duet_query_wants wants)
{
    return (unsigned)wants < N_WANTS ? wants_names[wants] : NULL;
}

bool tree_query_knows(duet_query_wants wants, duet_error *err)
{
    return duet_query_wants_name(wants) ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT, "wants is %d; expected a duet_query_wants",
                     (int)wants);
}

// ---------------------------------------------------------------- owner

static void close_side(query_side *s)
{
    buffer *const all[] = {&s->items, &s->filters, &s->hits, &s->open, &s->counters};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        buffer_release(all[i]);
    free(s->found.words);
    free(s->open_hits.words);
    *s = (query_side){0};
}

static bool open_side(query_side *s, tree_query *q, tree_side *tree, duet_error *err)
{
    *s = (query_side){.query = q, .tree = tree, .each = q->each};
    s->kernel = program_set_kernel(tree->programs, q->kind->kernel, q->kind->kernel, q->settings,
                                   q->n_settings, side_bindings, err);
    if (s->kernel && program_set_build(tree->programs, err) &&
        buffer_reserve(&s->counters, tree->device, QUERY_COUNTERS * sizeof(cl_uint), err))
        return true;
    close_side(s);
    return false;
}

// Those that the tree has had since the last run, too.
static bool open_sides(tree_query *q, duet_error *err)
{
    bool ok = true;
    for (int which = 0; ok && which < 2; ++which)
        ok = !q->tree->sides[which].device || q->sides[which].kernel ||
             open_side(&q->sides[which], q, &q->tree->sides[which], err);
    return ok;
}

bool tree_query_open(tree_query *q, const query_name *name, const gen_setting *settings,
                     uint32_t n_settings, duet_error *err)
{
    tree_hold(q->tree);
    query_name_write(name, q->name);
    q->settings[0] = (gen_setting){"DIMS", q->tree->def.dims};
    q->settings[1] = (gen_setting){"SHAPE", box_tree_shape(q->tree->def.shape)};
    for (uint32_t i = 0; i < n_settings; ++i)
        q->settings[2 + i] = settings[i];
    q->n_settings = 2 + n_settings;
    return open_sides(q, err);
}

void tree_query_close(tree_query *q)
{
    close_side(&q->sides[0]);
    close_side(&q->sides[1]);
    free(q->joined.words);
    duet_tree_destroy(q->tree);
}

// ---------------------------------------------------------------- hits

static size_t hit_bytes(const tree_query *q)
{
    return q->kind->hit_words * sizeof(uint32_t);
}

static uint32_t *hit_at(const tree_query *q, const hit_list *list, uint64_t i)
{
    return list->words + i * q->kind->hit_words;
}

static bool reserve_hits(const tree_query *q, hit_list *list, uint64_t more, duet_error *err)
{
    uint64_t wanted = list->n + more;
    if (wanted <= list->capacity)
        return true;
    uint64_t capacity = wanted + wanted / 4;
    uint32_t *words = realloc(list->words, (size_t)capacity * hit_bytes(q));
    if (!words)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %llu hits",
                         (unsigned long long)wanted);
    list->words = words;
    list->capacity = capacity;
    return true;
}

static float value_of(const uint32_t *hit)
{
    float value;
    memcpy(&value, &hit[2], sizeof value);
    return value;
}

// By item and id; with a value by item, value and id.
static int compare_pairs(const void *x, const void *y)
{
    const uint32_t *a = x, *b = y;
    if (a[0] != b[0])
        return a[0] < b[0] ? -1 : 1;
    return (a[1] > b[1]) - (a[1] < b[1]);
}

static int compare_hits(const void *x, const void *y)
{
    const uint32_t *a = x, *b = y;
    float of_a = value_of(a), of_b = value_of(b);
    if (a[0] != b[0] || of_a == of_b)
        return compare_pairs(a, b);
    return of_a < of_b ? -1 : 1;
}

typedef int comparison(const void *x, const void *y);

static comparison *comparison_of(const tree_query *q)
{
    return q->kind->hit_words > 2 ? compare_hits : compare_pairs;
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

static bool send_filters(query_side *s)
{
    tree_side *t = s->tree;
    const duet_filter *filters = s->query->filters;
    size_t bytes = s->query->tree->n * sizeof *filters;
    if (!buffer_reserve(&s->filters, t->device, bytes, &t->err))
        return false;
    return filters ? timeline_write(&t->times, "send filters", &s->filters, filters, bytes, &t->err)
                   : timeline_fill(&t->times, "clear", &s->filters, UINT32_MAX, 0,
                                   bytes / sizeof(cl_uint), &t->err);
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
    return s->in_order ||
           box_tree_order(t, &s->tree->times, itself ? &t->objects : &s->items,
                          s->query->item_words, itself ? s->first_item : 0, s->n, &s->tree->err);
}

static uint64_t count_of(const cl_uint *words)
{
    return words[0] | (uint64_t)words[1] << 32;
}

static bool ask_once(query_side *s, cl_uint counters[QUERY_COUNTERS])
{
    tree_side *t = s->tree;
    s->objects = t->boxes.objects;
    s->boxes = t->boxes.boxes;
    s->nodes = t->boxes.nodes;
    s->levels = t->boxes.levels;
    s->order = t->boxes.ids;
    s->n_levels = t->boxes.n_levels;
    s->hits_capacity = hits_in(s, &s->hits);
    s->open_capacity = hits_in(s, &s->open);
    return timeline_fill(&t->times, "clear", &s->counters, 0, 0, QUERY_COUNTERS, &t->err) &&
           timeline_launch(&t->times, s->query->kind->kernel, s->kernel, s->n, s, &t->err) &&
           timeline_read(&t->times, "fetch hits", &s->counters, counters,
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

static void finish_hits(query_side *s, uint64_t begin)
{
    const tree_query *q = s->query;
    if (!q->kind->finish || q->wants == QUERY_ANY)
        return;
    for (uint64_t i = begin; i < s->found.n; ++i) {
        uint32_t *hit = hit_at(q, &s->found, i);
        if (hit[1] != DUET_NO_OBJECT)
            q->kind->finish(q->tree, item_at(q, hit[0]), hit);
    }
}

static bool fetch(query_side *s, const cl_uint counters[QUERY_COUNTERS])
{
    const tree_query *q = s->query;
    uint64_t n = hits_found(s, counters), n_open = count_of(counters + COUNT_OPEN);
    s->open_hits.n = 0;
    if (!reserve_hits(q, &s->found, n + n_open, &s->tree->err) ||
        !reserve_hits(q, &s->open_hits, n_open, &s->tree->err))
        return false;
    uint64_t begin = s->found.n;
    uint32_t *hits = hit_at(q, &s->found, begin);
    if (!read_hits(s, &s->hits, hits, n) || !read_hits(s, &s->open, s->open_hits.words, n_open))
        return false;
    s->found.n += n;
    if ((n_open > 0 || (n > 0 && q->kind->finish_reads)) &&
        !tree_fetch_objects(q->tree, &s->tree->err))
        return false;
    if (n_open > 0) // listed in any order
        qsort(s->open_hits.words, (size_t)n_open, hit_bytes(q), comparison_of(q));
    for (uint64_t i = 0; i < n_open; ++i)
        take_open_hit(s, hits, hit_at(q, &s->open_hits, i));
    finish_hits(s, begin);
    return q->wants != QUERY_EVERY || sort_hits(s, s->found.n - begin);
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

static void run_side(void *arg)
{
    query_side *s = arg;
    tree_side *t = s->tree;
    uint64_t begun = clock_steady_ns();
    uint64_t chunk = s->each > 1 ? CHUNK / s->each + 1 : CHUNK;
    timeline_begin(&t->times, t->device);
    t->ok = !s->query->itself || send_filters(s);
    for (uint64_t first = s->first; t->ok && first < s->last; first += chunk) {
        uint64_t left = s->last - first;
        t->ok =
            budget_check(&t->err) && run_chunk(s, first, (uint32_t)(left < chunk ? left : chunk));
    }
    t->ok = t->ok && timeline_finish(&t->times, &t->err);
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
        result->hits = a->n ? a->words : b->words;
        return true;
    }
    to->n = 0;
    if (!reserve_hits(q, to, result->n_hits, err))
        return false;
    memcpy(to->words, a->words, (size_t)a->n * hit_bytes(q));
    memcpy(hit_at(q, to, a->n), b->words, (size_t)b->n * hit_bytes(q));
    result->hits = to->words;
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
    if (!open_sides(q, err))
        return false;
    uint64_t cut = n * tree_share_of(q->tree, q->name) / DUET_SHARE_ONE;
    q->items = items;
    query_side *a = begin_side(q, 0, 0, cut), *b = begin_side(q, 1, cut, n);
    query_result found = {0};
    if (!tree_run(q->tree, run_side, a, b, err) || !join_hits(q, &found, err))
        return false;
    for (int which = 0; which < 2; ++which) {
        found.undecided += q->sides[which].undecided;
        found.device_ms[which] = q->sides[which].wall_ms;
    }
    found.total_ms = clock_ms_since(begun);
    *result = found;
    return true;
}

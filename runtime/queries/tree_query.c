// SPDX-License-Identifier: MIT
// A takes the first share of the items and B the rest, at the same time; each has the whole tree.
// The host decides hits that float leaves open, a chunk of items at a time.
#include "runtime/queries/tree_query.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/queries/far_rows.h"
#include "runtime/queries/ground_hits.h"
#include "runtime/queries/query_chunk.h"
#include "runtime/queries/query_flow.h"

#include <stdlib.h>
#include <string.h>

// Some 30 MB of items: launches cost nothing beside it, and few devices lack it.
enum { CHUNK = 1 << 20 };

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

// ---------------------------------------------------------------- def

static bool check_def(const duet_tree *tree, const any_query_def *def, duet_error *err)
{
    const query_name *name = &def->name;
    if (!tree)
        return bad_argument(err, "the query's def has no tree");
    if (!duet_query_wants_name(name->wants))
        return bad_argument(err, "wants is %d; expected a duet_query_wants", (int)name->wants);
    if (def->normals && name->wants == DUET_QUERY_ANY)
        return bad_argument(
            err,
            "normals with wants any, which says of no hit where it is; expected closest or every");
    if (!duet_level_get_info(def->level))
        return bad_argument(err, "level is %d; expected a duet_level", (int)def->level);
    return name->nearest <= DUET_MOST_NEAREST ||
           bad_argument(err, "nearest is %u; expected at most %u", name->nearest,
                        DUET_MOST_NEAREST);
}

static query_wants wants_of(const query_name *name)
{
    if (name->item == QUERY_BOXES || (name->item == QUERY_POINTS && name->nearest == 0))
        return QUERY_EVERY;
    return name->item == QUERY_POINTS ? QUERY_NEAREST : (query_wants)name->wants;
}

static void set_def(tree_query *q, const any_query_def *def)
{
    query_name_write(&def->name, q->name);
    q->wants = wants_of(&def->name);
    q->each = q->wants == QUERY_NEAREST ? def->name.nearest : q->wants != QUERY_EVERY;
    q->level = def->level;
    q->itself = def->name.itself;
    q->normal = def->normals ? q->kind->normal : NULL;
    if (def->filter) {
        q->own_filter = *def->filter;
        q->filter = &q->own_filter;
    }
}

static void set_settings(tree_query *q, query_item item)
{
    const duet_tree_def *tree = &q->tree->def;
    const bool boxes = item == QUERY_BOXES, poses = tree->shape == DUET_SHAPE_POSES;
    const gen_setting settings[QUERY_SETTINGS] = {
        {"DIMS", tree->dims},
        {"SHAPE", box_tree_shape(tree->shape)},
        {"ORIGIN", origin_setting(tree->origin_edge)},
        {"FILTERED", q->filter != NULL},
        {boxes ? "ACCURACY" : "WANTS", !boxes  ? (int64_t)q->wants
                                       : poses ? (int64_t)q->level
                                               : DUET_LEVEL_CERTIFIED},
        {boxes ? "ITSELF" : "SWEPT", boxes ? q->itself : 1}};
    memcpy(q->settings, settings, sizeof settings);
    q->n_settings = boxes || item == QUERY_SWEEPS ? QUERY_SETTINGS : QUERY_SETTINGS - 1;
}

// ---------------------------------------------------------------- owner

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

tree_query *tree_query_create(duet_tree *tree, const query_kinds kinds, const any_query_def *def,
                              duet_error *err)
{
    if (!check_def(tree, def, err))
        return NULL;
    tree_query *q = calloc(1, sizeof *q);
    if (!q)
        return null_no_memory(err, "a query");
    q->kind = &kinds[tree->def.origin_edge > 0.0f ? DUET_SHAPES : tree->def.shape];
    q->tree = tree;
    tree_hold(tree);
    set_def(q, def);
    set_settings(q, def->name.item);
    if (open_sides(q, err))
        return q;
    any_query_destroy(q);
    return NULL;
}

void any_query_destroy(any_query *q)
{
    if (!q)
        return;
    any_query_destroy(q->own);
    close_side(&q->sides[0]);
    close_side(&q->sides[1]);
    host_block_release(&q->joined.block);
    free(q->own_items);
    free(q->normals);
    free(q->on_ground);
    host_block_release(&q->with_ground.block);
    duet_tree_destroy(q->tree);
    free(q);
}

// ---------------------------------------------------------------- one device

static bool run_chunks(query_side *s, uint64_t chunk)
{
    bool ok = true;
    for (uint64_t first = s->first; ok && first < s->last; first += chunk) {
        uint64_t left = s->last - first;
        ok = budget_check(&s->tree->err) &&
             query_run_chunk(s, first, (uint32_t)(left < chunk ? left : chunk));
    }
    return ok;
}

static void run_side(void *arg)
{
    query_side *s = arg;
    tree_side *t = s->tree;
    uint64_t begun = clock_steady_ns();
    uint64_t items = query_flows(s) ? query_flow_items(s) : CHUNK;
    uint64_t chunk = s->each > 1 ? items / s->each + 1 : items;
    uint64_t n_hits = (s->last - s->first) * s->each;
    timeline_begin(&t->times, t->device, true);
    t->ok = query_send_filters(s) &&
            hits_reserve(&s->found, s->query->kind->hit_words, t->device, n_hits, &t->err) &&
            (query_flows(s) ? query_run_flows(s, chunk) : run_chunks(s, chunk));
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
    if (!hits_reserve(to, q->kind->hit_words, NULL, result->n_hits, err))
        return false;
    memcpy(to->block.bytes, a->block.bytes, (size_t)a->n * query_hit_size(q));
    memcpy(hits_at(to, q->kind->hit_words, a->n), b->block.bytes, (size_t)b->n * query_hit_size(q));
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
        if (hit[1] == DUET_NO_OBJECT)
            continue;
        query_normal *find = hit[1] == tree_ground_id(q->tree) ? q->kind->ground_normal : q->normal;
        find(q->tree, query_item_at(q, hit[0]), hit, normal);
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
        return no_memory(err, "%llu normals", (unsigned long long)n);
    if (!tree_fetch_objects(q->tree, err))
        return false;
    thread_pool_share(b ? b : a, find_some_normals, &rows, n, QUERY_PIECE);
    result->normals = q->normals;
    return true;
}

bool tree_query_is_far(const tree_query *q, bool far, duet_error *err)
{
    bool is_far = q->tree->def.origin_edge > 0.0f;
    if (is_far == far)
        return true;
    return far ? bad_argument(err, "%s with origin cells; the tree's origin_edge is 0",
                              q->kind->items)
               : bad_argument(err, "%s without origin cells; the tree's origin_edge is %g",
                              q->kind->items, (double)q->tree->def.origin_edge);
}

// The tree's objects count from its middle already.
static bool take_items(tree_query *q, const void *items, uint64_t n, duet_error *err)
{
    size_t bytes = (size_t)n * q->kind->item_words * sizeof(float);
    bool is_far = q->tree->def.origin_edge > 0.0f;
    q->items = items;
    if ((!is_far && !q->kind->copy) || q->itself || n == 0)
        return true;
    void *copies = realloc(q->own_items, bytes);
    if (!copies)
        return no_memory(err, "%llu %s", (unsigned long long)n, q->kind->items);
    q->items = q->own_items = copies;
    if (q->kind->copy) {
        q->kind->copy(q->tree, items, n, copies);
        return true;
    }
    const far_rows far = {memcpy(copies, items, bytes), n, q->kind->item_words, q->kind->item_cell};
    far_rows_settle(&far, q->tree->def.origin_edge);
    far_rows_count_from(&far, q->tree->middle);
    return true;
}

bool any_query_run(any_query *q, const void *items, uint64_t n, query_result *result,
                   duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    const char *plural = q->kind->items;
    if (n > 0 && !items)
        return bad_argument(err, "%llu %s, but no memory with them", (unsigned long long)n, plural);
    if (n > UINT32_MAX)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu %s; expected fewer than 2^32",
                         (unsigned long long)n, plural);
    if (!open_sides(q, err) || !take_items(q, items, n, err))
        return false;
    uint64_t cut = n * tree_share_of(q->tree, q->name) / DUET_SHARE_ONE;
    query_side *a = begin_side(q, 0, 0, cut), *b = begin_side(q, 1, cut, n);
    query_result found = {0};
    if (!tree_run(q->tree, run_side, a, b, err) || !join_hits(q, &found, err) ||
        !ground_hits_add(q, n, &found, err) || !find_normals(q, &found, err))
        return false;
    for (int which = 0; which < 2; ++which) {
        found.undecided += q->sides[which].undecided;
        found.device_ms[which] = q->sides[which].wall_ms;
    }
    found.total_ms = clock_ms_since(begun);
    *result = found;
    return true;
}

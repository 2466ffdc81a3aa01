// SPDX-License-Identifier: MIT
// Rays against boxes, on both devices.
//
// A takes the first share of the rays and B the rest, at the same time; each has the whole
// tree. What float leaves open the host decides, a chunk of rays at a time.
#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/opencl/device_pair.h"
#include "runtime/opencl/thread_pool.h"
#include "runtime/queries/box_tree.h"
#include "runtime/queries/ray.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e700a };

// Some 30 MB of rays: launches cost nothing beside it, and few devices lack it.
enum { CHUNK = 1 << 20, LEAST_LIST = 1 << 14 };

// Fewer rays are cast sooner than sorted.
enum { LEAST_SORTED = 1 << 13 };

// Hits on the host; it grows.
typedef struct hit_list {
    duet_ray_hit *hits;
    uint64_t n, capacity;
} hit_list;

// One device, and what it does of a call.
typedef struct side {
    const device *device;
    gen *gen;
    program_set *programs;
    kernel *kernel;
    box_tree tree;
    timeline times;
    buffer rays, hits, open, counters;
    cl_uint n, first_ray, hits_capacity, open_capacity; // of the chunk that was launched last
    cl_uint n_levels;
    cl_uint in_order;
    buffer boxes, nodes, levels, order; // the tree's

    duet_ray_wants wants;
    uint32_t dims;
    const duet_ray *all_rays;
    const duet_pose *poses; // the query's copy
    uint32_t n_poses;
    uint64_t first, last;
    hit_list found;
    duet_ray_hit *open_hits; // [n_open_hits]
    uint64_t n_open_hits;
    uint64_t undecided;
    double wall_ms;
    bool ok;
    duet_error err;
} side;

static const binding side_bindings[] = {BIND_BUFFER(side, "rays", "float *", rays),
                                        BIND_BUFFER(side, "boxes", "float *", boxes),
                                        BIND_BUFFER(side, "nodes", "float *", nodes),
                                        BIND_BUFFER(side, "levels", "uint *", levels),
                                        BIND_BUFFER(side, "hits", "uint *", hits),
                                        BIND_BUFFER(side, "open", "uint *", open),
                                        BIND_BUFFER(side, "counters", "uint *", counters),
                                        BIND_BUFFER(side, "order", "uint *", order),
                                        BIND_VALUE(side, "in_order", in_order),
                                        BIND_VALUE(side, "n", n),
                                        BIND_VALUE(side, "first_ray", first_ray),
                                        BIND_VALUE(side, "n_levels", n_levels),
                                        BIND_VALUE(side, "hits_capacity", hits_capacity),
                                        BIND_VALUE(side, "open_capacity", open_capacity),
                                        {0}};

struct duet_ray_query {
    duet_ray_query_def def;
    side sides[2];       // A, B
    thread_pool *driver; // drives A while the caller's thread drives B
    duet_pose *poses;    // [n_poses] for what float leaves open
    uint32_t n_poses;
    hit_list joined;
};

static const char *const wants_names[] = {"closest", "any", "every"};

enum { N_WANTS = sizeof wants_names / sizeof *wants_names };

const char *duet_ray_wants_name(duet_ray_wants wants)
{
    return (unsigned)wants < N_WANTS ? wants_names[wants] : NULL;
}

duet_ray_query_def duet_default_ray_query_def(void)
{
    return (duet_ray_query_def){.share = DUET_SHARE_DEFAULT, .dims = 3, .cookie = COOKIE};
}

// ---------------------------------------------------------------- owner

static bool check_def(const duet_ray_query_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "the query's def does not come from duet_default_ray_query_def");
    if (!def->pair)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "the query's def has no device pair");
    if (def->dims != 2 && def->dims != 3)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "dims is %u; expected 2 or 3", def->dims);
    if (!duet_ray_wants_name(def->wants))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "wants is %d; expected a duet_ray_wants",
                         (int)def->wants);
    if (def->share > DUET_SHARE_ONE && def->share != DUET_SHARE_DEFAULT)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "share is %u of %u; expected at most all of it", def->share,
                         DUET_SHARE_ONE);
    return true;
}

static void close_side(side *s)
{
    timeline_clear(&s->times);
    box_tree_close(&s->tree);
    buffer_release(&s->rays);
    buffer_release(&s->hits);
    buffer_release(&s->open);
    buffer_release(&s->counters);
    program_set_close(s->programs);
    gen_close(s->gen);
    free(s->found.hits);
    free(s->open_hits);
    *s = (side){0};
}

static bool open_side(side *s, const duet_ray_query_def *def, int which, duet_error *err)
{
    *s = (side){.device = &def->pair->devices[which], .dims = def->dims, .wants = def->wants};
    const gen_setting settings[] = {{"DIMS", def->dims}, {"WANTS", def->wants}};
    s->gen = gen_open(def->pair->kernel_dir, err);
    s->programs = s->gen ? program_set_open(s->device, s->gen, &def->pair->builder, err) : NULL;
    if (s->programs)
        s->kernel = program_set_kernel(s->programs, "ray_query", "ray_query", settings, 2,
                                       side_bindings, err);
    return s->kernel && box_tree_open(&s->tree, s->device, s->programs, def->dims, err) &&
           program_set_build(s->programs, err) &&
           buffer_reserve(&s->counters, s->device, QUERY_COUNTERS * sizeof(cl_uint), err);
}

duet_ray_query *duet_ray_query_create(const duet_ray_query_def *def, duet_error *err)
{
    if (!check_def(def, err))
        return NULL;
    duet_ray_query *query = calloc(1, sizeof *query);
    if (!query) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a query");
        return NULL;
    }
    query->def = *def;
    if (def->share == DUET_SHARE_DEFAULT)
        query->def.share = duet_default_plan(def->pair).share;
    device_pair_hold(def->pair);
    const bool used[2] = {query->def.share > 0, query->def.share < DUET_SHARE_ONE};
    bool ok = true;
    for (int which = 0; which < 2; ++which)
        ok = ok && (!used[which] || open_side(&query->sides[which], def, which, err));
    if (ok && used[0] && used[1])
        ok = (query->driver = thread_pool_open(1, err)) != NULL;
    if (!ok) {
        duet_ray_query_destroy(query);
        return NULL;
    }
    return query;
}

void duet_ray_query_destroy(duet_ray_query *query)
{
    if (!query)
        return;
    thread_pool_close(query->driver);
    close_side(&query->sides[0]);
    close_side(&query->sides[1]);
    duet_device_pair_destroy(query->def.pair);
    free(query->poses);
    free(query->joined.hits);
    free(query);
}

// ---------------------------------------------------------------- both sides

// Runs the work of those sides that take part, at the same time. The first failure counts:
// A's, if it has one.
static bool run_sides(duet_ray_query *query, void (*work)(void *), const bool takes_part[2],
                      duet_error *err)
{
    side *a = &query->sides[0], *b = &query->sides[1];
    for (int which = 0; which < 2; ++which) {
        query->sides[which].ok = true;
        query->sides[which].err = (duet_error){0};
        query->sides[which].wall_ms = 0;
    }
    thread_pool_run_both(query->driver, work, takes_part[0] ? a : NULL, takes_part[1] ? b : NULL);
    const side *failed = a->ok ? b : a;
    if (!failed->ok && err && err->status == DUET_STATUS_OK)
        *err = failed->err;
    return failed->ok;
}

// ---------------------------------------------------------------- objects

static void build_tree(void *arg)
{
    side *s = arg;
    timeline_begin(&s->times, s->device);
    s->ok = box_tree_build(&s->tree, &s->times, s->poses, s->n_poses, s->dims, &s->err) &&
            timeline_finish(&s->times, &s->err);
    timeline_clear(&s->times);
}

static bool copy_poses(duet_ray_query *query, const duet_pose *poses, uint32_t n, duet_error *err)
{
    duet_pose *copy = realloc(query->poses, ((size_t)n + 1) * sizeof *copy);
    if (!copy)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %u boxes", n);
    query->poses = copy;
    query->n_poses = n;
    if (n > 0)
        memcpy(copy, poses, n * sizeof *copy);
    return true;
}

bool duet_ray_query_set_objects(duet_ray_query *query, const duet_pose *poses, uint32_t n,
                                duet_error *err)
{
    if (!error_given(query, __func__, "query", err))
        return false;
    if (n > 0 && !poses)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%u boxes, but no poses", n);
    query->n_poses = 0;
    bool ok = copy_poses(query, poses, n, err);
    const bool takes_part[2] = {query->sides[0].device, query->sides[1].device};
    for (int which = 0; which < 2; ++which) {
        query->sides[which].poses = query->poses;
        query->sides[which].n_poses = query->n_poses;
    }
    ok = ok && run_sides(query, build_tree, takes_part, err);
    if (!ok)
        query->n_poses = 0;
    return ok;
}

// ---------------------------------------------------------------- a chunk of rays

static bool reserve_hits(hit_list *list, uint64_t more, duet_error *err)
{
    uint64_t wanted = list->n + more;
    if (wanted <= list->capacity)
        return true;
    uint64_t capacity = wanted + wanted / 4;
    duet_ray_hit *hits = realloc(list->hits, (size_t)capacity * sizeof *hits);
    if (!hits)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %llu hits",
                         (unsigned long long)wanted);
    list->hits = hits;
    list->capacity = capacity;
    return true;
}

static cl_uint hits_in(const buffer *b)
{
    size_t n = b->bytes / sizeof(duet_ray_hit);
    return n > UINT32_MAX ? UINT32_MAX : (cl_uint)n;
}

static bool reserve_list(side *s, buffer *b, uint64_t hits)
{
    hits = hits < LEAST_LIST ? LEAST_LIST : hits;
    return buffer_reserve(b, s->device, (size_t)hits * sizeof(duet_ray_hit), &s->err);
}

static bool send_rays(side *s, const duet_ray *rays, size_t bytes)
{
    return buffer_hold(&s->rays, s->device, (void *)rays, bytes, &s->err) &&
           timeline_write(&s->times, "send rays", &s->rays, rays, bytes, &s->err);
}

static bool order_rays(side *s)
{
    s->in_order = s->n < LEAST_SORTED;
    return s->in_order || box_tree_order_rays(&s->tree, &s->times, &s->rays, s->n, &s->err);
}

static uint64_t count_of(const cl_uint *words)
{
    return words[0] | (uint64_t)words[1] << 32;
}

static bool cast_once(side *s, cl_uint counters[QUERY_COUNTERS])
{
    s->boxes = s->tree.boxes;
    s->nodes = s->tree.nodes;
    s->levels = s->tree.levels;
    s->order = s->tree.ids;
    s->n_levels = s->tree.n_levels;
    s->hits_capacity = hits_in(&s->hits);
    s->open_capacity = hits_in(&s->open);
    return timeline_fill(&s->times, "clear", &s->counters, 0, 0, QUERY_COUNTERS, &s->err) &&
           timeline_launch(&s->times, "rays", s->kernel, s->n, s, &s->err) &&
           timeline_read(&s->times, "fetch hits", &s->counters, counters,
                         QUERY_COUNTERS * sizeof *counters, &s->err);
}

// Lists that are too short are made longer, and the chunk is cast again.
static bool cast(side *s, cl_uint counters[QUERY_COUNTERS])
{
    bool every = s->wants == DUET_RAY_EVERY;
    bool ok = reserve_list(s, &s->open, 0) && reserve_list(s, &s->hits, s->n);
    while (ok) {
        ok = cast_once(s, counters);
        uint64_t hits = every ? count_of(counters + COUNT_HITS) : s->n;
        uint64_t open = count_of(counters + COUNT_OPEN);
        if (!ok || (hits <= s->hits_capacity && open <= s->open_capacity))
            return ok;
        if (hits > UINT32_MAX || open > UINT32_MAX)
            return error_set(&s->err, DUET_STATUS_TOO_MANY,
                             "rays %llu and on meet %llu boxes, more than can be listed at once",
                             (unsigned long long)s->first_ray, (unsigned long long)(hits + open));
        ok = reserve_list(s, &s->hits, hits) && reserve_list(s, &s->open, open);
    }
    return false;
}

static bool is_before(const duet_ray_hit *a, const duet_ray_hit *b)
{
    if (a->ray != b->ray)
        return a->ray < b->ray;
    return a->t != b->t ? a->t < b->t : a->id < b->id;
}

static int compare_hits(const void *x, const void *y)
{
    const duet_ray_hit *a = x, *b = y;
    return is_before(b, a) - is_before(a, b);
}

// By ray first, which is a place, then the few hits of each ray.
static bool sort_hits(side *s, duet_ray_hit *hits, uint64_t n)
{
    uint64_t *end = calloc((size_t)s->n + 1, sizeof *end);
    duet_ray_hit *by_ray = malloc((size_t)(n + 1) * sizeof *by_ray);
    bool ok = end && by_ray;
    for (uint64_t i = 0; ok && i < n; ++i)
        ++end[hits[i].ray - s->first_ray + 1];
    for (cl_uint ray = 0; ok && ray < s->n; ++ray)
        end[ray + 1] += end[ray];
    for (uint64_t i = 0; ok && i < n; ++i)
        by_ray[end[hits[i].ray - s->first_ray]++] = hits[i];
    for (cl_uint ray = 0; ok && ray < s->n; ++ray) {
        uint64_t first = ray > 0 ? end[ray - 1] : 0;
        if (end[ray] - first > 1)
            qsort(by_ray + first, (size_t)(end[ray] - first), sizeof *hits, compare_hits);
    }
    if (ok && n > 0)
        memcpy(hits, by_ray, (size_t)n * sizeof *hits);
    free(end);
    free(by_ray);
    return ok || error_set(&s->err, DUET_STATUS_NO_MEMORY, "no host memory to sort %llu hits",
                           (unsigned long long)n);
}

// `hits` are those of the chunk that the list ends with.
static void take_open_hit(side *s, duet_ray_hit *hits, const duet_ray_hit *open)
{
    bool every = s->wants == DUET_RAY_EVERY;
    duet_ray_hit *known = every ? NULL : &hits[open->ray - s->first_ray];
    bool has_hit = known && known->id != DUET_NO_OBJECT;
    if (has_hit && (s->wants == DUET_RAY_ANY || !is_before(open, known)))
        return;
    ++s->undecided;
    if (!ray_meets(&s->all_rays[open->ray], &s->poses[open->id], s->dims))
        return;
    if (every)
        s->found.hits[s->found.n++] = *open; // reserved
    else
        *known = s->wants == DUET_RAY_ANY ? (duet_ray_hit){open->ray, 0, 0} : *open;
}

static bool fetch_open(side *s, uint64_t n)
{
    if (n > s->n_open_hits) {
        free(s->open_hits);
        s->n_open_hits = 0;
        s->open_hits = malloc((size_t)n * sizeof *s->open_hits);
        if (!s->open_hits)
            return error_set(&s->err, DUET_STATUS_NO_MEMORY, "no host memory for %llu hits",
                             (unsigned long long)n);
        s->n_open_hits = n;
    }
    return n == 0 || timeline_read(&s->times, "fetch hits", &s->open, s->open_hits,
                                   (size_t)n * sizeof *s->open_hits, &s->err);
}

static bool fetch(side *s, const cl_uint counters[QUERY_COUNTERS])
{
    bool every = s->wants == DUET_RAY_EVERY;
    uint64_t n = every ? count_of(counters + COUNT_HITS) : s->n;
    uint64_t n_open = count_of(counters + COUNT_OPEN);
    if (!reserve_hits(&s->found, n + n_open, &s->err) || !fetch_open(s, n_open))
        return false;
    uint64_t begin = s->found.n;
    duet_ray_hit *hits = s->found.hits + begin;
    if (n > 0 &&
        !timeline_read(&s->times, "fetch hits", &s->hits, hits, (size_t)n * sizeof *hits, &s->err))
        return false;
    s->found.n += n;
    if (n_open > 0) // listed in any order
        qsort(s->open_hits, (size_t)n_open, sizeof *hits, compare_hits);
    for (uint64_t i = 0; i < n_open; ++i)
        take_open_hit(s, hits, &s->open_hits[i]);
    return !every || sort_hits(s, hits, s->found.n - begin);
}

static bool refuse_ray(side *s, const cl_uint counters[QUERY_COUNTERS])
{
    return error_set(&s->err, DUET_STATUS_BAD_OBJECT,
                     "ray %llu: not a number, an origin or direction above 2^100, a direction "
                     "below 2^-100, or a t_max below 0",
                     (unsigned long long)s->first_ray + ~counters[BAD_LATEST]);
}

static bool cast_chunk(side *s, uint64_t first, uint32_t n)
{
    cl_uint counters[QUERY_COUNTERS];
    s->n = n;
    s->first_ray = (cl_uint)first;
    return send_rays(s, s->all_rays + first, n * sizeof *s->all_rays) && order_rays(s) &&
           cast(s, counters) && (counters[BAD_LATEST] == 0 || refuse_ray(s, counters)) &&
           fetch(s, counters);
}

// Without boxes no ray meets any, and there is no tree to walk; rays are looked at all the
// same.
static bool meet_nothing(side *s)
{
    bool every = s->wants == DUET_RAY_EVERY;
    if (!every && !reserve_hits(&s->found, s->last - s->first, &s->err))
        return false;
    for (uint64_t i = s->first; i < s->last; ++i) {
        s->first_ray = (cl_uint)i;
        if (!ray_is_valid(&s->all_rays[i], s->dims))
            return refuse_ray(s, (const cl_uint[QUERY_COUNTERS]){[BAD_LATEST] = ~0u});
        if (!every)
            s->found.hits[s->found.n++] = (duet_ray_hit){(uint32_t)i, DUET_NO_OBJECT,
                                                         s->wants == DUET_RAY_ANY ? 0 : INFINITY};
    }
    return true;
}

static void cast_all(void *arg)
{
    side *s = arg;
    uint64_t begun = clock_steady_ns();
    timeline_begin(&s->times, s->device);
    if (s->n_poses == 0)
        s->ok = meet_nothing(s);
    for (uint64_t first = s->first; s->ok && s->n_poses > 0 && first < s->last; first += CHUNK) {
        uint64_t left = s->last - first;
        s->ok =
            budget_check(&s->err) && cast_chunk(s, first, left < CHUNK ? (uint32_t)left : CHUNK);
    }
    s->ok = s->ok && timeline_finish(&s->times, &s->err);
    timeline_clear(&s->times);
    if (s->rays.borrowed) // the caller may free it
        buffer_release(&s->rays);
    s->wall_ms = clock_ms_since(begun);
}

// ---------------------------------------------------------------- all rays

static void begin_side(duet_ray_query *query, int which, const duet_ray *rays, uint64_t first,
                       uint64_t last)
{
    side *s = &query->sides[which];
    s->all_rays = rays;
    s->first = first;
    s->last = last;
    s->poses = query->poses;
    s->n_poses = query->n_poses;
    s->found.n = 0;
    s->undecided = 0;
}

// A's rays are the first ones.
static bool join_hits(duet_ray_query *query, duet_ray_query_result *result, duet_error *err)
{
    hit_list *a = &query->sides[0].found, *b = &query->sides[1].found, *to = &query->joined;
    result->n_hits = a->n + b->n;
    if (a->n == 0 || b->n == 0) {
        result->hits = a->n ? a->hits : b->hits;
        return true;
    }
    to->n = 0;
    if (!reserve_hits(to, result->n_hits, err))
        return false;
    memcpy(to->hits, a->hits, (size_t)a->n * sizeof *a->hits);
    memcpy(to->hits + a->n, b->hits, (size_t)b->n * sizeof *b->hits);
    result->hits = to->hits;
    return true;
}

bool duet_ray_query_run(duet_ray_query *query, const duet_ray *rays, uint64_t n,
                        duet_ray_query_result *result, duet_error *err)
{
    if (!error_given(query, __func__, "query", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    uint64_t begun = clock_steady_ns();
    if (n > 0 && !rays)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "%llu rays, but no memory with them",
                         (unsigned long long)n);
    if (n > UINT32_MAX)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu rays; expected fewer than 2^32",
                         (unsigned long long)n);
    uint64_t cut = n * query->def.share / DUET_SHARE_ONE;
    begin_side(query, 0, rays, 0, cut);
    begin_side(query, 1, rays, cut, n);
    const bool takes_part[2] = {cut > 0, cut < n};
    duet_ray_query_result found = {0};
    if (!run_sides(query, cast_all, takes_part, err) || !join_hits(query, &found, err))
        return false;
    const side *a = &query->sides[0], *b = &query->sides[1];
    found.undecided = a->undecided + b->undecided;
    found.total_ms = clock_ms_since(begun);
    found.device_ms[0] = a->wall_ms;
    found.device_ms[1] = b->wall_ms;
    *result = found;
    return true;
}

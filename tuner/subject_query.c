// SPDX-License-Identifier: MIT
// A query of a scene's objects as a subject: of a plan only the share counts.
#include "tuner/subject.h"

#include "base/error.h"
#include "base/rng.h"
#include "runtime/narrowphase/origin.h"
#include "runtime/queries/any_query.h"
#include "runtime/queries/far_rows.h"
#include "runtime/scene/scene.h"
#include "tuner/tuning.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct query {
    duet_tree *tree; // holds the scene's objects
    query_name name;
    void *items; // drawn among the objects
    uint64_t n;
    any_query *query;
} query;

// ---------------------------------------------------------------- def

// Each device has the whole tree and one way to walk down it.
static const duet_mode modes[] = {DUET_MODE_OWN};
static const char *const variants[] = {"auto"};

static bool is_asked(const duet_tune_def *def)
{
    return def->query;
}

static bool check(const duet_tune_def *def, duet_error *err)
{
    query_name name;
    if (def->steps)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "steps of a motion have no query; expected none");
    if (def->search || def->n_variants > 0 || def->n_modes > 0 || def->n_levels > 0 ||
        def->has_accuracy)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "a query has a share alone to be tuned; expected no %s with it",
                         def->search           ? "search"
                         : def->n_variants > 0 ? "variants"
                         : def->n_modes > 0    ? "modes"
                                               : "level or accuracy");
    return query_name_read(def->query, &name, err);
}

static void complete(duet_tune_def *def)
{
    def->variants = variants;
    def->n_variants = sizeof variants / sizeof *variants;
    def->modes = modes;
    def->n_modes = sizeof modes / sizeof *modes;
}

// ---------------------------------------------------------------- items

// Draws items in the objects' extent.
typedef struct draw {
    rng random;
    uint32_t dims;
    const char *objects;
    duet_shape shape;
    float edge;   // the edge of origin cells, or 0
    size_t width; // bytes of an object
    uint32_t n_objects;
    double lower[3], upper[3];
} draw;

// All but bounds begin with their centre.
static double middle_of(const draw *d, uint32_t i, uint32_t k)
{
    const float *row = (const float *)(d->objects + i * d->width);
    double corner[3];
    origin_corner(corner, d->objects, d->edge, i);
    return d->shape == DUET_SHAPE_BOUNDS ? 0.5 * row[k] + 0.5 * row[3 + k] : corner[k] + row[k];
}

static void measure_extent(draw *d)
{
    for (int k = 0; k < 3; ++k) {
        d->lower[k] = INFINITY;
        d->upper[k] = -INFINITY;
    }
    for (uint32_t i = 0; i < d->n_objects; ++i)
        for (uint32_t k = 0; k < d->dims; ++k) {
            double at = middle_of(d, i, k);
            d->lower[k] = fmin(d->lower[k], at);
            d->upper[k] = fmax(d->upper[k], at);
        }
}

// cell is written in origin cells only.
static void draw_point(draw *d, float at[3], int32_t cell[3])
{
    duet_large_pose large = {0};
    double place[3];
    for (uint32_t k = 0; k < 3; ++k) {
        place[k] = k < d->dims ? rng_between(&d->random, d->lower[k], d->upper[k]) : 0;
        at[k] = (float)place[k];
    }
    if (d->edge == 0)
        return;
    origin_place(&large, place, d->edge);
    memcpy(at, large.pose.centre, sizeof large.pose.centre);
    memcpy(cell, large.cell, sizeof large.cell);
}

// Draws a direction of length 1.
static void draw_direction(draw *d, float direction[3])
{
    double v[3] = {0}, length = 0;
    for (uint32_t k = 0; k < d->dims; ++k) {
        v[k] = rng_normal(&d->random);
        length += v[k] * v[k];
    }
    for (int k = 0; k < 3; ++k)
        direction[k] = (float)(v[k] / sqrt(length));
}

// An item that lists all it meets goes an eighth of the way through.
static float draw_end(const draw *d, duet_query_wants wants)
{
    double widest = 0;
    for (uint32_t k = 0; k < d->dims; ++k)
        widest = fmax(widest, d->upper[k] - d->lower[k]);
    return wants == DUET_QUERY_EVERY ? (float)(widest / 8) : INFINITY;
}

static void draw_ray(draw *d, const query_name *name, void *item)
{
    duet_large_ray *large = item; // its first part is a ray
    draw_point(d, large->ray.origin, large->cell);
    draw_direction(d, large->ray.direction);
    large->ray.t_max = draw_end(d, name->wants);
}

static void draw_at(draw *d, const query_name *name, void *item)
{
    (void)name;
    duet_large_point *large = item;
    draw_point(d, large->point.at, large->cell);
}

// One of the objects, elsewhere.
static void draw_box(draw *d, const query_name *name, void *item)
{
    float at[3];
    int32_t cell[3];
    uint32_t i = rng_below(&d->random, d->n_objects);
    float *row = item;
    (void)name;
    draw_point(d, at, cell);
    memcpy(row, d->objects + i * d->width, d->width);
    if (d->edge > 0)
        memcpy(row + FAR_POSE_CELL, cell, sizeof cell);
    for (uint32_t k = 0; k < d->dims; ++k) {
        if (d->shape == DUET_SHAPE_BOUNDS)
            row[3 + k] = at[k] + (row[3 + k] - row[k]);
        row[k] = at[k];
    }
}

static void draw_sweep(draw *d, const query_name *name, void *item)
{
    float *way =
        d->edge > 0 ? ((duet_large_sweep *)item)->direction : (float *)((char *)item + d->width);
    draw_box(d, name, item);
    draw_direction(d, way);
    way[3] = draw_end(d, name->wants);
}

static size_t item_bytes(const draw *d, query_item item)
{
    switch (item) {
    case QUERY_RAYS:
        return d->edge > 0 ? sizeof(duet_large_ray) : sizeof(duet_ray);
    case QUERY_SWEEPS:
        return d->edge > 0 ? sizeof(duet_large_sweep) : d->width + 4 * sizeof(float);
    case QUERY_BOXES:
        return d->width;
    case QUERY_POINTS:
        return d->edge > 0 ? sizeof(duet_large_point) : sizeof(duet_point);
    }
    return 0;
}

static bool draw_items(query *q, draw *d, duet_error *err)
{
    static void (*const draws[])(draw *, const query_name *, void *) = {
        [QUERY_RAYS] = draw_ray,
        [QUERY_SWEEPS] = draw_sweep,
        [QUERY_BOXES] = draw_box,
        [QUERY_POINTS] = draw_at,
    };
    size_t bytes = item_bytes(d, q->name.item);
    if (q->name.itself)
        return true;
    measure_extent(d);
    q->items = calloc(q->n, bytes);
    for (uint64_t i = 0; q->items && i < q->n; ++i)
        draws[q->name.item](d, &q->name, (char *)q->items + i * bytes);
    return q->items || error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %llu items",
                                 (unsigned long long)q->n);
}

// ---------------------------------------------------------------- owner

static bool open_tree(query *q, duet_device_pair *pair, const duet_scene_info *info,
                      const void *objects, duet_error *err)
{
    duet_tree_def def = duet_default_tree_def();
    def.pair = pair;
    def.dims = info->dims;
    def.shape = info->shape;
    def.origin_edge = info->origin_edge;
    q->tree = duet_tree_create(&def, err);
    return q->tree && duet_tree_set_objects(q->tree, scene_kind(info), objects, info->n, err);
}

static bool open_query(query *q, duet_device_pair *pair, const duet_scene *scene, uint64_t seed,
                       duet_error *err)
{
    const duet_scene_info *info = duet_scene_get_info(scene);
    const void *objects = duet_scene_get_objects(scene, scene_kind(info));
    draw d = {.random = rng_seed(seed),
              .dims = info->dims,
              .objects = objects,
              .shape = info->shape,
              .edge = info->origin_edge,
              .width = origin_row_bytes(info->shape, info->origin_edge),
              .n_objects = info->n};
    if (q->n == 0 || q->n > UINT32_MAX || info->n == 0)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "%llu items of a query of %u objects; expected 1 or more of both, and "
                         "fewer than 2^32",
                         (unsigned long long)q->n, info->n);
    if (!open_tree(q, pair, info, objects, err) || !draw_items(q, &d, err))
        return false;
    q->query = any_query_create(q->tree, &(any_query_def){.name = q->name}, err);
    return q->query;
}

static bool open(subject *s, duet_error *err)
{
    const duet_scene_info *info = duet_scene_get_info(s->def->scene);
    query *q = s->state = calloc(1, sizeof *q);
    if (!q)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a query");
    if (!query_name_read(s->def->query, &q->name, err))
        return false;
    q->n = s->def->items && !q->name.itself ? s->def->items : info->n;
    s->units = q->n;
    s->plan = (duet_plan){.mode = modes[0]};
    plan_set_variants(&s->plan, variants[0]);
    return open_query(q, s->pair, s->def->scene, s->def->seed, err);
}

static void close(subject *s)
{
    query *q = s->state;
    if (!q)
        return;
    any_query_destroy(q->query);
    duet_tree_destroy(q->tree);
    free(q->items);
    free(q);
}

static bool describe(subject *s, profile_subject *p, duet_error *err)
{
    const query *q = s->state;
    return profile_subject_read_query(q->tree, &q->name, q->n, p, err);
}

// ---------------------------------------------------------------- launches

static bool ask(query *q, uint32_t share, query_result *found, duet_error *err)
{
    return duet_tree_set_share(q->tree, share, err) &&
           (q->name.itself ? any_query_run_itself(q->query, NULL, 0, found, err)
                           : any_query_run(q->query, q->items, q->n, found, err));
}

// They come in order.
static uint64_t hash_of(const query *q, const query_result *found)
{
    uint64_t hash = found->n_hits;
    size_t words = found->n_hits * query_hit_bytes(q->name.item) / sizeof *found->hits;
    for (size_t i = 0; i < words; ++i)
        hash = (hash ^ found->hits[i]) * 0x9E3779B97F4A7C15u;
    return hash;
}

// A query has no stages.
static bool launch_query(void *context, const duet_plan *plan, bool staged, measure_launch *launch,
                         duet_error *err)
{
    subject *s = context;
    query_result found;
    (void)staged;
    core_watch_start(s->cores);
    if (!ask(s->state, plan->share, &found, err))
        return false;
    core_use use = core_watch_stop(s->cores);
    *launch = (measure_launch){.total_ns = measure_to_ns(found.total_ms),
                               .a_ns = measure_to_ns(found.device_ms[0]),
                               .b_ns = measure_to_ns(found.device_ms[1]),
                               .hash = hash_of(s->state, &found),
                               .use = use};
    return true;
}

// By device B alone: hits are the same at every share, which each launch is checked for.
static bool find_truth(subject *s, subject_truth *truth, duet_error *err)
{
    query_result found;
    if (!ask(s->state, 0, &found, err))
        return false;
    truth->hash = hash_of(s->state, &found);
    truth->pairs = found.n_hits;
    return true;
}

const subject_kind subject_query = {
    .is_asked = is_asked,
    .check = check,
    .complete = complete,
    .open = open,
    .close = close,
    .describe = describe,
    .find_truth = find_truth,
    .launch = launch_query,
};

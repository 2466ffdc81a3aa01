// SPDX-License-Identifier: MIT
// Workers without devices: their objects lie in plain memory, and plans and profiles, which are of
// devices, change nothing. One finds pairs by the plain C reference: slow, without OpenCL, and
// never wrong. A simulation's takes the time of a step of a still world, and finds nothing.
#include "base/error.h"
#include "cluster/objects.h"
#include "cluster/ranks.h"
#include "cluster/worker.h"
#include "runtime/broadphase/world.h"
#include "runtime/scene/reference.h"

#include <stdlib.h>

enum { EACH_WITH_EACH_LIMIT = 2000 };

typedef struct plain_worker {
    worker base;
    object_form form;
    duet_level level;
    duet_plan plan; // which changes nothing
    void *objects;
    uint32_t n;
    uint64_t capacity;            // objects for which there is memory
    const simulation *simulation; // NULL: the reference finds pairs
    reference_found found;
} plain_worker;

// Cannot fail for as many objects as there were.
static void *map(worker *w, uint32_t n, duet_error *err)
{
    plain_worker *p = (plain_worker *)w;
    if (!p->objects || n > p->capacity) {
        uint64_t most = (uint64_t)n + n / 16;
        void *objects = realloc(p->objects, (most + 1) * p->form.bytes);
        if (!objects)
            return null_no_memory(err, "%u objects", n);
        p->objects = objects;
        p->capacity = most;
    }
    p->n = n;
    return p->objects;
}

static void begin(worker *w, uint32_t n)
{
    (void)w, (void)n;
}

static void *extend(worker *w, uint32_t n, uint32_t kept, duet_error *err)
{
    (void)kept;
    return map(w, n, err);
}

static bool find_nothing(worker *w, const float inside_lower[3], const float inside_upper[3])
{
    (void)w, (void)inside_lower, (void)inside_upper;
    return false;
}

static uint32_t await_nothing(worker *w, uint32_t from, const interior_block **blocks)
{
    (void)w, (void)blocks;
    return from;
}

// Any order is as good as another.
static bool order(worker *w, uint32_t n_threads, uint32_t *order_of, void *scratch, duet_error *err)
{
    (void)n_threads, (void)scratch, (void)err;
    for (uint32_t i = 0; i < ((plain_worker *)w)->n; ++i)
        order_of[i] = i;
    return true;
}

static bool use_grid(worker *w, uint32_t domain, duet_error *err)
{
    (void)w, (void)domain, (void)err;
    return true;
}

static void forget_grids(worker *w)
{
    (void)w;
}

// None was counted.
static bool bring(worker *w, worker_found *found, duet_error *err)
{
    (void)w, (void)found, (void)err;
    return true;
}

static duet_plan get_plan(const worker *w)
{
    return ((const plain_worker *)w)->plan;
}

static bool set_level(worker *w, duet_level level, duet_error *err)
{
    (void)err;
    ((plain_worker *)w)->level = level;
    return true;
}

static bool set_plan(worker *w, const duet_plan *plan, duet_error *err)
{
    (void)err;
    ((plain_worker *)w)->plan = *plan;
    return true;
}

static bool load_profile(worker *w, const char *path, duet_profile *profile, duet_error *err)
{
    (void)w, (void)path, (void)err;
    *profile = (duet_profile){.grade = DUET_GRADE_DEFAULT};
    return true;
}

static bool find(worker *w, const global_ids *ids, worker_found *found, duet_error *err)
{
    plain_worker *p = (plain_worker *)w;
    (void)ids;
    reference_objects objects = {
        .dims = p->form.dims,
        .shape = p->form.shape,
        .n = p->n,
        .poses = p->objects,
        .bounds = p->objects,
        .rounded_boxes = p->objects,
        .spheres = p->objects,
        .level = p->level,
        .rotated = p->form.rotated,
        .origin = p->form.origin,
    };
    duet_free(p->found.pairs);
    reference_way way = p->n <= EACH_WITH_EACH_LIMIT ? REFERENCE_EACH_WITH_EACH : REFERENCE_COLUMNS;
    if (!reference_find(&objects, way, &p->found, err))
        return false;
    *found = (worker_found){.spans = {{p->found.pairs, p->found.n}}};
    return true;
}

static bool take_time(worker *w, const global_ids *ids, worker_found *found, duet_error *err)
{
    const plain_worker *p = (plain_worker *)w;
    const simulation *s = p->simulation;
    (void)ids, (void)err;
    if (!s->traffic) // which takes the time of bodies that move
        s->pass(s->object_seconds * s->stands_for * p->n);
    *found = (worker_found){0};
    return true;
}

static void close_plain(worker *w)
{
    duet_free(((plain_worker *)w)->found.pairs);
    free(((plain_worker *)w)->objects);
    free(w);
}

worker *worker_open_plain(const duet_world_def *def, const simulation *s, duet_error *err)
{
    if (!world_check_def(def, err))
        return NULL;
    plain_worker *p = calloc(1, sizeof *p);
    if (!p)
        return null_no_memory(err, "a rank's objects");
    bool finds = !s || s->object_seconds == 0;
    p->base = (worker){.name = finds ? "plain" : "simulated",
                       .map = map,
                       .extend = extend,
                       .begin = begin,
                       .find_interior = find_nothing,
                       .await_interior = await_nothing,
                       .order = order,
                       .use_grid = use_grid,
                       .forget_grids = forget_grids,
                       .find = finds ? find : take_time,
                       .bring = bring,
                       .set_level = set_level,
                       .set_plan = set_plan,
                       .plan = get_plan,
                       .load_profile = load_profile,
                       .close = close_plain};
    p->form = object_form_of(def);
    p->level = def->level;
    p->plan = def->plan;
    p->simulation = s;
    return &p->base;
}

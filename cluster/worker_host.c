// SPDX-License-Identifier: MIT
#include "cluster/worker_host.h"

#include "base/error.h"

#include <stdlib.h>

// Cannot fail for as many objects as there were.
static void *map(worker *w, uint32_t n, duet_error *err)
{
    worker_host *p = (worker_host *)w;
    if (!p->objects || n > p->capacity) {
        uint64_t most = (uint64_t)n + n / 16;
        void *objects = realloc(p->objects, (most + 1) * p->form.bytes);
        if (!objects) {
            error_set(err, DUET_STATUS_NO_MEMORY, "%u objects: no memory", n);
            return NULL;
        }
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

static bool skim_nothing(worker *w, const float inside_lower[3], const float inside_upper[3])
{
    (void)w, (void)inside_lower, (void)inside_upper;
    return false;
}

static uint32_t await_nothing(worker *w, uint32_t from, const skim_block **blocks)
{
    (void)w, (void)blocks;
    return from;
}

// Any order is as good as another.
static bool order(worker *w, uint32_t n_threads, uint32_t *order_of, void *scratch, duet_error *err)
{
    (void)n_threads, (void)scratch, (void)err;
    for (uint32_t i = 0; i < ((worker_host *)w)->n; ++i)
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
    return ((const worker_host *)w)->plan;
}

static bool set_level(worker *w, duet_level level, duet_error *err)
{
    (void)err;
    ((worker_host *)w)->level = level;
    return true;
}

static bool set_plan(worker *w, const duet_plan *plan, duet_error *err)
{
    (void)err;
    ((worker_host *)w)->plan = *plan;
    return true;
}

static bool load_profile(worker *w, const char *path, duet_profile *profile, duet_error *err)
{
    (void)w, (void)path, (void)err;
    *profile = (duet_profile){.grade = DUET_GRADE_DEFAULT};
    return true;
}

void worker_host_close(worker *w)
{
    free(((worker_host *)w)->objects);
    free(w);
}

void *worker_host_open(size_t bytes, const char *name, const duet_world_def *def, duet_error *err)
{
    worker_host *p = calloc(1, bytes);
    if (!p) {
        error_set(err, DUET_STATUS_NO_MEMORY, "a rank's objects: no memory");
        return NULL;
    }
    p->base = (worker){.name = name,
                       .map = map,
                       .extend = extend,
                       .begin = begin,
                       .skim = skim_nothing,
                       .await_skim = await_nothing,
                       .order = order,
                       .use_grid = use_grid,
                       .forget_grids = forget_grids,
                       .bring = bring,
                       .set_level = set_level,
                       .set_plan = set_plan,
                       .plan = get_plan,
                       .load_profile = load_profile,
                       .close = worker_host_close};
    p->form = object_form_of(def);
    p->level = def->level;
    p->plan = def->plan;
    return p;
}

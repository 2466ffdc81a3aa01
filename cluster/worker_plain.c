// SPDX-License-Identifier: MIT
// The plain C reference: slow, without OpenCL, and never wrong. Plans and profiles are of
// devices and change nothing here.
#include "cluster/worker.h"

#include "base/error.h"
#include "cluster/objects.h"
#include "runtime/broadphase/world.h"
#include "runtime/scene/reference.h"

#include <stdlib.h>

enum { EACH_WITH_EACH_LIMIT = 2000 };

typedef struct plain_worker {
    worker base;
    object_form form;
    duet_level level;
    void *objects;
    uint32_t n;
    reference_found found;
} plain_worker;

static void *map(worker *w, uint32_t n, duet_error *err)
{
    plain_worker *p = (plain_worker *)w;
    void *objects = realloc(p->objects, ((size_t)n + 1) * p->form.bytes);
    if (!objects) {
        error_set(err, DUET_STATUS_NO_MEMORY, "%u objects: no memory", n);
        return NULL;
    }
    p->objects = objects;
    p->n = n;
    return objects;
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

static void move(worker *w)
{
    (void)w;
}

static bool find(worker *w, worker_found *found, duet_error *err)
{
    plain_worker *p = (plain_worker *)w;
    reference_objects objects = {
        .dims = p->form.dims,
        .shape = p->form.shape,
        .n = p->n,
        .poses = p->objects,
        .bounds = p->objects,
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

static bool set_level(worker *w, duet_level level, duet_error *err)
{
    (void)err;
    ((plain_worker *)w)->level = level;
    return true;
}

static bool set_plan(worker *w, const duet_plan *plan, duet_error *err)
{
    (void)w, (void)plan, (void)err;
    return true;
}

static bool load_profile(worker *w, const char *path, duet_profile *profile, duet_error *err)
{
    (void)w, (void)path, (void)err;
    *profile = (duet_profile){.grade = DUET_GRADE_DEFAULT};
    return true;
}

static void close_plain(worker *w)
{
    plain_worker *p = (plain_worker *)w;
    duet_free(p->found.pairs);
    free(p->objects);
    free(p);
}

worker *worker_open_plain(const duet_world_def *def, duet_error *err)
{
    if (!world_check_def(def, err))
        return NULL;
    plain_worker *p = calloc(1, sizeof *p);
    if (!p) {
        error_set(err, DUET_STATUS_NO_MEMORY, "a rank's objects: no memory");
        return NULL;
    }
    p->base = (worker){.name = "plain",
                       .map = map,
                       .begin = begin,
                       .extend = extend,
                       .move = move,
                       .find = find,
                       .set_level = set_level,
                       .set_plan = set_plan,
                       .load_profile = load_profile,
                       .close = close_plain};
    p->form = object_form_of(def);
    p->level = def->level;
    return &p->base;
}

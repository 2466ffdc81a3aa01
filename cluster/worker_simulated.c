// SPDX-License-Identifier: MIT
// In the place of devices that are not here: they take their time, and find nothing.
#include "cluster/worker.h"

#include "base/error.h"
#include "cluster/objects.h"
#include "cluster/ranks.h"

#include <stdlib.h>

typedef struct simulated_worker {
    worker base;
    const simulation *simulation;
    object_form form;
    void *objects;
    uint32_t n;
} simulated_worker;

static void *map(worker *w, uint32_t n, duet_error *err)
{
    simulated_worker *p = (simulated_worker *)w;
    void *objects = realloc(p->objects, ((size_t)n + 1) * p->form.bytes);
    if (!objects) {
        error_set(err, DUET_STATUS_NO_MEMORY, "%u objects: no memory", n);
        return NULL;
    }
    p->n = n;
    p->objects = objects;
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
    const simulated_worker *p = (simulated_worker *)w;
    const simulation *s = p->simulation;
    (void)err;
    s->pass(s->object_seconds * s->stands_for * p->n);
    *found = (worker_found){0};
    return true;
}

static bool set_level(worker *w, duet_level level, duet_error *err)
{
    (void)w, (void)level, (void)err;
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

static void close_simulated(worker *w)
{
    free(((simulated_worker *)w)->objects);
    free(w);
}

worker *worker_open_simulated(const duet_world_def *def, const simulation *s, duet_error *err)
{
    simulated_worker *p = calloc(1, sizeof *p);
    if (!p) {
        error_set(err, DUET_STATUS_NO_MEMORY, "a rank's objects: no memory");
        return NULL;
    }
    p->base = (worker){.name = "simulated",
                       .map = map,
                       .begin = begin,
                       .extend = extend,
                       .move = move,
                       .find = find,
                       .set_level = set_level,
                       .set_plan = set_plan,
                       .load_profile = load_profile,
                       .close = close_simulated};
    p->simulation = s;
    p->form = object_form_of(def);
    return &p->base;
}

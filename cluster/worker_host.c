// SPDX-License-Identifier: MIT
#include "cluster/worker_host.h"

#include "base/error.h"

#include <stdlib.h>

// As many as there were have their memory: that cannot fail.
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

static void begin(worker *w, uint32_t n, const global_ids *ids)
{
    (void)w, (void)n, (void)ids;
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

static bool set_level(worker *w, duet_level level, duet_error *err)
{
    (void)err;
    ((worker_host *)w)->level = level;
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
                       .begin = begin,
                       .extend = extend,
                       .move = move,
                       .set_level = set_level,
                       .set_plan = set_plan,
                       .load_profile = load_profile,
                       .close = worker_host_close};
    p->form = object_form_of(def);
    p->level = def->level;
    return p;
}

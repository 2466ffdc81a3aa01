// SPDX-License-Identifier: MIT
// The plain C reference: slow, without OpenCL, and never wrong.
#include "cluster/worker_host.h"

#include "runtime/broadphase/world.h"
#include "runtime/scene/reference.h"

enum { EACH_WITH_EACH_LIMIT = 2000 };

typedef struct plain_worker {
    worker_host host;
    reference_found found;
} plain_worker;

static bool find(worker *w, const global_ids *ids, worker_found *found, duet_error *err)
{
    plain_worker *p = (plain_worker *)w;
    (void)ids;
    reference_objects objects = {
        .dims = p->host.form.dims,
        .shape = p->host.form.shape,
        .n = p->host.n,
        .poses = p->host.objects,
        .bounds = p->host.objects,
        .rounded_boxes = p->host.objects,
        .spheres = p->host.objects,
        .level = p->host.level,
        .rotated = p->host.form.rotated,
        .origin = p->host.form.origin,
    };
    duet_free(p->found.pairs);
    reference_way way =
        p->host.n <= EACH_WITH_EACH_LIMIT ? REFERENCE_EACH_WITH_EACH : REFERENCE_COLUMNS;
    if (!reference_find(&objects, way, &p->found, err))
        return false;
    *found = (worker_found){.spans = {{p->found.pairs, p->found.n}}};
    return true;
}

static void close_plain(worker *w)
{
    duet_free(((plain_worker *)w)->found.pairs);
    worker_host_close(w);
}

worker *worker_open_plain(const duet_world_def *def, duet_error *err)
{
    plain_worker *p =
        world_check_def(def, err) ? worker_host_open(sizeof *p, "plain", def, err) : NULL;
    if (!p)
        return NULL;
    p->host.base.find = find;
    p->host.base.close = close_plain;
    return &p->host.base;
}

// SPDX-License-Identifier: MIT
// The workers that search for a rank: one, or two.
#include "cluster/cluster.h"

#include "runtime/opencl/device_pair.h"

#include <math.h>

void cluster_close_workers(worker *workers[2])
{
    for (int i = 0; i < 2; ++i) {
        if (workers[i])
            workers[i]->close(workers[i]);
        workers[i] = NULL;
    }
}

worker *cluster_open_worker(const duet_cluster *c, const duet_world_def *world, duet_error *err)
{
    return c->def.plain ? worker_open_plain(world, c->ranks.simulation, err)
                        : worker_open_pair(world, err);
}

bool cluster_open_workers(const duet_cluster *c, const duet_world_def *world, worker *workers[2],
                          duet_error *err)
{
    bool ok = true;
    for (int i = 0; ok && i < cluster_workers(c); ++i) {
        workers[i] = cluster_open_worker(c, world, err);
        ok = workers[i];
    }
    if (!ok)
        cluster_close_workers(workers);
    return ok;
}

bool cluster_spares_host(const duet_cluster *c)
{
    const duet_device_pair *pair = c->def.plain ? NULL : c->def.world.pair;
    uint32_t share = c->workers[0]->plan(c->workers[0]).share;
    return pair && !(share > 0 && pair->devices[0].info.host_memory) &&
           !(share < DUET_SHARE_ONE && pair->devices[1].info.host_memory);
}

// Whether they did so far that a new grid pays: by a quarter of the width that they take, on any
// side.
static bool have_moved(const duet_cluster *c)
{
    const extent *now = &c->owned.around;
    bool moved = false;
    for (int k = 0; k < 3; ++k) {
        double far = 0.25 * (c->fitted.upper[k] - c->fitted.lower[k]);
        moved = moved || fabs(now->lower[k] - c->fitted.lower[k]) > far ||
                fabs(now->upper[k] - c->fitted.upper[k]) > far;
    }
    return moved;
}

void cluster_follow(duet_cluster *c)
{
    bool are_placed = cluster_workers(c) == 2 && c->n_placed != c->owned.n_placed;
    if (!are_placed && !have_moved(c))
        return;
    for (int i = 0; i < 2; ++i)
        if (c->workers[i])
            c->workers[i]->forget_grids(c->workers[i]);
    c->fitted = c->owned.around;
    c->n_placed = c->owned.n_placed;
}

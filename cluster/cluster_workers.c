// SPDX-License-Identifier: MIT
// The devices of a rank, and the workers that search on them: one, or two.
#include "cluster/cluster.h"

#include "runtime/opencl/device_pair.h"

#include <stdio.h>

// ---------------------------------------------------------------- devices

enum { SELECTOR = 96 };

static bool is_wider(const duet_device_info *info, const duet_device_info *than)
{
    return !than || info->units > than->units;
}

static void choose(char selector[SELECTOR], const duet_device_list *list, const ranks *r)
{
    const duet_device_info *cpu = NULL;
    uint32_t gpus = 0;
    uint32_t n = duet_device_list_get_count(list);
    for (uint32_t i = 0; i < n; ++i) {
        const duet_device_info *info = duet_device_list_get_info(list, i);
        gpus += info->kind == DUET_KIND_GPU;
        if (info->kind == DUET_KIND_CPU && is_wider(info, cpu))
            cpu = info;
    }
    uint32_t own = gpus > 0 ? (uint32_t)r->self_on_host % gpus : 0;
    for (uint32_t i = 0; i < n && gpus > 0; ++i) {
        const duet_device_info *info = duet_device_list_get_info(list, i);
        if (info->kind == DUET_KIND_GPU && own-- == 0)
            snprintf(selector, SELECTOR, "%s", info->selector);
    }
    if (gpus > 0 || !cpu)
        return;
    uint32_t parts = cpu->can_cut ? cpu->units : 1;
    parts = parts < (uint32_t)r->n_on_host ? parts : (uint32_t)r->n_on_host;
    if (parts > 1)
        snprintf(selector, SELECTOR, "%s[%u/%u]", cpu->selector,
                 (uint32_t)r->self_on_host % parts + 1, parts);
    else
        snprintf(selector, SELECTOR, "%s", cpu->selector);
}

bool cluster_open_pair(duet_cluster *c, duet_error *err)
{
    char selector[SELECTOR] = "";
    duet_device_pair_def own = duet_default_device_pair_def();
    if (c->def.plain || c->def.world.pair)
        return true;
    own.on_compile = c->def.on_compile;
    own.context = c->def.context;
    own.a = c->def.pair ? c->def.pair : own.a;
    if (!own.a && c->ranks.n_on_host > 1) {
        duet_device_list *list = duet_device_list_create(err);
        if (!list)
            return false;
        choose(selector, list, &c->ranks);
        duet_device_list_destroy(list);
        own.a = *selector ? selector : NULL;
    }
    c->own_pair = duet_device_pair_create(&own, err);
    c->def.world.pair = c->own_pair;
    return c->own_pair;
}

// ---------------------------------------------------------------- workers

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

int cluster_workers(const duet_cluster *c)
{
    return c->owned.n_domains > 1 ? 2 : 1;
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

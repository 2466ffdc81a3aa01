// SPDX-License-Identifier: MIT
#include "cluster/own_pair.h"

#include "runtime/duet.h"

#include <stdio.h>

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

duet_device_pair *own_pair_open(const ranks *r, const duet_cluster_def *def, duet_error *err)
{
    char selector[SELECTOR] = "";
    duet_device_pair_def own = duet_default_device_pair_def();
    own.on_compile = def->on_compile;
    own.context = def->context;
    own.a = def->pair ? def->pair : own.a;
    if (!own.a && r->n_on_host > 1) {
        duet_device_list *list = duet_device_list_create(err);
        if (!list)
            return NULL;
        choose(selector, list, r);
        duet_device_list_destroy(list);
        own.a = *selector ? selector : NULL;
    }
    return duet_device_pair_create(&own, err);
}

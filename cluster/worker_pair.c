// SPDX-License-Identifier: MIT
// A world of its own on the rank's device pair. Its grid lies around what the rank sees, not
// around the whole world.
#include "cluster/worker_pair.h"

#include "base/error.h"
#include "cluster/objects.h"
#include "runtime/broadphase/order.h"
#include "runtime/broadphase/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *map(worker *w, uint32_t n, duet_error *err)
{
    worker_pair *p = (worker_pair *)w;
    world_cancel_prefetch(p->world);
    return duet_world_map_objects(p->world, p->kind, n, err);
}

static void begin(worker *w, uint32_t n)
{
    world_prefetch(((worker_pair *)w)->world, n);
}

static bool find_interior(worker *w, const float inside_lower[3], const float inside_upper[3])
{
    return world_find_interior(((worker_pair *)w)->world, inside_lower, inside_upper);
}

static uint32_t await_interior(worker *w, uint32_t from, const interior_block **blocks)
{
    return world_await_interior(((worker_pair *)w)->world, from, blocks);
}

static void *map_with_spare(worker_pair *p, uint32_t n, duet_error *err)
{
    uint64_t wanted = (uint64_t)n + n / 16;
    uint32_t most = wanted < DUET_MOST_OBJECTS ? (uint32_t)wanted : n;
    return map(&p->base, most, err) ? map(&p->base, n, err) : NULL;
}

// Into more memory. Without it the objects stay where they are.
static void *grow(worker_pair *p, uint32_t n, uint32_t kept, duet_error *err)
{
    host_block *now = &p->world->objects_block, before = *now;
    world_cancel_prefetch(p->world);
    *now = (host_block){0};
    void *objects = map_with_spare(p, n, err);
    if (objects) {
        memcpy(objects, before.bytes, (size_t)kept * p->bytes);
        host_block_release(&before);
        return objects;
    }
    host_block_release(now);
    *now = before;
    map(&p->base, kept, NULL);
    return NULL;
}

static void *extend(worker *w, uint32_t n, uint32_t kept, duet_error *err)
{
    worker_pair *p = (worker_pair *)w;
    if (kept == 0)
        return map_with_spare(p, n, err);
    void *objects = world_extend_objects(p->world, p->kind, n);
    return objects ? objects : grow(p, n, kept, err);
}

// Pairs are then of objects that lie near each other.
static bool order(worker *w, uint32_t n_threads, uint32_t *order_of, void *scratch, duet_error *err)
{
    _Static_assert((int)ORDER_SCRATCH == (int)WORKER_ORDER_SCRATCH, "what it needs");
    return world_order(((worker_pair *)w)->world, n_threads, order_of, scratch, err);
}

static void forget_fits(worker_pair *p)
{
    for (uint32_t i = 0; i < p->n_fits; ++i)
        p->fits[i].n = 0;
}

static void forget_grids(worker *w)
{
    worker_pair *p = (worker_pair *)w;
    forget_fits(p);
    world_refit_grid(p->world);
}

static bool use_grid(worker *w, uint32_t domain, duet_error *err)
{
    worker_pair *p = (worker_pair *)w;
    if (domain >= p->n_fits) {
        uint32_t n = 2 * domain + 1;
        world_fit *fits = realloc(p->fits, n * sizeof *fits);
        if (!fits)
            return no_memory(err, "grids of %u parts", n);
        memset(fits + p->n_fits, 0, (n - p->n_fits) * sizeof *fits);
        p->fits = fits;
        p->n_fits = n;
    }
    if (domain != p->domain) {
        world_swap_fit(p->world, &p->fits[p->domain]);
        world_swap_fit(p->world, &p->fits[domain]);
        p->domain = domain;
    }
    return true;
}

static bool find(worker *w, const global_ids *ids, worker_found *found, duet_error *err)
{
    worker_pair *p = (worker_pair *)w;
    duet_result result;
    part_counted counted[2] = {{0}};
    bool ok = ids ? world_step_counting(p->world, ids, &result, counted, err)
                  : duet_world_step(p->world, &result, err);
    if (!ok)
        return false;
    *found = (worker_found){.spans = {result.spans[0], result.spans[1]},
                            .n_counted = counted[0].n + counted[1].n,
                            .hash = counted[0].hash + counted[1].hash,
                            .has_bad = result.bad > 0,
                            .first_bad = result.first_bad};
    return true;
}

static bool bring(worker *w, worker_found *found, duet_error *err)
{
    found->n_counted = found->hash = 0;
    return world_read_counted(((worker_pair *)w)->world, found->spans, err);
}

static bool set_level(worker *w, duet_level level, duet_error *err)
{
    return duet_world_set_level(((worker_pair *)w)->world, level, err);
}

static bool set_plan(worker *w, const duet_plan *plan, duet_error *err)
{
    forget_fits((worker_pair *)w);
    return duet_world_set_plan(((worker_pair *)w)->world, plan, err);
}

static duet_plan get_plan(const worker *w)
{
    return *duet_world_get_plan(((const worker_pair *)w)->world);
}

static bool load_profile(worker *w, const char *path, duet_profile *profile, duet_error *err)
{
    forget_fits((worker_pair *)w);
    return duet_world_load_profile(((worker_pair *)w)->world, path, profile, err);
}

static void close_pair(worker *w)
{
    duet_world_destroy(((worker_pair *)w)->world);
    free(((worker_pair *)w)->fits);
    free(w);
}

static void name_pair(worker_pair *p, const duet_device_pair *pair)
{
    const char *a = duet_device_pair_get_info(pair, 0)->selector;
    const char *b = duet_device_pair_get_info(pair, 1)->selector;
    bool one = duet_device_pair_is_one(pair);
    snprintf(p->name, sizeof p->name, "%s%s%s", a, one ? "" : ",", one ? "" : b);
    p->base.name = p->name;
}

worker *worker_open_pair(const duet_world_def *def, duet_error *err)
{
    worker_pair *p = calloc(1, sizeof *p);
    if (!p)
        return null_no_memory(err, "a rank's world");
    duet_world_def own = *def;
    own.has_world = false;
    own.keep_bad = true; // so that it is the cluster that names a bad object
    p->base = (worker){.map = map,
                       .begin = begin,
                       .find_interior = find_interior,
                       .await_interior = await_interior,
                       .extend = extend,
                       .order = order,
                       .forget_grids = forget_grids,
                       .use_grid = use_grid,
                       .find = find,
                       .bring = bring,
                       .set_level = set_level,
                       .set_plan = set_plan,
                       .plan = get_plan,
                       .load_profile = load_profile,
                       .close = close_pair};
    p->world = duet_world_create(&own, err);
    if (!p->world) {
        free(p);
        return NULL;
    }
    object_form form = object_form_of(def);
    p->kind = object_form_kind(&form);
    p->bytes = form.bytes;
    name_pair(p, def->pair);
    return &p->base;
}

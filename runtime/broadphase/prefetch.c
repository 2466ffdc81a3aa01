// SPDX-License-Identifier: MIT
// Sends the first objects while the caller writes others behind them, and has a device classify
// them for a host that has to look at all others.
#include "runtime/broadphase/world.h"

#include <string.h>

static bool prefetch(part *p, const host_array *objects, size_t bytes, uint64_t step)
{
    const selection first = {.kind = SELECT_RANGES, .n_ranges = 1, .ranges = {{0, objects->n}}};
    view_forget(&p->objects);
    part_begin(p, objects, step);
    return buffer_reserve(&p->objects.own, p->device, bytes, NULL) &&
           view_update(&p->objects, &p->times, objects, &first, part_chunk_size(p, objects->n),
                       NULL);
}

// A device that is sent all objects, into memory of its own. The step may use other kernels, of
// another grid; here they only set the chunk size.
static bool can_prefetch(const duet_world *world, int side)
{
    uint32_t share = world->def.plan.share;
    return world_is_prepared(world, side) && world->def.plan.mode == DUET_MODE_OWN &&
           !world->parts[side].device->info.host_memory && !world->def.pose_form &&
           (side == 0 ? share > 0 : share < DUET_SHARE_ONE);
}

void world_prefetch(duet_world *world, uint32_t n)
{
    host_array first = world->objects.all;
    first.n = n;
    const uint64_t step = world->def.stage_times ? 0 : world->steps;
    for (int side = 0; side < 2 && n > 0 && !world->resident.mem; ++side) {
        part *p = &world->parts[side];
        if (can_prefetch(world, side) && !prefetch(p, &first, world->objects_block.size, step))
            part_invalidate(p);
    }
}

void world_cancel_prefetch(duet_world *world)
{
    for (int side = 0; side < 2; ++side)
        if (view_is_prefetched(&world->parts[side].objects))
            part_invalidate(&world->parts[side]);
}

// ---------------------------------------------------------------- classified

// The kernel does not know origin cells, sizes that lie apart, and radii. It is built when it is
// first asked for.
static bool has_kernel(part *p, const duet_world_def *def, duet_error *err)
{
    const bool knows = (def->shape == DUET_SHAPE_POSES || def->shape == DUET_SHAPE_BOUNDS) &&
                       def->origin_edge == 0.0f && !def->pose_form;
    return knows && (p->kernels.find_interior || part_prepare_interior(p, err));
}

// The blocks of a chunk travel while the next one is on its way.
static bool find_in_chunk(part *p, uint32_t from, uint32_t i, duet_error *err)
{
    const view_chunk *c = &p->objects.chunks[i];
    size_t at = from / INTERIOR_ROWS, end = ((size_t)c->to + INTERIOR_ROWS - 1) / INTERIOR_ROWS;
    p->args.interior_from = from;
    p->args.n = c->to;
    bool ok = timeline_launch_after(&p->times, "find_interior", p->kernels.find_interior,
                                    c->to - from, c->sent, p, err) &&
              timeline_start_read(&p->times, "fetch interior", &p->interior.blocks,
                                  at * sizeof(interior_block),
                                  (interior_block *)p->interior.on_host.bytes + at,
                                  (end - at) * sizeof(interior_block), err);
    p->interior.done[i] = timeline_last_event(&p->times);
    return ok;
}

static bool find_interior(part *p, const duet_world_def *def, const float inside_lower[3],
                          const float inside_upper[3], duet_error *err)
{
    const device_view *v = &p->objects;
    if (!view_is_prefetched(v) || !has_kernel(p, def, err))
        return false;
    uint32_t n = v->chunks[v->n_chunks - 1].to, from = 0;
    size_t bytes = ((size_t)n + INTERIOR_ROWS - 1) / INTERIOR_ROWS * sizeof(interior_block);
    bool ok = buffer_reserve(&p->interior.blocks, p->device, bytes, NULL) &&
              host_block_reserve(&p->interior.on_host, p->device, 1, bytes, err);
    p->args = (part_args){.objects = v->own};
    memcpy(&p->args.inside_lower, inside_lower, 3 * sizeof *inside_lower);
    memcpy(&p->args.inside_upper, inside_upper, 3 * sizeof *inside_upper);
    for (uint32_t i = 0; ok && i < v->n_chunks; from = v->chunks[i++].to)
        ok = find_in_chunk(p, from, i, err);
    return ok;
}

// B, which has most of the work, unless A alone has prefetched objects.
static part *interior_part(duet_world *world)
{
    return &world->parts[view_is_prefetched(&world->parts[1].objects)];
}

bool world_find_interior(duet_world *world, const float inside_lower[3],
                         const float inside_upper[3])
{
    part *p = interior_part(world);
    const device_view *v = &p->objects;
    return v->n_chunks > 0 && v->chunks[v->n_chunks - 1].to == world->objects.all.n &&
           find_interior(p, &world->def, inside_lower, inside_upper, NULL);
}

uint32_t world_await_interior(duet_world *world, uint32_t from, const interior_block **blocks)
{
    part *p = interior_part(world);
    uint32_t i = 0;
    while (i + 1 < p->objects.n_chunks && p->objects.chunks[i].to <= from)
        ++i;
    timeline_spin(&p->times, p->interior.done[i]);
    *blocks = p->interior.on_host.bytes;
    return p->objects.chunks[i].to;
}

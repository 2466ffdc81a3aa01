// SPDX-License-Identifier: MIT
// Makes a part's views equal to what a step wants.
#include "runtime/broadphase/part.h"

#include "runtime/broadphase/part_ids.h"

// A chunk is whole groups of the kernels that read it, the last one apart. All are powers of two.
uint32_t part_chunk_size(const part *p, uint32_t n)
{
    uint64_t unit = (uint64_t)p->kernels.hash->group * p->kernels.hash->per_item;
    unit = unit < SKIM_ROWS ? SKIM_ROWS : unit;
    uint64_t size = (uint64_t)n / VIEW_CHUNKS + 1;
    size = size < p->least_chunk ? p->least_chunk : size;
    size = (size + unit - 1) / unit * unit;
    return size < n ? (uint32_t)size : n;
}

// Rows behind prefetched ones travel in chunks, too. A part that receives its grid needs all
// objects at once.
static uint32_t chunk_of(const part *p, uint32_t n)
{
    const part_task *task = &p->task;
    const bool in_chunks = p->variant.send == SEND_CHUNKS && task->role != GRID_RECEIVED &&
                           task->wanted.kind == SELECT_ALL && !p->device->info.host_memory;
    return in_chunks || p->objects.n_chunks > 0 ? part_chunk_size(p, n) : 0;
}

static bool update_objects(part *p, duet_error *err)
{
    const part_task *task = &p->task;
    const host_array *objects = &task->objects->all;
    if (!view_continues(&p->objects, objects, &task->wanted))
        part_drop_prefetch(p);
    bool ok = task->wanted.kind == SELECT_LIST
                  ? view_update_list(&p->objects, &p->times, task->lists, p->side,
                                     objects->generation, &task->wanted, err)
                  : view_update(&p->objects, &p->times, objects, &task->wanted,
                                chunk_of(p, objects->n), err);
    if (ok && !view_has(&p->objects, objects->generation, &task->wanted))
        part_enter(p, PART_CROWDED);
    return ok;
}

// The row behind the last belongs to none (world_set.c).
static bool update_sizes(part *p, duet_error *err)
{
    host_array sizes = p->task.objects->sizes;
    const selection all = select_all(++sizes.n);
    return !sizes.rows || view_update(&p->sizes, &p->times, &sizes, &all, 0, err);
}

// The device has a copy of the levels, whatever memory it works on: the grid may change in place.
// The view is forgotten if it does.
static bool update_levels(part *p, const grid *g, duet_error *err)
{
    device_view *v = &p->levels;
    bool ok = v->generation > 0 || timeline_write(&p->times, "send objects", &v->own, g->levels,
                                                  g->n_levels * sizeof g->levels[0], err);
    v->generation = ok;
    return ok;
}

bool part_update_views(part *p, duet_error *err)
{
    return update_objects(p, err) && update_sizes(p, err) && update_levels(p, p->task.grid, err) &&
           (!p->task.ids || part_update_ids(p, p->task.ids, err));
}

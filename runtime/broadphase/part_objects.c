// SPDX-License-Identifier: MIT
// Makes a part's views equal to what a step wants of the objects, and prefetches them.
#include "runtime/broadphase/part.h"

#include "runtime/broadphase/part_ids.h"

// A chunk is whole groups of the kernels that read it, the last one apart. All are powers of two.
static uint32_t chunk_size(const part *p, uint32_t n)
{
    uint64_t unit = (uint64_t)p->kernels.hash->group * p->kernels.hash->per_item;
    unit = unit < SKIM_ROWS ? SKIM_ROWS : unit;
    uint64_t size = (uint64_t)n / VIEW_CHUNKS + 1;
    size = size < p->least_chunk ? p->least_chunk : size;
    size = (size + unit - 1) / unit * unit;
    return size < n ? (uint32_t)size : n;
}

// ---------------------------------------------------------------- before a step

bool part_prefetch(part *p, const host_array *objects, size_t bytes, const global_ids *ids,
                   uint64_t step, duet_error *err)
{
    const selection first = select_first(objects->n);
    part_begin(p, step);
    view_forget(&p->objects);
    return buffer_reserve(&p->objects.own, p->device, bytes, err) &&
           (!ids || part_prefetch_ids(p, ids, err)) &&
           view_update(&p->objects, &p->times, objects, &first, chunk_size(p, objects->n), err);
}

// ---------------------------------------------------------------- in a step

static host_array objects_of(const part_task *task)
{
    const grid_objects *o = &task->objects;
    return (host_array){o->array, o->row_bytes, o->n, o->generation};
}

// The row behind the last belongs to none (world_set.c).
static host_array sizes_of(const part_task *task)
{
    const grid_objects *o = &task->objects;
    return (host_array){o->sizes, sizeof *o->sizes, o->n + 1, o->sizes_generation};
}

// Rows behind prefetched ones travel in chunks, too. A part that receives its grid needs all
// objects at once.
static uint32_t chunk_of(const part *p, const part_task *task, uint32_t n)
{
    const device_view *v = &p->objects;
    const bool in_chunks = p->variant.send == SEND_CHUNKS && task->role != GRID_RECEIVED &&
                           task->wanted.kind == SELECT_ALL && !p->device->info.host_memory;
    if (v->n_chunks > 0)
        return chunk_size(p, n - v->chunks[v->n_chunks - 1].to);
    return in_chunks ? chunk_size(p, n) : 0;
}

static bool update_objects(part *p, const part_task *task, compaction *lists, int side,
                           bool *placed, duet_error *err)
{
    const host_array objects = objects_of(task);
    if (!view_continues(&p->objects, &objects, &task->wanted))
        part_drop_prefetch(p);
    if (task->wanted.kind == SELECT_LIST)
        return view_update_list(&p->objects, &p->times, lists, side, objects.generation,
                                &task->wanted, placed, err);
    return view_update(&p->objects, &p->times, &objects, &task->wanted,
                       chunk_of(p, task, objects.n), err);
}

static bool update_sizes(part *p, const part_task *task, duet_error *err)
{
    const host_array sizes = sizes_of(task);
    const selection all = select_all(sizes.n);
    return !sizes.rows || view_update(&p->sizes, &p->times, &sizes, &all, 0, err);
}

// The grid is the world's and may move: the device has a copy of its levels, whatever memory it
// works on.
static bool update_levels(part *p, const part_task *task, duet_error *err)
{
    device_view *v = &p->levels;
    const grid *g = task->grid;
    if (v->generation == g->generation)
        return true;
    bool ok = timeline_write(&p->times, "send objects", &v->own, g->levels,
                             g->n_levels * sizeof g->levels[0], err);
    v->generation = ok ? g->generation : 0;
    return ok;
}

bool part_update_views(part *p, part_task *task, compaction *lists, int side, bool *placed,
                       duet_error *err)
{
    *placed = true;
    bool ok = task->objects.n == 0 ||
              (update_objects(p, task, lists, side, placed, err) && update_sizes(p, task, err) &&
               update_levels(p, task, err) && (!task->ids || part_update_ids(p, task->ids, err)));
    task->objects.n = task->objects.n > 0 ? p->objects.n : 0;
    return ok;
}

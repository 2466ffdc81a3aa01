// SPDX-License-Identifier: MIT
// Makes a part's views equal to what a step wants.
#include "runtime/broadphase/part.h"

#include "base/compare.h"
#include "kernels/grid/pair_counts.h"

#include <stdlib.h>

// ---------------------------------------------------------------- objects and levels

// A chunk is whole groups of the kernels that read it, the last one apart. All are powers of two.
uint32_t part_chunk_size(const part *p, uint32_t n)
{
    uint64_t unit = (uint64_t)p->kernels.hash->group * p->kernels.hash->per_item;
    unit = unit < INTERIOR_ROWS ? INTERIOR_ROWS : unit;
    uint64_t size = (uint64_t)n / VIEW_CHUNKS + 1;
    size = size < p->least_chunk ? p->least_chunk : size;
    size = (size + unit - 1) / unit * unit;
    return size < n ? (uint32_t)size : n;
}

// Rows behind prefetched ones travel in chunks, too. A part that receives its grid needs all
// objects at once.
static uint32_t chunk_of(const part *p, const host_array *objects)
{
    const part_task *task = &p->task;
    const bool in_chunks = p->variant.send == SEND_CHUNKS && task->role != GRID_RECEIVED &&
                           task->wanted.kind == SELECT_ALL && !p->device->info.host_memory;
    return in_chunks || view_continues(&p->objects, objects, &task->wanted)
               ? part_chunk_size(p, objects->n)
               : 0;
}

static bool update_objects(part *p, duet_error *err)
{
    const part_task *task = &p->task;
    const host_array *objects = &task->objects->all;
    bool ok = task->wanted.kind == SELECT_LIST
                  ? view_update_list(&p->objects, &p->times, task->lists, p->side,
                                     objects->generation, &task->wanted, err)
                  : view_update(&p->objects, &p->times, objects, &task->wanted,
                                chunk_of(p, objects), err);
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

// ---------------------------------------------------------------- global ids

// A row that kernels/grid/count_pairs.cl reads.
typedef struct id_change {
    uint32_t place;
    uint32_t low, high;
    uint32_t unused;
} id_change;

static bool has_id(const global_ids *ids, uint32_t place)
{
    return place < ids->n && (ids->n_without == 0 || !bsearch(&place, ids->without, ids->n_without,
                                                              sizeof place, compare_uint32));
}

// Lists each place once, or always with the same id: the kernel writes them in no order. After all
// ids were sent only those that objects do not have are changes.
static uint32_t list_changes(id_change *to, const global_ids *ids, uint64_t n_changed)
{
    uint32_t n = 0;
    for (uint64_t i = 0; i < n_changed; ++i) {
        uint32_t place = ids->changed[i];
        uint64_t id = place < ids->n ? ids->list[place] : 0;
        if (has_id(ids, place))
            to[n++] = (id_change){place, (uint32_t)id, (uint32_t)(id >> 32), 0};
    }
    for (uint32_t i = 0; i < ids->n_without; ++i)
        to[n++] = (id_change){ids->without[i], NO_GLOBAL_ID, NO_GLOBAL_ID, 0};
    return n;
}

static bool send_all_ids(part *p, const global_ids *ids, duet_error *err)
{
    buffer *b = &p->global_ids.own;
    size_t bytes = ids->n * sizeof *ids->list;
    return (bytes <= b->bytes || buffer_reserve(b, p->device, bytes + bytes / 16, err)) &&
           timeline_write_at(&p->times, "send ids", b, 0, ids->list, bytes, err);
}

static bool send_changed_ids(part *p, const global_ids *ids, uint64_t n_changed, duet_error *err)
{
    size_t most = ids->n_without + (size_t)n_changed;
    if (most == 0)
        return true;
    if (!host_block_reserve(&p->changes, p->device, 1, most * sizeof(id_change), err) ||
        !buffer_reserve(&p->id_changes, p->device, p->changes.size, err))
        return false;
    p->args.n_id_changes = list_changes(p->changes.bytes, ids, n_changed);
    return timeline_write_at(&p->times, "send ids", &p->id_changes, 0, p->changes.bytes,
                             p->args.n_id_changes * sizeof(id_change), err) &&
           timeline_launch(&p->times, "send ids", p->kernels.change_ids, p->args.n_id_changes, p,
                           err);
}

// A device keeps its ids from step to step, and is sent only those that changed if it has the
// generation before. One that had no work missed changes that are no longer listed, so it is sent
// all ids.
static bool update_ids(part *p, const global_ids *ids, duet_error *err)
{
    device_view *v = &p->global_ids;
    const uint64_t has = ids->n * sizeof *ids->list <= v->own.bytes ? v->generation : 0;
    if (ids->n == 0 || (has > 0 && has == ids->generation))
        return true;
    const bool follows =
        has > 0 && has + 1 == ids->generation && ids->n_changed > 0 && ids->n_changed <= ids->n / 4;
    v->generation = 0;
    bool ok = (follows || send_all_ids(p, ids, err)) &&
              send_changed_ids(p, ids, follows ? ids->n_changed : 0, err);
    v->generation = ok ? ids->generation : 0;
    return ok;
}

bool part_update_views(part *p, duet_error *err)
{
    return update_objects(p, err) && update_sizes(p, err) && update_levels(p, p->task.grid, err) &&
           (!p->task.ids || update_ids(p, p->task.ids, err));
}

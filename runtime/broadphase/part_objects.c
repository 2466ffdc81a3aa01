// SPDX-License-Identifier: MIT
// How the objects of a step, and what belongs to them, come to a part's device.
#include "runtime/broadphase/part.h"

#include "base/compare.h"
#include "kernels/grid/pair_counts.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- chunks

// A chunk is whole groups of the kernels that take them, the last one apart. All are powers of two.
static uint32_t chunk_size(const part *p, uint32_t n)
{
    uint64_t unit = (uint64_t)p->kernels.hash->group * p->kernels.hash->per_item;
    unit = p->kernels.skim && unit < SKIM_ROWS ? SKIM_ROWS : unit;
    uint64_t size = (uint64_t)n / PART_CHUNKS + 1;
    size = size < p->least_chunk ? p->least_chunk : size;
    size = (size + unit - 1) / unit * unit;
    return size < n ? (uint32_t)size : n;
}

// All chunks of those from `from` on are on their way at once, beside the kernels.
static bool send_chunks(part *p, const part_task *task, uint32_t from, duet_error *err)
{
    size_t bytes = task->objects.row_bytes;
    uint32_t size = chunk_size(p, task->objects.n - from);
    for (; from < task->objects.n; from = p->chunks[p->n_chunks - 1].to) {
        uint32_t n = task->objects.n - from < size ? task->objects.n - from : size;
        if (!timeline_write_beside(&p->times, "send objects", &p->objects, from * bytes,
                                   (const char *)task->objects.array + from * bytes, n * bytes,
                                   err))
            return false;
        p->chunks[p->n_chunks++] =
            (part_chunk){.to = from + n, .sent = timeline_last_event(&p->times)};
    }
    return true;
}

// ---------------------------------------------------------------- ahead of a step

static bool reserve_ids(part *p, const global_ids *ids, duet_error *err)
{
    size_t bytes = ids->n * sizeof *ids->list;
    return bytes <= p->global_ids.bytes ||
           buffer_reserve(&p->global_ids, p->device, bytes + bytes / 16, err);
}

// Before the objects: what waits for one of their chunks needs not wait for these.
static bool send_ids_ahead(part *p, const global_ids *ids, duet_error *err)
{
    p->ids_version = 0;
    if (ids->n == 0)
        return true;
    if (!reserve_ids(p, ids, err) ||
        !timeline_write_beside(&p->times, "send ids", &p->global_ids, 0, ids->list,
                               ids->n * sizeof *ids->list, err))
        return false;
    p->ids_version = ids->version;
    p->ids_ahead = true;
    return true;
}

bool part_send_ahead(part *p, const part_task *task, size_t bytes, uint64_t step, duet_error *err)
{
    part_begin(p, step);
    p->n_chunks = 0;
    p->objects_version = p->packed.objects_version = p->stretched.objects_version = 0;
    if (!buffer_reserve(&p->objects, p->device, bytes, err) ||
        (task->ids && !send_ids_ahead(p, task->ids, err)) || !send_chunks(p, task, 0, err))
        return false;
    p->ahead_version = task->objects_version;
    return true;
}

// Blocks of a chunk travel while the next one is on its way.
static bool skim_chunk(part *p, uint32_t from, part_chunk *c, duet_error *err)
{
    size_t at = from / SKIM_ROWS, end = ((size_t)c->to + SKIM_ROWS - 1) / SKIM_ROWS;
    p->args.skim_from = from;
    p->args.n = c->to;
    bool ok =
        timeline_launch_after(&p->times, "skim", p->kernels.skim, c->to - from, c->sent, p, err) &&
        timeline_start_read(&p->times, "fetch skim", &p->skimmed, at * sizeof(skim_block),
                            (skim_block *)p->skim_seen.bytes + at, (end - at) * sizeof(skim_block),
                            err);
    c->skimmed = timeline_last_event(&p->times);
    return ok;
}

bool part_skim(part *p, const float inside_lower[3], const float inside_upper[3], duet_error *err)
{
    if (!p->kernels.skim || p->ahead_version == 0 || p->n_chunks == 0)
        return false;
    uint32_t n = p->chunks[p->n_chunks - 1].to, from = 0;
    size_t bytes = ((size_t)n + SKIM_ROWS - 1) / SKIM_ROWS * sizeof(skim_block);
    bool ok = buffer_reserve(&p->skimmed, p->device, bytes, err) &&
              host_block_reserve(&p->skim_seen, p->device, 1, bytes, err);
    p->args = (part_args){.objects = p->objects};
    memcpy(&p->args.inside_lower, inside_lower, 3 * sizeof *inside_lower);
    memcpy(&p->args.inside_upper, inside_upper, 3 * sizeof *inside_upper);
    for (uint32_t i = 0; ok && i < p->n_chunks; from = p->chunks[i++].to)
        ok = skim_chunk(p, from, &p->chunks[i], err);
    return ok;
}

uint32_t part_await_skim(part *p, uint32_t from, const skim_block **blocks)
{
    uint32_t i = 0;
    while (p->chunks[i].to <= from)
        ++i;
    timeline_spin(&p->times, p->chunks[i].skimmed);
    *blocks = p->skim_seen.bytes;
    return p->chunks[i].to;
}

// What was sent ahead is of use where all objects are sent, to where it is.
static void take_ahead(part *p, const part_task *task, size_t bytes)
{
    bool takes = p->ahead_version == task->objects_version && !task->packed && !task->intake &&
                 !task->resident && p->objects.bytes >= bytes;
    if (p->ahead_version > 0 && !takes)
        timeline_clear(&p->times);
    p->n_chunks = takes ? p->n_chunks : 0;
    p->ahead_version = 0;
}

// ---------------------------------------------------------------- objects

static bool send_stretch(part *p, const part_task *task, stretch s, duet_error *err)
{
    size_t bytes = task->objects.row_bytes;
    const char *rows = (const char *)task->objects.array + s.from * bytes;
    return timeline_write_at(&p->times, "send objects", &p->objects, s.from * bytes, rows,
                             (s.to - s.from) * bytes, err);
}

// Sends the part what it takes of the input and does not have: its own stretch first.
static bool send_stretches(part *p, const part_task *task, duet_error *err)
{
    const part_intake *in = task->intake;
    const stretch *own = &in->sent.list[in->sent.own];
    bool has_own = p->stretched.objects_version == task->objects_version &&
                   p->stretched.own.from == own->from && p->stretched.own.to == own->to;
    bool has_others = has_own && p->stretched.strays_version == in->strays_version;
    p->objects_version = p->stretched.objects_version = 0;
    bool ok = has_own || send_stretch(p, task, *own, err);
    for (uint32_t i = 0; ok && !has_others && i < in->sent.n; ++i)
        ok = i == in->sent.own || send_stretch(p, task, in->sent.list[i], err);
    if (ok) {
        p->stretched.objects_version = task->objects_version;
        p->stretched.strays_version = in->strays_version;
        p->stretched.own = *own;
    }
    return ok;
}

static bool wants_chunks(const part *p, const part_task *task)
{
    return p->variant.send == SEND_CHUNKS && !task->receives && !p->device->info.host_memory;
}

// Objects that the device has already are not sent again.
static bool send_objects(part *p, const part_task *task, size_t bytes, duet_error *err)
{
    p->packed.objects_version = 0;
    if (!buffer_hold(&p->objects, p->device, (void *)task->objects.array, bytes, err))
        return false;
    if (p->objects_version == task->objects_version)
        return true;
    if (task->intake && !p->device->info.host_memory)
        return send_stretches(p, task, err);
    uint32_t ahead = p->n_chunks > 0 ? p->chunks[p->n_chunks - 1].to : 0;
    bool ok = ahead > 0 || wants_chunks(p, task)
                  ? send_chunks(p, task, ahead, err)
                  : timeline_write(&p->times, "send objects", &p->objects, task->objects.array,
                                   bytes, err);
    p->objects_version = ok ? task->objects_version : 0;
    return ok;
}

static bool send_sizes(part *p, const part_task *task, duet_error *err)
{
    if (!task->objects.sizes || p->sizes_version == task->sizes_version)
        return true;
    size_t bytes = ((size_t)task->objects.n + 1) * sizeof *task->objects.sizes;
    bool ok = buffer_hold(&p->sizes, p->device, (void *)task->objects.sizes, bytes, err) &&
              timeline_write(&p->times, "send objects", &p->sizes, task->objects.sizes, bytes, err);
    p->sizes_version = ok ? task->sizes_version : 0;
    return ok;
}

static bool send_levels(part *p, const part_task *task, duet_error *err)
{
    if (p->levels_version == task->grid_version)
        return true;
    bool ok = timeline_write(&p->times, "send objects", &p->levels, task->grid.levels,
                             task->grid.n_levels * sizeof task->grid.levels[0], err);
    p->levels_version = ok ? task->grid_version : 0;
    return ok;
}

// ---------------------------------------------------------------- ids

// A device keeps the ids from step to step and is sent only those that changed.

// As kernels/grid/count_pairs.cl reads it.
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

// Each place once, or always with the same id: they are written in no order.
static uint32_t list_changes(id_change *to, const global_ids *ids, bool all_sent)
{
    uint32_t n = 0;
    for (uint64_t i = 0; !all_sent && i < ids->n_changed; ++i) {
        uint32_t place = ids->changed[i];
        uint64_t id = place < ids->n ? ids->list[place] : 0;
        if (has_id(ids, place))
            to[n++] = (id_change){place, (uint32_t)id, (uint32_t)(id >> 32), 0};
    }
    for (uint32_t i = 0; i < ids->n_without; ++i)
        to[n++] = (id_change){ids->without[i], NO_GLOBAL_ID, NO_GLOBAL_ID, 0};
    return n;
}

static bool send_all(part *p, const global_ids *ids, duet_error *err)
{
    return reserve_ids(p, ids, err) &&
           timeline_write_at(&p->times, "send ids", &p->global_ids, 0, ids->list,
                             ids->n * sizeof *ids->list, err);
}

static bool send_changes(part *p, const global_ids *ids, bool all_sent, duet_error *err)
{
    size_t most = ids->n_without + (all_sent ? 0 : (size_t)ids->n_changed);
    if (most == 0)
        return true;
    if (!host_block_reserve(&p->changes, p->device, 1, most * sizeof(id_change), err) ||
        !buffer_reserve(&p->id_changes, p->device, p->changes.size, err))
        return false;
    p->args.n_id_changes = list_changes(p->changes.bytes, ids, all_sent);
    return timeline_write_at(&p->times, "send ids", &p->id_changes, 0, p->changes.bytes,
                             p->args.n_id_changes * sizeof(id_change), err) &&
           timeline_launch(&p->times, "send ids", p->kernels.change_ids, p->args.n_id_changes, p,
                           err);
}

// What a device missed while it had no work is in no list any more.
static bool send_ids(part *p, const global_ids *ids, duet_error *err)
{
    bool has_some = p->ids_version > 0 && ids->n * sizeof *ids->list <= p->global_ids.bytes;
    bool has_list = p->ids_ahead;
    p->ids_ahead = false;
    if (ids->n == 0)
        return true;
    if (has_some && p->ids_version == ids->version)
        return !has_list || send_changes(p, ids, true, err);
    bool follows = has_some && p->ids_version == ids->before && !ids->all_changed &&
                   ids->n_changed < ids->n / 4;
    p->ids_version = 0;
    bool ok = (follows || send_all(p, ids, err)) && send_changes(p, ids, !follows, err);
    p->ids_version = ok ? ids->version : 0;
    return ok;
}

bool part_send_objects(part *p, const part_task *task, duet_error *err)
{
    size_t bytes = task->objects.n * task->objects.row_bytes;
    take_ahead(p, task, bytes);
    if (bytes == 0)
        return true;
    return (task->packed || task->resident || send_objects(p, task, bytes, err)) &&
           send_sizes(p, task, err) && send_levels(p, task, err) &&
           (!task->ids || send_ids(p, task->ids, err));
}

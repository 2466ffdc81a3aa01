// SPDX-License-Identifier: MIT
// Sending one device the objects of its slab while they are being packed.
#include "runtime/pack.h"

#include "runtime/base/clock.h"

#include <sched.h>
#include <string.h>

static size_t object_bytes(const part_task *task)
{
    return task->shape == DUET_SHAPE_POSES ? sizeof(duet_pose) : sizeof(duet_bounds);
}

static uint32_t taken(pack_stream *s)
{
    return atomic_load_explicit(&s->taken, memory_order_relaxed);
}

// Objects [from, to) of the stream, to their places behind those `before` them.
static bool send_some(part *p, const pack_stream *s, size_t bytes, uint32_t before, uint32_t from,
                      uint32_t to, duet_error *err)
{
    return timeline_write_at(
               &p->times, "send objects", &p->objects, ((size_t)before + from) * bytes,
               (const char *)s->objects.bytes + from * bytes, (to - from) * bytes, err) &&
           timeline_flush(&p->times, err);
}

// Sends chunks as they fill. The thread that drives the device packs too while
// there is nothing to send. *sent: objects so far.
static bool send_while_packing(part *p, pack *from, pack_stream *homes, uint32_t *sent,
                               duet_error *err)
{
    size_t bytes = object_bytes(&from->task);
    for (uint32_t chunk = 0; !pack_is_done(from);) {
        if (pack_chunk_is_full(homes, chunk)) {
            if (!send_some(p, homes, bytes, 0, *sent, *sent + homes->chunk, err))
                return false;
            *sent += homes->chunk;
            ++chunk;
        } else if (!pack_block(from)) {
            sched_yield(); // others have the last blocks
        }
    }
    return true;
}

static bool send_names(part *p, const pack_stream *s, uint32_t before, uint32_t n, duet_error *err)
{
    return timeline_write_at(&p->times, "send objects", &p->names, before * sizeof(uint32_t),
                             s->names.bytes, n * sizeof(uint32_t), err);
}

static bool send_slab(part *p, pack *from, pack_slab *slab, bool *placed, duet_error *err)
{
    size_t bytes = object_bytes(&from->task);
    uint64_t begun = clock_steady_ns();
    uint32_t sent = 0;
    if (!send_while_packing(p, from, &slab->homes, &sent, err))
        return false;
    timeline_add_host(&p->times, "pack", (double)(clock_steady_ns() - begun) * 1e-6);
    uint32_t n_homes = taken(&slab->homes);
    uint32_t n_ghosts = taken(&slab->ghosts);
    *placed = n_homes <= slab->homes.room && n_ghosts <= slab->ghosts.room;
    p->packed.n = n_homes + n_ghosts;
    p->packed.n_homes = n_homes;
    return !*placed || (send_some(p, &slab->homes, bytes, 0, sent, n_homes, err) &&
                        send_some(p, &slab->ghosts, bytes, n_homes, 0, n_ghosts, err) &&
                        send_names(p, &slab->homes, 0, n_homes, err) &&
                        send_names(p, &slab->ghosts, n_homes, n_ghosts, err));
}

bool part_has_slab(const part *p, const part_task *task, const part_range *range)
{
    return p->packed.objects_version == task->objects_version &&
           p->packed.grid_version == task->grid_version && p->packed.key_from == range->key_from &&
           p->packed.key_to == range->key_to;
}

bool part_receive_slab(part *p, pack *from, int side, part_task *task, const part_range *range,
                       bool *placed, duet_error *err)
{
    pack_slab *slab = &from->slabs[side];
    *placed = true;
    if (slab->wanted) {
        size_t room = (size_t)slab->homes.room + slab->ghosts.room;
        p->objects_version = p->packed.objects_version = 0;
        if (!buffer_reserve(&p->objects, p->device, room * object_bytes(task), err) ||
            !buffer_reserve(&p->names, p->device, room * sizeof(uint32_t), err) ||
            !send_slab(p, from, slab, placed, err))
            return false;
        p->packed.objects_version = *placed ? task->objects_version : 0;
        p->packed.grid_version = task->grid_version;
        p->packed.key_from = range->key_from;
        p->packed.key_to = range->key_to;
    }
    task->n = p->packed.n;
    return true;
}

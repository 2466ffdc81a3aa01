// SPDX-License-Identifier: MIT
// Sending one device the objects of its slab while they are being packed.
#include "runtime/broadphase/pack.h"

#include "base/clock.h"

#include <assert.h>
#include <sched.h>

// Names follow their objects after so many chunks.
enum { NAMES_EVERY = 8 };

// A timeline that is full waits and forgets its events: it must not be.
static_assert(PACK_CHUNKS + PACK_CHUNKS / NAMES_EVERY + 16 <= TIMELINE_EVENTS, "events");

static size_t object_bytes(const part_task *task)
{
    return task->shape == DUET_SHAPE_POSES ? sizeof(duet_pose) : sizeof(duet_bounds);
}

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static uint32_t taken(pack_stream *s)
{
    return atomic_load_explicit(&s->taken, memory_order_relaxed);
}

// Sends n objects of one chunk to their places behind those `before` them.
static bool send_chunk(part *p, const pack_stream *s, size_t bytes, uint32_t before, uint32_t chunk,
                       uint32_t n, duet_error *err)
{
    size_t to = (size_t)before + (size_t)chunk * s->chunk;
    size_t slot = (size_t)(chunk % s->n_slots) * s->chunk;
    return timeline_write_at(&p->times, "send objects", &p->objects, to * bytes,
                             (const char *)s->objects.bytes + slot * bytes, n * bytes, err) &&
           timeline_flush(&p->times, err);
}

static bool send_names(part *p, const pack_stream *s, uint32_t before, uint32_t from, uint32_t to,
                       duet_error *err)
{
    return timeline_write_at(
        &p->times, "send objects", &p->names, ((size_t)before + from) * sizeof(uint32_t),
        (const uint32_t *)s->names.bytes + from, (to - from) * sizeof(uint32_t), err);
}

// A chunk that has travelled makes space for another.
static void free_slots(timeline *t, pack_stream *s, const cl_event travels[PACK_CHUNKS],
                       uint32_t n_chunks)
{
    uint32_t sent = atomic_load_explicit(&s->sent, memory_order_relaxed);
    if (sent < n_chunks && timeline_is_over(t, travels[sent]))
        atomic_store_explicit(&s->sent, sent + 1, memory_order_release);
}

// Sends whole chunks until everything is packed, and now and then the names of
// some. *n_chunks: how many.
static bool send_while_packing(part *p, pack *from, pack_stream *homes, uint32_t *n_chunks,
                               duet_error *err)
{
    cl_event travels[PACK_CHUNKS];
    size_t bytes = object_bytes(&from->task);
    uint32_t chunk = 0;
    bool done = false;
    bool ok = true;
    while (ok && !done) {
        done = pack_is_done(from);
        free_slots(&p->times, homes, travels, chunk);
        if (pack_chunk_is_full(homes, chunk)) {
            ok = send_chunk(p, homes, bytes, 0, chunk, homes->chunk, err);
            travels[chunk++] = timeline_last_event(&p->times);
            if (ok && chunk % NAMES_EVERY == 0)
                ok = send_names(p, homes, 0, (chunk - NAMES_EVERY) * homes->chunk,
                                chunk * homes->chunk, err);
        } else if (!done) {
            sched_yield();
        }
    }
    *n_chunks = chunk;
    return ok;
}

// What was packed after the first n_chunks, and the ghosts.
static bool send_rest(part *p, pack_slab *slab, uint32_t n_chunks, size_t bytes, duet_error *err)
{
    const pack_stream *homes = &slab->homes;
    const pack_stream *ghosts = &slab->ghosts;
    uint32_t n_homes = p->packed.n_homes;
    uint32_t n_ghosts = p->packed.n - n_homes;
    uint32_t named = n_chunks / NAMES_EVERY * NAMES_EVERY * homes->chunk;
    bool ok = true;
    for (uint32_t sent = n_chunks * homes->chunk; ok && sent < n_homes; sent += homes->chunk)
        ok = send_chunk(p, homes, bytes, 0, sent / homes->chunk,
                        smaller(n_homes - sent, homes->chunk), err);
    return ok && send_names(p, homes, 0, named, n_homes, err) &&
           (n_ghosts == 0 || (send_chunk(p, ghosts, bytes, n_homes, 0, n_ghosts, err) &&
                              send_names(p, ghosts, n_homes, 0, n_ghosts, err)));
}

static bool send_slab(part *p, pack *from, pack_slab *slab, bool *placed, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    uint32_t n_chunks = 0;
    if (!send_while_packing(p, from, &slab->homes, &n_chunks, err))
        return false;
    timeline_add_host(&p->times, "pack", (double)(clock_steady_ns() - begun) * 1e-6);
    uint32_t n_homes = taken(&slab->homes);
    uint32_t n_ghosts = taken(&slab->ghosts);
    *placed = !pack_is_abandoned(from) && n_homes <= slab->homes.capacity &&
              n_ghosts <= slab->ghosts.capacity;
    p->packed.n = n_homes + n_ghosts;
    p->packed.n_homes = n_homes;
    return !*placed || send_rest(p, slab, n_chunks, object_bytes(&from->task), err);
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
        size_t capacity = (size_t)slab->homes.capacity + slab->ghosts.capacity;
        p->objects_version = p->packed.objects_version = 0;
        if (!buffer_reserve(&p->objects, p->device, capacity * object_bytes(task), err) ||
            !buffer_reserve(&p->names, p->device, capacity * sizeof(uint32_t), err) ||
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

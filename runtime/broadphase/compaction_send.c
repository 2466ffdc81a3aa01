// SPDX-License-Identifier: MIT
// Sends one device the objects of its slab while the threads find them.
#define _POSIX_C_SOURCE 200809L
#include "runtime/broadphase/compaction.h"

#include "base/clock.h"

#include <assert.h>
#include <sched.h>

// Ids follow their objects after so many chunks.
enum { IDS_EVERY = 8 };

// A timeline that is full waits and forgets its events: it must not be.
static_assert(COMPACTION_CHUNKS + COMPACTION_CHUNKS / IDS_EVERY + 16 <= TIMELINE_EVENTS, "events");

// One device's list on its way.
typedef struct sending {
    device_view *view;
    timeline *times;
    compaction *from;
    compaction_slab *slab;
    cl_event travels[COMPACTION_CHUNKS];
    uint32_t n_chunks; // of the homes, that were sent while they were found
} sending;

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static uint32_t taken(compaction_stream *s)
{
    return atomic_load_explicit(&s->taken, memory_order_relaxed);
}

// Sends n objects of a chunk to the places behind the `before` objects of another stream.
static bool send_chunk(sending *s, const compaction_stream *of, uint32_t before, uint32_t chunk,
                       uint32_t n, duet_error *err)
{
    size_t bytes = s->from->objects.row_bytes;
    size_t to = (size_t)before + (size_t)chunk * of->chunk;
    size_t slot = (size_t)(chunk % of->n_slots) * of->chunk;
    return timeline_write_at(s->times, "send objects", &s->view->own, to * bytes,
                             (const char *)of->objects.bytes + slot * bytes, n * bytes, err) &&
           timeline_flush(s->times, err);
}

static bool send_ids(sending *s, const compaction_stream *of, uint32_t before, uint32_t from,
                     uint32_t to, duet_error *err)
{
    return timeline_write_at(
        s->times, "send objects", &s->view->ids, ((size_t)before + from) * sizeof(uint32_t),
        (const uint32_t *)of->ids.bytes + from, (to - from) * sizeof(uint32_t), err);
}

// A chunk that has travelled makes space for another.
static void free_slots(sending *s)
{
    atomic_uint *sent = &s->slab->homes.sent;
    uint32_t n = atomic_load_explicit(sent, memory_order_relaxed);
    if (n < s->n_chunks && timeline_is_over(s->times, s->travels[n]))
        atomic_store_explicit(sent, n + 1, memory_order_release);
}

static bool is_full(compaction_stream *s, uint32_t chunk)
{
    return chunk < COMPACTION_CHUNKS &&
           atomic_load_explicit(&s->filled[chunk], memory_order_acquire) == s->chunk;
}

static bool send_full_chunk(sending *s, duet_error *err)
{
    const compaction_stream *homes = &s->slab->homes;
    bool ok = send_chunk(s, homes, 0, s->n_chunks, homes->chunk, err);
    s->travels[s->n_chunks++] = timeline_last_event(s->times);
    return ok && (s->n_chunks % IDS_EVERY > 0 ||
                  send_ids(s, homes, 0, (s->n_chunks - IDS_EVERY) * homes->chunk,
                           s->n_chunks * homes->chunk, err));
}

// Sends whole chunks until everything is found, and now and then the ids of some.
static bool send_while_finding(sending *s, duet_error *err)
{
    bool done = false;
    while (!done) {
        done = atomic_load_explicit(&s->from->done, memory_order_acquire) == s->from->n_blocks;
        free_slots(s);
        if (is_full(&s->slab->homes, s->n_chunks)) {
            if (!send_full_chunk(s, err))
                return false;
        } else if (!done) {
            sched_yield();
        }
    }
    return true;
}

// Sends what was found behind the whole chunks, and the ghosts.
static bool send_rest(sending *s, duet_error *err)
{
    const compaction_stream *homes = &s->slab->homes, *ghosts = &s->slab->ghosts;
    uint32_t n_homes = s->view->n_home, n_ghosts = s->view->n - n_homes;
    uint32_t with_ids = s->n_chunks / IDS_EVERY * IDS_EVERY * homes->chunk;
    bool ok = true;
    for (uint32_t sent = s->n_chunks * homes->chunk; ok && sent < n_homes; sent += homes->chunk)
        ok = send_chunk(s, homes, 0, sent / homes->chunk, smaller(n_homes - sent, homes->chunk),
                        err);
    return ok && send_ids(s, homes, 0, with_ids, n_homes, err) &&
           (n_ghosts == 0 || (send_chunk(s, ghosts, n_homes, 0, n_ghosts, err) &&
                              send_ids(s, ghosts, n_homes, 0, n_ghosts, err)));
}

static bool send_list(sending *s, bool *placed, duet_error *err)
{
    compaction_slab *slab = s->slab;
    uint64_t begun = clock_steady_ns();
    if (!send_while_finding(s, err))
        return false;
    timeline_add_host(s->times, "pack", clock_ms_since(begun));
    uint32_t n_homes = taken(&slab->homes), n_ghosts = taken(&slab->ghosts);
    *placed = !atomic_load(&s->from->cancelled) && n_homes <= slab->homes.capacity &&
              n_ghosts <= slab->ghosts.capacity;
    s->view->n = n_homes + n_ghosts;
    s->view->n_home = n_homes;
    return *placed ? send_rest(s, err) : timeline_finish(s->times, err);
}

bool view_update_list(device_view *v, timeline *t, compaction *c, int side, uint64_t generation,
                      const selection *wanted, bool *placed, duet_error *err)
{
    sending s = {.view = v, .times = t, .from = c, .slab = &c->slabs[side]};
    const size_t capacity = (size_t)s.slab->homes.capacity + s.slab->ghosts.capacity;
    assert(wanted->kind == SELECT_LIST && !v->bound.mem);
    *placed = true;
    v->n_chunks = 0;
    if (view_has(v, generation, wanted))
        return true;
    v->generation = 0;
    if (!buffer_reserve(&v->own, t->device, capacity * c->objects.row_bytes, err) ||
        !buffer_reserve(&v->ids, t->device, capacity * sizeof(uint32_t), err) ||
        !send_list(&s, placed, err))
        return false;
    v->generation = *placed ? generation : 0;
    v->there = *wanted;
    return true;
}

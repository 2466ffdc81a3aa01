// SPDX-License-Identifier: MIT
// Sends one device the list of its slab's objects while the threads find them.
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
    compaction_list *list;
    cl_event travels[COMPACTION_CHUNKS];
    uint32_t n_chunks; // sent so far
} sending;

// Sends n objects of the next chunk.
static bool send_chunk(sending *s, uint32_t n, duet_error *err)
{
    const compaction_list *l = s->list;
    size_t bytes = s->from->objects->all.row_bytes;
    size_t to = (size_t)s->n_chunks * l->chunk;
    size_t slot = (size_t)(s->n_chunks % l->n_slots) * l->chunk;
    bool ok = timeline_write_at(s->times, "send objects", &s->view->own, to * bytes,
                                (const char *)l->objects.bytes + slot * bytes, n * bytes, err) &&
              timeline_flush(s->times, err);
    s->travels[s->n_chunks++] = timeline_last_event(s->times);
    return ok;
}

static bool send_ids(sending *s, uint32_t from, uint32_t to, duet_error *err)
{
    size_t at = from * sizeof(uint32_t);
    return timeline_write_at(s->times, "send objects", &s->view->ids, at,
                             (const char *)s->list->ids.bytes + at, (to - from) * sizeof(uint32_t),
                             err);
}

// A chunk that has travelled makes space for another.
static void free_slots(sending *s)
{
    uint32_t n = atomic_load_explicit(&s->list->sent, memory_order_relaxed);
    if (n < s->n_chunks && timeline_is_over(s->times, s->travels[n]))
        atomic_store_explicit(&s->list->sent, n + 1, memory_order_release);
}

static bool is_full(compaction_list *l, uint32_t chunk)
{
    return chunk < COMPACTION_CHUNKS &&
           atomic_load_explicit(&l->filled[chunk], memory_order_acquire) == l->chunk;
}

static bool send_full_chunk(sending *s, duet_error *err)
{
    const uint32_t chunk = s->list->chunk;
    return send_chunk(s, chunk, err) &&
           (s->n_chunks % IDS_EVERY > 0 ||
            send_ids(s, (s->n_chunks - IDS_EVERY) * chunk, s->n_chunks * chunk, err));
}

// Sends whole chunks until everything is found, and now and then the ids of some.
static bool send_while_finding(sending *s, duet_error *err)
{
    bool done = false;
    while (!done) {
        done = atomic_load_explicit(&s->from->done, memory_order_acquire) == s->from->n_blocks;
        free_slots(s);
        if (is_full(s->list, s->n_chunks)) {
            if (!send_full_chunk(s, err))
                return false;
        } else if (!done) {
            sched_yield();
        }
    }
    return true;
}

// Sends what was found behind the whole chunks.
static bool send_rest(sending *s, duet_error *err)
{
    const uint32_t chunk = s->list->chunk, n = s->view->n;
    const uint32_t with_ids = s->n_chunks / IDS_EVERY * IDS_EVERY * chunk;
    bool ok = true;
    for (uint32_t sent = s->n_chunks * chunk; ok && sent < n; sent += chunk)
        ok = send_chunk(s, n - sent < chunk ? n - sent : chunk, err);
    return ok && send_ids(s, with_ids, n, err);
}

static bool send_list(sending *s, bool *placed, duet_error *err)
{
    uint64_t begun = clock_steady_ns();
    if (!send_while_finding(s, err))
        return false;
    timeline_add_host(s->times, "pack", clock_ms_since(begun));
    s->view->n = atomic_load_explicit(&s->list->taken, memory_order_relaxed);
    *placed = !atomic_load(&s->from->cancelled) && s->view->n <= s->list->capacity;
    return *placed ? send_rest(s, err) : timeline_finish(s->times, err);
}

bool view_update_list(device_view *v, timeline *t, compaction *c, int side, uint64_t generation,
                      const selection *wanted, duet_error *err)
{
    sending s = {.view = v, .times = t, .from = c, .list = &c->lists[side]};
    const size_t capacity = s.list->capacity;
    bool placed = false;
    assert(wanted->kind == SELECT_LIST && !v->bound.mem);
    view_drop_chunks(v, t);
    if (view_has(v, generation, wanted))
        return true;
    v->generation = 0;
    if (!buffer_reserve(&v->own, t->device, capacity * c->objects->all.row_bytes, err) ||
        !buffer_reserve(&v->ids, t->device, capacity * sizeof(uint32_t), err) ||
        !send_list(&s, &placed, err))
        return false;
    v->generation = placed ? generation : 0;
    v->there = *wanted;
    return true;
}

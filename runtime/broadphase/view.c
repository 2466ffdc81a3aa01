// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/broadphase/view.h"

#include "base/clock.h"
#include "runtime/broadphase/compaction.h"

#include <assert.h>
#include <sched.h>

// ---------------------------------------------------------------- selections

selection select_all(uint32_t n)
{
    return (selection){.kind = SELECT_ALL, .n_ranges = 1, .ranges = {{0, n}}};
}

uint32_t selection_count(const selection *s)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->n_ranges; ++i)
        n += s->ranges[i].to - s->ranges[i].from;
    return n;
}

// The next rows from `from` on that are wanted and not there; an empty range if none are.
static row_span next_missing(const selection *there, const selection *wanted, uint32_t from)
{
    for (uint32_t i = 0; i < wanted->n_ranges; ++i) {
        row_span m = wanted->ranges[i];
        m.from = m.from > from ? m.from : from;
        for (uint32_t k = 0; k < there->n_ranges && m.from < m.to; ++k) {
            const row_span *has = &there->ranges[k];
            if (has->from <= m.from && m.from < has->to)
                m.from = has->to;
            else if (m.from < has->from && has->from < m.to)
                m.to = has->from;
        }
        if (m.from < m.to)
            return m;
    }
    return (row_span){0, 0};
}

// ---------------------------------------------------------------- views

void view_bind(device_view *v, const buffer *memory)
{
    v->bound = memory ? *memory : (buffer){0};
}

void view_forget(device_view *v)
{
    v->generation = 0;
    v->n_chunks = 0;
}

bool view_has(const device_view *v, uint64_t generation, const selection *wanted)
{
    if (v->bound.mem)
        return true;
    if (v->generation != generation || generation == 0)
        return false;
    bool lists = v->there.kind == SELECT_LIST, list = wanted->kind == SELECT_LIST;
    return lists && list
               ? v->there.key_from == wanted->key_from && v->there.key_to == wanted->key_to
               : !lists && !list && next_missing(&v->there, wanted, 0).to == 0;
}

bool view_is_prefetched(const device_view *v)
{
    return v->n_chunks > 0 && v->there.kind == SELECT_RANGES;
}

// Waits for what was prefetched, and forgets the chunks of the last step.
static void drop_chunks(device_view *v, timeline *t)
{
    if (view_is_prefetched(v))
        timeline_clear(t);
    v->n_chunks = 0;
}

static void assert_invariants(const device_view *v)
{
    const uint32_t sent_to = v->n_chunks > 0 ? v->chunks[v->n_chunks - 1].to : 0;
    assert(v->n_chunks <= sizeof v->chunks / sizeof v->chunks[0]);
    assert(v->n_chunks == 0 || (v->there.kind != SELECT_LIST && v->there.n_ranges == 1 &&
                                v->there.ranges[0].to == sent_to));
    assert(v->there.n_ranges <= SELECTION_RANGES);
    assert(!v->own.host || v->generation == 0 || v->there.kind == SELECT_ALL);
    (void)sent_to;
    (void)v;
}

// ---------------------------------------------------------------- sending

static bool send_missing(device_view *v, timeline *t, const host_array *from,
                         const selection *there, const selection *wanted, duet_error *err)
{
    bool ok = true;
    row_span rows = next_missing(there, wanted, 0);
    for (; ok && rows.from < rows.to; rows = next_missing(there, wanted, rows.to)) {
        size_t at = rows.from * from->row_bytes;
        ok = timeline_write_at(t, "send objects", &v->own, at, (const char *)from->rows + at,
                               (rows.to - rows.from) * from->row_bytes, err);
    }
    return ok;
}

// All chunks are on their way at once, beside the kernels.
static bool send_chunks(device_view *v, timeline *t, const host_array *from, uint32_t chunk,
                        duet_error *err)
{
    uint32_t at = v->n_chunks > 0 ? v->chunks[v->n_chunks - 1].to : 0;
    for (; at < from->n; at = v->chunks[v->n_chunks - 1].to) {
        uint32_t n = from->n - at < chunk ? from->n - at : chunk;
        size_t first = at * from->row_bytes;
        if (!timeline_write_beside(t, "send objects", &v->own, first,
                                   (const char *)from->rows + first, n * from->row_bytes, err))
            return false;
        v->chunks[v->n_chunks++] = (view_chunk){.to = at + n, .sent = timeline_last_event(t)};
    }
    return true;
}

static bool send_wanted(device_view *v, timeline *t, const host_array *from, const selection *there,
                        const selection *wanted, uint32_t chunk, duet_error *err)
{
    if (v->own.host)
        return timeline_write(t, "send objects", &v->own, from->rows, from->n * from->row_bytes,
                              err);
    return chunk > 0 ? send_chunks(v, t, from, chunk, err)
                     : send_missing(v, t, from, there, wanted, err);
}

bool view_continues(const device_view *v, const host_array *from, const selection *wanted)
{
    return view_is_prefetched(v) && v->generation == from->generation &&
           wanted->kind == SELECT_ALL && !v->bound.mem && v->own.bytes >= from->n * from->row_bytes;
}

bool view_update(device_view *v, timeline *t, const host_array *from, const selection *wanted,
                 uint32_t chunk, duet_error *err)
{
    const selection all = select_all(from->n), none = {.kind = SELECT_ALL};
    const bool continues = view_continues(v, from, wanted);
    const buffer before = v->own;
    assert(wanted->kind != SELECT_LIST);
    if (!continues)
        drop_chunks(v, t);
    v->n = from->n;
    if (v->bound.mem)
        return true;
    if (!buffer_hold(&v->own, t->device, (void *)from->rows, from->n * from->row_bytes, err))
        return false;
    if (v->own.mem != before.mem || v->own.bytes != before.bytes || v->own.host != before.host)
        v->generation = 0;
    const selection *sent = v->own.host ? &all : wanted;
    if (!continues && view_has(v, from->generation, sent))
        return true;
    const bool has_rows = v->generation == from->generation && v->there.kind != SELECT_LIST;
    const selection there = has_rows ? v->there : none;
    v->generation = 0;
    if (!send_wanted(v, t, from, &there, sent, chunk, err))
        return false;
    v->generation = from->generation;
    v->there = *sent;
    assert_invariants(v);
    return true;
}

// ---------------------------------------------------------------- a list

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
    drop_chunks(v, t);
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

// SPDX-License-Identifier: MIT
#include "runtime/broadphase/view.h"

#include <assert.h>
#include <string.h>

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

void view_drop_chunks(device_view *v, timeline *t)
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
        view_drop_chunks(v, t);
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

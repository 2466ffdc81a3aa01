// SPDX-License-Identifier: MIT
#include "runtime/broadphase/view.h"

#include <assert.h>
#include <string.h>

// ---------------------------------------------------------------- selections

selection select_all(uint32_t n)
{
    return (selection){.kind = SELECT_ALL, .n_ranges = 1, .ranges = {{0, n}}};
}

selection select_first(uint32_t n)
{
    return (selection){.kind = SELECT_RANGES, .n_ranges = 1, .ranges = {{0, n}}};
}

uint32_t selection_count(const selection *s)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->n_ranges; ++i)
        n += s->ranges[i].to - s->ranges[i].from;
    return n;
}

// The first rows of a range that are missing; an empty range if none is.
static row_span first_missing(const selection *there, row_span wanted)
{
    for (uint32_t i = 0; i < there->n_ranges && wanted.from < wanted.to; ++i) {
        const row_span *has = &there->ranges[i];
        if (has->to <= wanted.from)
            continue;
        if (has->from > wanted.from) {
            wanted.to = has->from < wanted.to ? has->from : wanted.to;
            break;
        }
        wanted.from = has->to < wanted.to ? has->to : wanted.to;
    }
    return wanted;
}

static bool has_ranges(const selection *there, const selection *wanted)
{
    bool has = true;
    for (uint32_t i = 0; has && i < wanted->n_ranges; ++i) {
        row_span missing = first_missing(there, wanted->ranges[i]);
        has = missing.from == missing.to;
    }
    return has;
}

// ---------------------------------------------------------------- views

void view_release(device_view *v)
{
    buffer_release(&v->own);
    buffer_release(&v->ids);
}

void view_bind(device_view *v, const buffer *memory)
{
    v->bound = memory ? *memory : (buffer){0};
}

buffer view_buffer(const device_view *v)
{
    return v->bound.mem ? v->bound : v->own;
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
    return lists && list ? memcmp(&v->there.slab, &wanted->slab, sizeof wanted->slab) == 0
                         : !lists && !list && has_ranges(&v->there, wanted);
}

bool view_is_prefetched(const device_view *v, uint64_t generation)
{
    return v->n_chunks > 0 && v->there.kind == SELECT_RANGES && v->generation == generation;
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

static bool send_rows(device_view *v, timeline *t, const host_array *from, row_span rows,
                      duet_error *err)
{
    size_t at = rows.from * from->row_bytes;
    return timeline_write_at(t, "send objects", &v->own, at, (const char *)from->rows + at,
                             (rows.to - rows.from) * from->row_bytes, err);
}

static bool send_missing(device_view *v, timeline *t, const host_array *from,
                         const selection *there, const selection *wanted, duet_error *err)
{
    for (uint32_t i = 0; i < wanted->n_ranges; ++i) {
        row_span rest = wanted->ranges[i];
        while (rest.from < rest.to) {
            row_span missing = first_missing(there, rest);
            if (missing.from < missing.to && !send_rows(v, t, from, missing, err))
                return false;
            rest.from = missing.to;
        }
    }
    return true;
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
    return view_is_prefetched(v, from->generation) && wanted->kind == SELECT_ALL && !v->bound.mem &&
           v->own.bytes >= from->n * from->row_bytes;
}

bool view_update(device_view *v, timeline *t, const host_array *from, const selection *wanted,
                 uint32_t chunk, duet_error *err)
{
    const selection all = select_all(from->n), none = {.kind = SELECT_ALL};
    const bool continues = view_continues(v, from, wanted);
    const cl_mem before = v->own.mem;
    assert(wanted->kind != SELECT_LIST);
    if (!continues)
        v->n_chunks = 0;
    v->n = from->n;
    if (v->bound.mem)
        return true;
    if (!buffer_hold(&v->own, t->device, (void *)from->rows, from->n * from->row_bytes, err))
        return false;
    if (v->own.mem != before)
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

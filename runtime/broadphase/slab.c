// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/broadphase/slab.h"

#include "base/clock.h"
#include "base/error.h"

#include <assert.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- where the grid is cut

// What an object costs on the way into the grid, in tests.
static const double object_cost = 8.0;

static bool count_objects(split *s, const part_task *task, duet_error *err)
{
    uint32_t n_rows = task->grid.n_cells / (uint32_t)task->grid.levels[0].cells.s[0];
    uint32_t *rows = calloc(n_rows, sizeof *rows);
    if (!rows)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory to count %u rows of cells",
                         n_rows);
    for (uint32_t first = 0, n; first < task->objects.n; first += n) {
        uint32_t of[GRID_BLOCK], left = task->objects.n - first;
        n = left < GRID_BLOCK ? left : GRID_BLOCK;
        grid_cell_rows(of, &task->grid, &task->objects, first, n);
        for (uint32_t k = 0; k < n; ++k)
            ++rows[of[k]];
    }
    free(s->cell_rows);
    *s = (split){.cell_rows = rows, .n_rows = n_rows};
    return true;
}

void split_free(split *s)
{
    free(s->cell_rows);
    *s = (split){0};
}

// Every object meets half the neighbourhood of its cell.
static double work_of(uint32_t objects, const part_task *task)
{
    double neighbourhood = task->objects.dims == 3 ? 13.5 : 4.5;
    double a_cell = (double)objects / task->grid.levels[0].cells.s[0];
    return objects * (object_cost + neighbourhood * a_cell);
}

static uint32_t sum_rows(const split *s, uint32_t from, uint32_t to)
{
    uint64_t n = 0;
    for (uint32_t r = from; r < to; ++r)
        n += s->cell_rows[r];
    return (uint32_t)n;
}

// The rows before the cut.
static uint32_t find_cut(const split *s, const part_task *task, uint32_t share)
{
    double total = 0.0;
    for (uint32_t r = 0; r < s->n_rows; ++r)
        total += work_of(s->cell_rows[r], task);
    double wanted = total * share / DUET_SHARE_ONE;
    double before = 0.0;
    uint32_t cut = 0;
    while (cut < s->n_rows && before + 0.5 * work_of(s->cell_rows[cut], task) < wanted)
        before += work_of(s->cell_rows[cut++], task);
    return share == DUET_SHARE_ONE ? s->n_rows : cut;
}

// Objects move between counts, so there is space for some more.
static uint32_t with_reserve(uint32_t n, uint32_t all)
{
    uint64_t capacity = (uint64_t)n + n / 16 + 256;
    return capacity < all ? (uint32_t)capacity : all;
}

static part_range slab_of(const split *s, const part_task *task, uint32_t from, uint32_t to,
                          uint32_t ghost_to)
{
    if (from == to)
        return (part_range){0};
    uint32_t nx = (uint32_t)task->grid.levels[0].cells.s[0];
    uint32_t counted = sum_rows(s, from, to);
    uint32_t homes = with_reserve(counted, task->objects.n);
    uint32_t ghosts = with_reserve(sum_rows(s, to, ghost_to), task->objects.n);
    uint64_t both = (uint64_t)homes + ghosts;
    return (part_range){
        .key_from = from * nx,
        .home_to = to * nx,
        .key_to = ghost_to * nx,
        .last = UINT32_MAX,
        .expected = both < task->objects.n ? (uint32_t)both : task->objects.n,
        .homes = counted,
        .expected_homes = homes,
        .expected_ghosts = ghosts,
    };
}

static void cut_rows(const split *s, const part_task *task, uint32_t share, part_range ranges[2])
{
    uint32_t cut = find_cut(s, task, share);
    uint32_t layer = task->objects.dims == 3 ? (uint32_t)task->grid.levels[0].cells.s[1] : 0;
    uint64_t ahead = (uint64_t)cut + layer + 1;
    uint32_t ghost_to = ahead < s->n_rows ? (uint32_t)ahead : s->n_rows;
    ranges[0] = slab_of(s, task, 0, cut, ghost_to);
    ranges[1] = slab_of(s, task, cut, s->n_rows, s->n_rows);
}

bool split_cut(split *s, const part_task *task, uint32_t share, part_range ranges[2],
               duet_error *err)
{
    if (s->stale && !count_objects(s, task, err))
        return false;
    if (!s->last.known || s->last.share != share || s->last.n != task->objects.n) {
        cut_rows(s, task, share, s->last.ranges);
        s->last.known = true;
        s->last.share = share;
        s->last.n = task->objects.n;
    }
    memcpy(ranges, s->last.ranges, sizeof s->last.ranges);
    return true;
}

// ---------------------------------------------------------------- packing

// Objects that a thread takes at once.
enum { BLOCK = GRID_BLOCK };

// Of 1.3 MB: it travels for 24 microseconds, a launch takes some two.
enum { LEAST_CHUNK = 32 * BLOCK };

// Chunks under way at a time: one travels, one waits to, the others fill.
enum { SLOTS = 6 };

// More threads only wait for the same memory.
enum { MOST_THREADS = 30 };

// Packing must keep one object in so many from a device.
enum { LEAST_LEFT_OUT = 16 };

void pack_open(pack *p)
{
    p->least_chunk = LEAST_CHUNK;
}

static uint32_t divide_up(uint32_t n, uint32_t by)
{
    return n / by + (n % by > 0);
}

static void begin_stream(pack_stream *s, uint32_t capacity, uint32_t least_chunk,
                         uint32_t most_slots)
{
    s->capacity = capacity;
    s->chunk = divide_up(capacity, PACK_CHUNKS);
    s->chunk = s->chunk < least_chunk ? least_chunk : s->chunk;
    s->n_slots = divide_up(capacity, s->chunk);
    s->n_slots = s->n_slots < most_slots ? s->n_slots : most_slots;
    atomic_init(&s->taken, 0);
    atomic_init(&s->sent, 0);
    for (int i = 0; i < PACK_CHUNKS; ++i)
        atomic_init(&s->filled[i], 0);
}

void pack_close(pack *p)
{
    thread_pool_close(p->threads);
    for (int side = 0; side < 2; ++side) {
        pack_stream *streams[] = {&p->slabs[side].homes, &p->slabs[side].ghosts};
        for (int i = 0; i < 2; ++i) {
            host_block_release(&streams[i]->objects);
            host_block_release(&streams[i]->names);
        }
    }
}

// ---------------------------------------------------------------- gathering

// Objects of rows [from, to). Without a branch, for half of them are.
static uint32_t pick(uint16_t picked[BLOCK], const uint32_t *rows, uint32_t n, uint32_t from,
                     uint32_t to)
{
    uint32_t n_picked = 0;
    for (uint32_t k = 0; k < n; ++k) {
        picked[n_picked] = (uint16_t)k;
        n_picked += rows[k] - from < to - from;
    }
    return n_picked;
}

static void copy_objects(const pack_stream *s, const part_task *task, uint32_t to, uint32_t first,
                         const uint16_t *picked, uint32_t n)
{
    size_t at = to % (s->n_slots * s->chunk);
    if (task->objects.shape == DUET_SHAPE_POSES) {
        duet_pose *out = (duet_pose *)s->objects.bytes + at;
        const duet_pose *in = (const duet_pose *)task->objects.array + first;
        for (uint32_t i = 0; i < n; ++i)
            out[i] = in[picked[i]];
    } else {
        duet_bounds *out = (duet_bounds *)s->objects.bytes + at;
        const duet_bounds *in = (const duet_bounds *)task->objects.array + first;
        for (uint32_t i = 0; i < n; ++i)
            out[i] = in[picked[i]];
    }
    uint32_t *names = (uint32_t *)s->names.bytes + to;
    for (uint32_t i = 0; i < n; ++i)
        names[i] = first + picked[i];
}

static bool is_abandoned(pack *p)
{
    return atomic_load(&p->abandoned);
}

// False where the slot will not be free any more. Who waits for a chunk has
// written all that it took of those before it, so that they can be sent.
static bool wait_for_slot(pack *p, pack_stream *s, uint32_t chunk)
{
    while (chunk >= atomic_load_explicit(&s->sent, memory_order_acquire) + s->n_slots) {
        if (is_abandoned(p))
            return false;
        sched_yield();
    }
    return true;
}

static void gather(pack *p, pack_stream *s, uint32_t first, const uint16_t *picked, uint32_t n)
{
    uint32_t to = atomic_fetch_add_explicit(&s->taken, n, memory_order_relaxed);
    if ((uint64_t)to + n > s->capacity)
        return;
    while (n > 0) {
        uint32_t chunk = to / s->chunk;
        uint32_t left = s->chunk - to % s->chunk;
        uint32_t here = n < left ? n : left;
        if (!wait_for_slot(p, s, chunk))
            return;
        copy_objects(s, &p->task, to, first, picked, here);
        atomic_fetch_add_explicit(&s->filled[chunk], here, memory_order_release);
        to += here;
        picked += here;
        n -= here;
    }
}

static void pack_block(pack *p, uint32_t block)
{
    uint32_t rows[BLOCK];
    uint16_t picked[BLOCK];
    uint32_t first = block * BLOCK;
    uint32_t n = p->task.objects.n - first < BLOCK ? p->task.objects.n - first : BLOCK;
    grid_cell_rows(rows, &p->task.grid, &p->task.objects, first, n);
    for (int side = 0; side < 2; ++side) {
        pack_slab *slab = &p->slabs[side];
        if (!slab->wanted)
            continue;
        uint32_t n_homes = pick(picked, rows, n, slab->row_from, slab->row_home_to);
        gather(p, &slab->homes, first, picked, n_homes);
        uint32_t n_ghosts = pick(picked, rows, n, slab->row_home_to, slab->row_to);
        gather(p, &slab->ghosts, first, picked, n_ghosts);
    }
    atomic_fetch_add_explicit(&p->done, 1, memory_order_release);
}

static bool is_done(pack *p)
{
    return atomic_load_explicit(&p->done, memory_order_acquire) == p->n_blocks;
}

static bool is_full(pack_stream *s, uint32_t chunk)
{
    return chunk < PACK_CHUNKS &&
           atomic_load_explicit(&s->filled[chunk], memory_order_acquire) == s->chunk;
}

// Ghosts are sent last, behind the homes, and all have their place until then.
static void begin_pack(pack *p, const part_task *task, const part_range ranges[2],
                       const bool wanted[2])
{
    uint32_t nx = (uint32_t)task->grid.levels[0].cells.s[0];
    p->task = *task;
    p->n_blocks = (uint32_t)(((uint64_t)task->objects.n + BLOCK - 1) / BLOCK);
    atomic_init(&p->begun, 0);
    atomic_init(&p->done, 0);
    atomic_init(&p->abandoned, false);
    for (int side = 0; side < 2; ++side) {
        pack_slab *slab = &p->slabs[side];
        const part_range *range = &ranges[side];
        slab->wanted = wanted[side];
        slab->row_from = range->key_from / nx;
        slab->row_home_to = range->home_to / nx;
        slab->row_to = range->key_to / nx;
        if (!slab->wanted)
            continue;
        begin_stream(&slab->homes, range->expected_homes, p->least_chunk, SLOTS);
        begin_stream(&slab->ghosts, range->expected_ghosts, p->least_chunk, PACK_CHUNKS);
    }
}

static bool reserve_slab(pack_slab *slab, size_t bytes, const device *to, duet_error *err)
{
    pack_stream *streams[] = {&slab->homes, &slab->ghosts};
    bool ok = true;
    for (int i = 0; ok && slab->wanted && i < 2; ++i) {
        pack_stream *s = streams[i];
        ok = host_block_reserve(&s->objects, to, 1, (size_t)s->n_slots * s->chunk * bytes, err) &&
             host_block_reserve(&s->names, to, 1, s->capacity * sizeof(uint32_t), err);
    }
    return ok;
}

static void pack_blocks(void *arg)
{
    pack *p = arg;
    uint32_t block = 0;
    while ((block = atomic_fetch_add_explicit(&p->begun, 1, memory_order_relaxed)) < p->n_blocks)
        pack_block(p, block);
}

// The part still has what it would be sent.
static bool has_slab(const part *p, const part_task *task, const part_range *range)
{
    return p->packed.objects_version == task->objects_version &&
           p->packed.grid_version == task->grid_version && p->packed.key_from == range->key_from &&
           p->packed.key_to == range->key_to;
}

bool pack_pays(const part_task *task, const part_range ranges[2], int side, const part *p,
               const variant *v)
{
    uint32_t n = task->objects.n;
    bool plain =
        task->objects.shape == DUET_SHAPE_POSES || task->objects.shape == DUET_SHAPE_BOUNDS;
    return plain && task->objects.origin == 0.0f && !task->objects.sizes &&
           !p->device->info.host_memory && ranges[0].last > 0 && ranges[1].last > 0 &&
           ranges[side].expected <= n - n / LEAST_LEFT_OUT && v->search == SEARCH_GPU &&
           v->send == SEND_PACKED;
}

bool pack_start(pack *p, const part parts[2], const part_task *task, const part_range ranges[2],
                const bool packed[2], thread_pool **packers, duet_error *err)
{
    bool wanted[2];
    for (int side = 0; side < 2; ++side)
        wanted[side] = packed[side] && !has_slab(&parts[side], task, &ranges[side]);
    begin_pack(p, task, ranges, wanted);
    for (int side = 0; side < 2; ++side)
        if (!reserve_slab(&p->slabs[side], task->objects.row_bytes, parts[side].device, err))
            return false;
    *packers = NULL;
    if (!wanted[0] && !wanted[1])
        return true;
    if (!p->threads && !(p->threads = thread_pool_open(thread_pool_spare(MOST_THREADS), err)))
        return false;
    thread_pool_start(p->threads, pack_blocks, p);
    *packers = p->threads;
    return true;
}

void pack_abandon(pack *p)
{
    atomic_store(&p->abandoned, true);
}

// ---------------------------------------------------------------- sending

// Sending one device the objects of its slab while they are being packed.

// Names follow their objects after so many chunks.
enum { NAMES_EVERY = 8 };

// A timeline that is full waits and forgets its events: it must not be.
static_assert(PACK_CHUNKS + PACK_CHUNKS / NAMES_EVERY + 16 <= TIMELINE_EVENTS, "events");

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
    size_t bytes = from->task.objects.row_bytes;
    uint32_t chunk = 0;
    bool done = false;
    bool ok = true;
    while (ok && !done) {
        done = is_done(from);
        free_slots(&p->times, homes, travels, chunk);
        if (is_full(homes, chunk)) {
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
    timeline_add_host(&p->times, "pack", clock_ms_since(begun));
    uint32_t n_homes = taken(&slab->homes);
    uint32_t n_ghosts = taken(&slab->ghosts);
    *placed =
        !is_abandoned(from) && n_homes <= slab->homes.capacity && n_ghosts <= slab->ghosts.capacity;
    p->packed.n = n_homes + n_ghosts;
    p->packed.n_homes = n_homes;
    return *placed ? send_rest(p, slab, n_chunks, from->task.objects.row_bytes, err)
                   : timeline_finish(&p->times, err);
}

bool part_receive_slab(part *p, pack *from, int side, part_task *task, const part_range *range,
                       bool *placed, duet_error *err)
{
    pack_slab *slab = &from->slabs[side];
    *placed = true;
    if (slab->wanted) {
        size_t capacity = (size_t)slab->homes.capacity + slab->ghosts.capacity;
        p->objects_version = p->packed.objects_version = p->stretched.objects_version = 0;
        if (!buffer_reserve(&p->objects, p->device, capacity * task->objects.row_bytes, err) ||
            !buffer_reserve(&p->names, p->device, capacity * sizeof(uint32_t), err) ||
            !send_slab(p, from, slab, placed, err))
            return false;
        p->packed.objects_version = *placed ? task->objects_version : 0;
        p->packed.grid_version = task->grid_version;
        p->packed.key_from = range->key_from;
        p->packed.key_to = range->key_to;
    }
    task->objects.n = p->packed.n;
    return true;
}

// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/broadphase/compaction.h"

#include <sched.h>

// Objects that a thread takes at once.
enum { BLOCK = GRID_BLOCK };

// A chunk is at least 1.3 MB: it travels for 24 microseconds, a launch takes some two.
enum { LEAST_CHUNK = 32 * BLOCK };

// Chunks under way at a time: one travels, one waits to, the others fill.
enum { SLOTS = 6 };

// More threads only wait for the same memory.
enum { MOST_THREADS = 30 };

// A list must leave out one object in so many.
enum { LEAST_LEFT_OUT = 16 };

void compaction_open(compaction *c)
{
    c->least_chunk = LEAST_CHUNK;
}

void compaction_close(compaction *c)
{
    thread_pool_close(c->threads);
    for (int side = 0; side < 2; ++side) {
        host_block_release(&c->lists[side].objects);
        host_block_release(&c->lists[side].ids);
    }
}

bool compaction_pays(const part_range *slab, uint32_t n)
{
    return slab->expected <= n - n / LEAST_LEFT_OUT;
}

void compaction_cancel(compaction *c)
{
    atomic_store(&c->cancelled, true);
}

// ---------------------------------------------------------------- threads

// Lists the objects of rows [from, to). Branch-free, because about half of the objects are in them
// and a branch would be mispredicted.
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

static void copy_objects(const compaction_list *s, const grid_objects *objects, uint32_t to,
                         uint32_t first, const uint16_t *picked, uint32_t n)
{
    size_t at = to % (s->n_slots * s->chunk);
    if (objects->shape == DUET_SHAPE_POSES) {
        duet_pose *out = (duet_pose *)s->objects.bytes + at;
        const duet_pose *in = (const duet_pose *)objects->all.rows + first;
        for (uint32_t i = 0; i < n; ++i)
            out[i] = in[picked[i]];
    } else {
        duet_bounds *out = (duet_bounds *)s->objects.bytes + at;
        const duet_bounds *in = (const duet_bounds *)objects->all.rows + first;
        for (uint32_t i = 0; i < n; ++i)
            out[i] = in[picked[i]];
    }
    uint32_t *ids = (uint32_t *)s->ids.bytes + to;
    for (uint32_t i = 0; i < n; ++i)
        ids[i] = first + picked[i];
}

// False if the slot will never be free. A thread that waits for a chunk has written all that it
// took of the chunks before it, so that they can be sent.
static bool wait_for_slot(compaction *c, compaction_list *s, uint32_t chunk)
{
    while (chunk >= atomic_load_explicit(&s->sent, memory_order_acquire) + s->n_slots) {
        if (atomic_load(&c->cancelled))
            return false;
        sched_yield();
    }
    return true;
}

static void append(compaction *c, compaction_list *s, uint32_t first, const uint16_t *picked,
                   uint32_t n)
{
    uint32_t to = atomic_fetch_add_explicit(&s->taken, n, memory_order_relaxed);
    if ((uint64_t)to + n > s->capacity)
        return;
    while (n > 0) {
        uint32_t chunk = to / s->chunk;
        uint32_t left = s->chunk - to % s->chunk;
        uint32_t here = n < left ? n : left;
        if (!wait_for_slot(c, s, chunk))
            return;
        copy_objects(s, c->objects, to, first, picked, here);
        atomic_fetch_add_explicit(&s->filled[chunk], here, memory_order_release);
        to += here;
        picked += here;
        n -= here;
    }
}

static void list_block(compaction *c, uint32_t block)
{
    uint32_t rows[BLOCK];
    uint16_t picked[BLOCK];
    uint32_t first = block * BLOCK;
    uint32_t n = c->objects->all.n - first < BLOCK ? c->objects->all.n - first : BLOCK;
    grid_cell_rows(rows, c->grid, c->objects, first, n);
    for (int side = 0; side < 2; ++side) {
        compaction_list *list = &c->lists[side];
        if (list->row_from < list->row_to)
            append(c, list, first, picked, pick(picked, rows, n, list->row_from, list->row_to));
    }
    atomic_fetch_add_explicit(&c->done, 1, memory_order_release);
}

static void list_blocks(void *arg, uint64_t first, uint64_t last)
{
    for (; first < last; ++first)
        list_block(arg, (uint32_t)first);
}

// ---------------------------------------------------------------- beginning

static uint32_t divide_up(uint32_t n, uint32_t by)
{
    return n / by + (n % by > 0);
}

static bool begin_list(compaction *c, compaction_list *l, const part_range *slab, const device *to,
                       duet_error *err)
{
    const uint32_t nx = (uint32_t)c->grid->levels[0].cells.s[0];
    l->row_from = l->row_to = 0;
    if (!slab)
        return true;
    l->row_from = slab->key_from / nx;
    l->row_to = slab->key_to / nx;
    l->capacity = slab->expected;
    l->chunk = divide_up(l->capacity, COMPACTION_CHUNKS);
    l->chunk = l->chunk < c->least_chunk ? c->least_chunk : l->chunk;
    l->n_slots = divide_up(l->capacity, l->chunk);
    l->n_slots = l->n_slots < SLOTS ? l->n_slots : SLOTS;
    atomic_init(&l->taken, 0);
    atomic_init(&l->sent, 0);
    for (int i = 0; i < COMPACTION_CHUNKS; ++i)
        atomic_init(&l->filled[i], 0);
    const size_t bytes = (size_t)l->n_slots * l->chunk * c->objects->all.row_bytes;
    return host_block_reserve(&l->objects, to, 1, bytes, err) &&
           host_block_reserve(&l->ids, to, 1, l->capacity * sizeof(uint32_t), err);
}

bool compaction_start(compaction *c, const grid_objects *objects, const grid *g,
                      const part_range *const slabs[2], const device *const devices[2],
                      thread_pool **threads, duet_error *err)
{
    c->objects = objects;
    c->grid = g;
    c->n_blocks = divide_up(objects->all.n, BLOCK);
    atomic_init(&c->done, 0);
    atomic_init(&c->cancelled, false);
    for (int side = 0; side < 2; ++side)
        if (!begin_list(c, &c->lists[side], slabs[side], devices[side], err))
            return false;
    *threads = NULL;
    if (!slabs[0] && !slabs[1])
        return true;
    if (!c->threads && !(c->threads = thread_pool_open(thread_pool_spare(MOST_THREADS), err)))
        return false;
    thread_pool_start(c->threads, list_blocks, c, c->n_blocks);
    *threads = c->threads;
    return true;
}

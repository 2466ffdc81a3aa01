// SPDX-License-Identifier: MIT
#include "runtime/broadphase/strays.h"

#include "base/error.h"

#include <sched.h>
#include <stdlib.h>
#include <string.h>

void strays_close(strays *s)
{
    free(s->wanted);
    *s = (strays){0};
}

// ---------------------------------------------------------------- looking at blocks

static bool is_known(const strays *s, const part_task *task, const part_range ranges[2])
{
    return s->objects_version == task->objects_version && s->grid_version == task->grid_version &&
           memcmp(s->ranges, ranges, sizeof s->ranges) == 0;
}

static bool reserve(strays *s, uint32_t n_blocks, duet_error *err)
{
    if (n_blocks <= s->capacity)
        return true;
    strays_close(s);
    s->wanted = malloc(n_blocks * sizeof *s->wanted);
    s->capacity = s->wanted ? n_blocks : 0;
    return s->wanted ||
           error_set(err, DUET_STATUS_NO_MEMORY, "no host memory to look for strays in %u blocks",
                     n_blocks);
}

// Where A's slab ends among objects that are in order.
static uint32_t cut_of(const part_range ranges[2], uint32_t n)
{
    uint64_t cut = ((uint64_t)ranges[0].homes + STRAY_BLOCK / 2) / STRAY_BLOCK * STRAY_BLOCK;
    return cut < n ? (uint32_t)cut : n;
}

bool strays_begin(strays *s, const part_task *task, const part_range ranges[2], duet_error *err)
{
    uint32_t n = task->objects.n;
    uint32_t n_blocks = n / STRAY_BLOCK + (n % STRAY_BLOCK > 0);
    if (is_known(s, task, ranges))
        return true;
    if (!reserve(s, n_blocks, err))
        return false;
    s->n_blocks = n_blocks;
    s->cut = cut_of(ranges, n);
    s->objects_version = task->objects_version;
    s->grid_version = task->grid_version;
    memcpy(s->ranges, ranges, sizeof s->ranges);
    s->grid = task->grid;
    s->objects = task->objects;
    atomic_store(&s->begun, 0);
    atomic_store(&s->done, 0);
    return true;
}

// The device whose own stretch has the block.
static int side_of(const strays *s, uint32_t block)
{
    return block * STRAY_BLOCK >= s->cut;
}

static uint32_t end_of(const strays *s, uint32_t block)
{
    uint32_t left = s->objects.n - block * STRAY_BLOCK;
    return block * STRAY_BLOCK + (left < STRAY_BLOCK ? left : STRAY_BLOCK);
}

static bool is_wanted(const strays *s, uint32_t block)
{
    uint32_t rows[STRAY_BLOCK];
    const part_range *other = &s->ranges[1 - side_of(s, block)];
    uint32_t along = (uint32_t)s->grid.levels[0].cells.s[0];
    uint32_t from = other->key_from / along, n_rows = other->key_to / along - from;
    uint32_t first = block * STRAY_BLOCK, n = end_of(s, block) - first;
    uint32_t n_there = 0;
    grid_find_cell_rows(rows, &s->grid, &s->objects, first, n);
    for (uint32_t k = 0; k < n; ++k)
        n_there += rows[k] - from < n_rows;
    return n_there > 0;
}

void strays_look(void *looked_for)
{
    strays *s = looked_for;
    uint32_t block;
    while ((block = atomic_fetch_add_explicit(&s->begun, 1, memory_order_relaxed)) < s->n_blocks) {
        s->wanted[block] = is_wanted(s, block);
        atomic_fetch_add_explicit(&s->done, 1, memory_order_release);
    }
    while (atomic_load_explicit(&s->done, memory_order_acquire) < s->n_blocks)
        sched_yield();
}

// ---------------------------------------------------------------- stretches

stretch strays_own(const strays *s, int side)
{
    return side == 0 ? (stretch){0, s->cut} : (stretch){s->cut, s->objects.n};
}

// A gap is left out where it pays for a launch: so large a part of the input.
enum { GAPS = STRETCHES - 3 };

// With those up to it from the stretch `first` on, unless the gap is large.
static void add_block(stretches *all, uint32_t first, const strays *s, uint32_t block)
{
    stretch *last = all->n > first ? &all->list[all->n - 1] : NULL;
    if (!last || block * STRAY_BLOCK - last->to > s->objects.n / GAPS)
        all->list[all->n++] = (stretch){block * STRAY_BLOCK, end_of(s, block)};
    else
        last->to = end_of(s, block);
}

stretches strays_taken(const strays *s, int side)
{
    stretches all = {.own = 0};
    if (side == 0)
        all.list[all.n++] = strays_own(s, side);
    uint32_t first = all.n;
    for (uint32_t block = 0; block < s->n_blocks; ++block)
        if (side_of(s, block) != side && s->wanted[block])
            add_block(&all, first, s, block);
    if (side == 1) {
        all.own = all.n;
        all.list[all.n++] = strays_own(s, side);
    }
    return all;
}

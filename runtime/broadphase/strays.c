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
    return s->wanted || error_set(err, DUET_STATUS_NO_MEMORY,
                                  "no host memory to look for strays in %u blocks", n_blocks);
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
    s->cut = cut_of(ranges, n);
    s->objects_version = task->objects_version;
    s->grid_version = task->grid_version;
    memcpy(s->ranges, ranges, sizeof s->ranges);
    s->grid = task->grid;
    s->objects = task->objects;
    uint32_t cut_block = s->cut / STRAY_BLOCK + (s->cut % STRAY_BLOCK > 0);
    for (int side = 0; side < 2; ++side) {
        atomic_store(&s->looked[side].next, side == 0 ? cut_block : 0);
        atomic_store(&s->looked[side].n_known, 0);
        s->looked[side].from_block = side == 0 ? cut_block : 0;
        s->looked[side].to_block = side == 0 ? n_blocks : cut_block;
        if (ranges[side].key_from == ranges[side].key_to) // an empty slab
            s->looked[side].to_block = s->looked[side].from_block;
    }
    return true;
}

static uint32_t end_of(const strays *s, uint32_t block)
{
    uint32_t left = s->objects.n - block * STRAY_BLOCK;
    return block * STRAY_BLOCK + (left < STRAY_BLOCK ? left : STRAY_BLOCK);
}

static bool is_wanted(const strays *s, int side, uint32_t block)
{
    const part_range *slab = &s->ranges[side];
    uint32_t along = (uint32_t)s->grid.levels[0].cells.s[0];
    uint32_t first = block * STRAY_BLOCK;
    return grid_any_in_rows(&s->grid, &s->objects, first, end_of(s, block) - first,
                            slab->key_from / along, slab->key_to / along);
}

void strays_look(strays *s, int side)
{
    uint32_t to = s->looked[side].to_block;
    for (;;) {
        uint32_t block = atomic_fetch_add_explicit(&s->looked[side].next, 1, memory_order_relaxed);
        if (block >= to)
            return;
        s->wanted[block] = is_wanted(s, side, block);
        atomic_fetch_add_explicit(&s->looked[side].n_known, 1, memory_order_release);
    }
}

void strays_look_for_both(void *looked_for)
{
    for (int side = 0; side < 2; ++side)
        strays_look(looked_for, side);
}

void strays_await(const strays *s, int side)
{
    uint32_t n = s->looked[side].to_block - s->looked[side].from_block;
    while (atomic_load_explicit(&s->looked[side].n_known, memory_order_acquire) < n)
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
    for (uint32_t b = s->looked[side].from_block; b < s->looked[side].to_block; ++b)
        if (s->wanted[b])
            add_block(&all, first, s, b);
    if (side == 1) {
        all.own = all.n;
        all.list[all.n++] = strays_own(s, side);
    }
    return all;
}

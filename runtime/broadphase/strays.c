// SPDX-License-Identifier: MIT
#include "runtime/broadphase/strays.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

void strays_close(strays *s)
{
    free(s->guessed);
    *s = (strays){0};
}

static uint32_t blocks_of(uint32_t n)
{
    return n / STRAY_BLOCK + (n % STRAY_BLOCK > 0);
}

// ---------------------------------------------------------------- stretches

// A gap is left out where it pays for a launch: so large a part of the input.
enum { GAPS = STRETCHES - 3 };

// With those up to it from the stretch `first` on, unless the gap is large.
static void add_block(stretches *all, uint32_t first, const strays *s, uint32_t block)
{
    uint32_t from = block * STRAY_BLOCK;
    uint32_t to = s->n - from < STRAY_BLOCK ? s->n : from + STRAY_BLOCK;
    stretch *last = all->n > first ? &all->list[all->n - 1] : NULL;
    if (!last || from - last->to > s->n / GAPS)
        all->list[all->n++] = (stretch){from, to};
    else
        last->to = to;
}

static stretches list_stretches(const strays *s, int side)
{
    stretch own = side == 0 ? (stretch){0, s->cut} : (stretch){s->cut, s->n};
    stretches all = {.own = 0};
    if (side == 0)
        all.list[all.n++] = own;
    uint32_t first = all.n;
    uint32_t from = side == 0 ? blocks_of(own.to) : 0;
    uint32_t to = side == 0 ? blocks_of(s->n) : blocks_of(own.from);
    for (uint32_t b = from; b < to; ++b)
        if (s->guessed[b])
            add_block(&all, first, s, b);
    if (side == 1) {
        all.own = all.n;
        all.list[all.n++] = own;
    }
    return all;
}

stretches strays_joined(const stretches *list)
{
    stretches joined = {.own = 0};
    for (uint32_t i = 0; i < list->n; ++i) {
        const stretch *s = &list->list[i];
        if (joined.n > 0 && joined.list[joined.n - 1].to == s->from)
            joined.list[joined.n - 1].to = s->to;
        else
            joined.list[joined.n++] = *s;
        if (i == list->own)
            joined.own = joined.n - 1;
    }
    return joined;
}

// What both take by a new guess.
static void list_intakes(strays *s)
{
    ++s->version;
    for (int side = 0; side < 2; ++side) {
        const part_range *other = &s->ranges[1 - side];
        part_intake *in = &s->intakes[side];
        in->sent = list_stretches(s, side);
        in->taken = strays_joined(&in->sent);
        in->strays_version = s->version;
        in->marked_from = other->key_from;
        in->marked_to = other->key_to;
    }
}

// ---------------------------------------------------------------- the first guess

static bool is_known(const strays *s, const part_task *task, const part_range ranges[2])
{
    return s->guessed && s->n == task->objects.n && s->grid_version == task->grid_version &&
           memcmp(s->ranges, ranges, sizeof s->ranges) == 0;
}

static bool reserve(strays *s, uint32_t n_blocks, duet_error *err)
{
    if (s->guessed && n_blocks <= s->capacity)
        return true;
    free(s->guessed);
    s->guessed = malloc(n_blocks * sizeof *s->guessed + 1);
    s->capacity = s->guessed ? n_blocks : 0;
    return s->guessed || error_set(err, DUET_STATUS_NO_MEMORY,
                                   "no host memory to look for strays in %u blocks", n_blocks);
}

static bool is_empty(const part_range *slab)
{
    return slab->key_from == slab->key_to;
}

// Where A's slab ends among objects that are in order, rounded down: A takes some of B's objects
// anyway, its ghosts, and B then takes none of A's. Beside an empty slab the other device has all.
static uint32_t cut_of(const part_range ranges[2], uint32_t n)
{
    if (is_empty(&ranges[0]) || is_empty(&ranges[1]))
        return is_empty(&ranges[0]) ? 0 : n;
    uint32_t cut = ranges[0].homes / STRAY_BLOCK * STRAY_BLOCK;
    return cut < n ? cut : n;
}

// A wants its ghosts, and the objects that the cut, rounded to blocks, gave to B.
static void guess_border(strays *s)
{
    const part_range *a = &s->ranges[0];
    uint64_t ghosts_to = (uint64_t)a->homes + a->expected_ghosts;
    bool both = !is_empty(a) && !is_empty(&s->ranges[1]);
    for (uint32_t b = 0; b < blocks_of(s->n); ++b) {
        uint64_t from = (uint64_t)b * STRAY_BLOCK;
        s->guessed[b] = both && from >= s->cut && from < ghosts_to;
    }
}

bool strays_begin(strays *s, const part_task *task, const part_range ranges[2], duet_error *err)
{
    if (is_known(s, task, ranges))
        return true;
    if (!reserve(s, blocks_of(task->objects.n), err))
        return false;
    s->n = task->objects.n;
    s->cut = cut_of(ranges, s->n);
    s->grid_version = task->grid_version;
    memcpy(s->ranges, ranges, sizeof s->ranges);
    s->margin = 0;
    guess_border(s);
    list_intakes(s);
    return true;
}

// ---------------------------------------------------------------- better ones

stray_marks strays_marks_of(const part *p)
{
    return (stray_marks){p->marks.host ? p->marks.host : p->marks_seen.bytes, p->stamp};
}

static bool is_wanted(const strays *s, const stray_marks marks[2], uint32_t block)
{
    const stray_marks *m = &marks[block * STRAY_BLOCK < s->cut ? 0 : 1];
    return m->blocks[block] == m->stamp;
}

// Of blocks [from, to), one device's own: those within the margin of one that is wanted. Returns
// whether the guess was another one.
static bool take_wanted(strays *s, const stray_marks marks[2], uint32_t from, uint32_t to)
{
    bool changed = false;
    uint32_t wanted = from; // the first that is, not too far before b
    for (uint32_t b = from; b < to; ++b) {
        while (wanted < to && (wanted + s->margin < b || !is_wanted(s, marks, wanted)))
            ++wanted;
        bool takes = wanted < to && wanted <= b + s->margin;
        changed |= s->guessed[b] != takes;
        s->guessed[b] = takes;
    }
    return changed;
}

// Objects that move reach the next blocks: once the guess was better than the first and misses
// again, it has a layer of cells more than was wanted. Far more than that is not kept.
bool strays_guessed_all(strays *s, const stray_marks marks[2])
{
    uint32_t n_blocks = blocks_of(s->n);
    uint32_t layer = blocks_of(s->ranges[0].expected_ghosts);
    uint32_t n_missed = 0, n_wanted = 0, n_guessed = 0;
    for (uint32_t b = 0; b < n_blocks; ++b) {
        bool wanted = is_wanted(s, marks, b);
        n_missed += wanted && !s->guessed[b];
        n_wanted += wanted;
        n_guessed += s->guessed[b];
    }
    if (n_missed > 0 || n_guessed > 2 * (n_wanted + layer)) {
        bool changed = take_wanted(s, marks, 0, blocks_of(s->cut));
        changed |= take_wanted(s, marks, blocks_of(s->cut), n_blocks);
        s->margin = layer;
        if (changed)
            list_intakes(s);
    }
    return n_missed == 0;
}

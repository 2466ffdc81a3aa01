// SPDX-License-Identifier: MIT
#include "runtime/broadphase/input_ranges.h"

#include "base/error.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

void input_ranges_close(input_ranges *r)
{
    free(r->guessed);
    *r = (input_ranges){0};
}

static uint32_t count_blocks(uint32_t n)
{
    return n / INPUT_BLOCK + (n % INPUT_BLOCK > 0);
}

// ---------------------------------------------------------------- selections

// A gap of this part of the input pays for the launch that leaves it out.
enum { GAPS = SELECTION_RANGES - 3 };

// Extends the last range to a block, unless the gap between them is large.
static void add_block(selection *s, const input_ranges *r, uint32_t block)
{
    uint32_t from = block * INPUT_BLOCK;
    uint32_t to = r->n - from < INPUT_BLOCK ? r->n : from + INPUT_BLOCK;
    row_span *last = s->n_ranges > 0 ? &s->ranges[s->n_ranges - 1] : NULL;
    if (!last || from - last->to > r->n / GAPS)
        s->ranges[s->n_ranges++] = (row_span){from, to};
    else
        last->to = to;
}

// The own range becomes the first or the last one, joined with the one that it touches.
static void add_own(selection *s, row_span own, int side)
{
    const uint32_t n = s->n_ranges, edge = side == 0 ? 0 : n - 1;
    const bool touches =
        n > 0 && (side == 0 ? s->ranges[0].from == own.to : s->ranges[n - 1].to == own.from);
    if (touches && side == 0)
        s->ranges[edge].from = own.from;
    if (touches && side == 1)
        s->ranges[edge].to = own.to;
    if (!touches && side == 0)
        memmove(s->ranges + 1, s->ranges, n * sizeof *s->ranges);
    if (!touches)
        s->ranges[side == 0 ? 0 : n] = own;
    s->n_ranges += !touches;
    s->own = side == 0 ? 0 : s->n_ranges - 1;
}

static selection select_ranges(const input_ranges *r, int side)
{
    const row_span own = side == 0 ? (row_span){0, r->cut} : (row_span){r->cut, r->n};
    selection s = {.kind = SELECT_RANGES};
    uint32_t from = side == 0 ? count_blocks(own.to) : 0;
    uint32_t to = side == 0 ? count_blocks(r->n) : count_blocks(own.from);
    for (uint32_t b = from; b < to; ++b)
        if (r->guessed[b])
            add_block(&s, r, b);
    add_own(&s, own, side);
    assert(s.n_ranges <= SELECTION_RANGES);
    return s;
}

static void select_both(input_ranges *r)
{
    for (int side = 0; side < 2; ++side)
        r->selections[side] = select_ranges(r, side);
}

// ---------------------------------------------------------------- the first guess

static bool is_known(const input_ranges *r, uint32_t n, const part_range slabs[2])
{
    return r->guessed && r->n == n && memcmp(r->slabs, slabs, sizeof r->slabs) == 0;
}

static bool reserve(input_ranges *r, uint32_t n_blocks, duet_error *err)
{
    if (r->guessed && n_blocks <= r->capacity)
        return true;
    free(r->guessed);
    r->guessed = malloc(n_blocks * sizeof *r->guessed + 1);
    r->capacity = r->guessed ? n_blocks : 0;
    return r->guessed || no_memory(err, "the ranges of %u blocks", n_blocks);
}

static bool is_empty(const part_range *slab)
{
    return slab->key_from == slab->key_to;
}

// The end of A's slab among objects that are in order, rounded down: A reads some of B's objects
// anyway, its ghosts, and B then reads none of A's. Beside an empty slab the other device has all.
static uint32_t cut_of(const part_range slabs[2], uint32_t n)
{
    if (is_empty(&slabs[0]) || is_empty(&slabs[1]))
        return is_empty(&slabs[0]) ? 0 : n;
    uint32_t cut = slabs[0].homes / INPUT_BLOCK * INPUT_BLOCK;
    return cut < n ? cut : n;
}

// A needs its ghosts, and the objects that the cut, rounded to blocks, gave to B.
static void guess_border(input_ranges *r)
{
    const part_range *a = &r->slabs[0];
    uint64_t ghosts_to = (uint64_t)a->homes + a->expected_ghosts;
    bool both = !is_empty(a) && !is_empty(&r->slabs[1]);
    for (uint32_t b = 0; b < count_blocks(r->n); ++b) {
        uint64_t from = (uint64_t)b * INPUT_BLOCK;
        r->guessed[b] = both && from >= r->cut && from < ghosts_to;
    }
}

bool input_ranges_begin(input_ranges *r, uint32_t n, const part_range slabs[2], duet_error *err)
{
    if (is_known(r, n, slabs))
        return true;
    if (!reserve(r, count_blocks(n), err))
        return false;
    r->n = n;
    r->cut = cut_of(slabs, n);
    memcpy(r->slabs, slabs, sizeof r->slabs);
    r->margin = 0;
    guess_border(r);
    select_both(r);
    return true;
}

// ---------------------------------------------------------------- better guesses

static bool is_requested(const input_ranges *r, const block_requests requests[2], uint32_t block)
{
    const block_requests *of = &requests[block * INPUT_BLOCK < r->cut ? 0 : 1];
    return of->words[block] == of->epoch;
}

// Guesses, of blocks [from, to) of one device's own range, those within the margin of a requested
// one.
static void guess_requested(input_ranges *r, const block_requests requests[2], uint32_t from,
                            uint32_t to)
{
    uint32_t next = from; // the first that is requested, not too far before b
    for (uint32_t b = from; b < to; ++b) {
        while (next < to && (next + r->margin < b || !is_requested(r, requests, next)))
            ++next;
        r->guessed[b] = next < to && next <= b + r->margin;
    }
}

// Objects that move reach the next blocks: once the guess was better than the first and misses
// again, it has a layer of cells more than was requested. A guess of far more than that is dropped.
bool input_ranges_held(input_ranges *r, const block_requests requests[2])
{
    uint32_t n_blocks = count_blocks(r->n);
    uint32_t layer = count_blocks(r->slabs[0].expected_ghosts);
    uint32_t n_missed = 0, n_requested = 0, n_guessed = 0;
    for (uint32_t b = 0; b < n_blocks; ++b) {
        bool requested = is_requested(r, requests, b);
        n_missed += requested && !r->guessed[b];
        n_requested += requested;
        n_guessed += r->guessed[b];
    }
    if (n_missed > 0 || n_guessed > 2 * (n_requested + layer)) {
        guess_requested(r, requests, 0, count_blocks(r->cut));
        guess_requested(r, requests, count_blocks(r->cut), n_blocks);
        r->margin = layer;
        select_both(r);
    }
    return n_missed == 0;
}

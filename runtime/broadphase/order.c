// SPDX-License-Identifier: MIT
// The order of a world's objects by cell.
//
// The cells are those of the grid's finest level, whatever an object's own level is, and of a
// hashed grid the cells themselves, not their entries: objects that follow each other lie side
// by side.
//
// It is a radix sort by threads that each have a chunk of the rows: they count the digits of
// their rows, and know then where each of these goes, behind equal digits of earlier chunks.
#include "runtime/broadphase/order.h"

#include "base/error.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS, KEY_BITS = 32 };

// More threads than these only wait for the same memory. One for fewer objects is not worth its
// start; and chunks are more than threads, so that a late one takes fewer.
enum { MOST_THREADS = 30, LEAST_OBJECTS = 1 << 14, CHUNKS_A_THREAD = 2 };

typedef struct keyed_id {
    uint32_t key; // KEY_BITS of a cell's
    uint32_t id;
} keyed_id;

static_assert(2 * sizeof(keyed_id) == ORDER_SCRATCH, "rows before and after a pass");

// How cells are numbered: row after row. Neighbours share a key if a world has more cells than
// keys.
typedef struct numbering {
    uint32_t shift;
    uint64_t cells[3];
} numbering;

typedef struct sorting {
    const grid *grid;
    const grid_objects *objects;
    numbering cells;
    uint32_t n_chunks;
    uint32_t (*places)[DIGITS]; // [n_chunks] how many rows have a digit, and where they go
    keyed_id *from, *to;
    uint32_t *order; // used if to is NULL
    uint32_t low;    // bits of cells' keys below those in rows, by which order is sorted
    uint32_t shift;  // from a row's key to the digit
    uint32_t digits;
} sorting;

// ---------------------------------------------------------------- keys

static numbering number_cells(const grid *g)
{
    numbering n = {0};
    double keys;
    do {
        keys = 1.0;
        for (int k = 0; k < 3; ++k) {
            n.cells[k] = ((uint64_t)(g->levels[0].cells.s[k] - 1) >> n.shift) + 1;
            keys *= (double)n.cells[k];
        }
    } while (keys > 0x1p63 && ++n.shift);
    return n;
}

static uint64_t key_of(const numbering *n, const uint32_t cell[3])
{
    return ((cell[2] >> n->shift) * n->cells[1] + (cell[1] >> n->shift)) * n->cells[0] +
           (cell[0] >> n->shift);
}

// The bits of the greatest key, that of the last cell along each axis as floats have it.
static uint32_t bits_of_keys(const numbering *n, const grid *g)
{
    uint32_t last[3], bits = 0;
    for (int k = 0; k < 3; ++k)
        last[k] = (uint32_t)(float)(g->levels[0].cells.s[k] - 1);
    for (uint64_t greatest = key_of(n, last); greatest > 0; greatest >>= 1)
        ++bits;
    return bits;
}

// ---------------------------------------------------------------- a pass

// Threads each have a copy of it, which what they write cannot change.
static uint32_t begin_of(const sorting *s, uint64_t chunk)
{
    return (uint32_t)(s->objects->all.n * chunk / s->n_chunks);
}

static uint32_t digit_of(const sorting *s, uint32_t key)
{
    return (key >> s->shift) & (s->digits - 1);
}

static void make_rows(void *sort, uint64_t first, uint64_t last)
{
    const sorting s = *(const sorting *)sort;
    uint32_t end = begin_of(&s, last);
    for (uint32_t i = begin_of(&s, first); i < end; ++i) {
        uint32_t cell[3], id = s.low > 0 ? s.order[i] : i;
        grid_cell_of(cell, s.grid, s.objects, id);
        s.from[i] = (keyed_id){(uint32_t)(key_of(&s.cells, cell) >> s.low), id};
    }
}

static void count_digits(void *sort, uint64_t chunk, uint64_t last)
{
    const sorting s = *(const sorting *)sort;
    for (; chunk < last; ++chunk) {
        uint32_t *counts = s.places[chunk], end = begin_of(&s, chunk + 1);
        memset(counts, 0, s.digits * sizeof *counts);
        for (uint32_t i = begin_of(&s, chunk); i < end; ++i)
            ++counts[digit_of(&s, s.from[i].key)];
    }
}

static void find_places(const sorting *s)
{
    uint32_t next = 0;
    for (uint32_t d = 0; d < s->digits; ++d)
        for (uint32_t k = 0; k < s->n_chunks; ++k) {
            uint32_t n = s->places[k][d];
            s->places[k][d] = next;
            next += n;
        }
}

static void move_rows(void *sort, uint64_t chunk, uint64_t last)
{
    const sorting s = *(const sorting *)sort;
    for (; chunk < last; ++chunk) {
        uint32_t *places = s.places[chunk], end = begin_of(&s, chunk + 1);
        for (uint32_t i = begin_of(&s, chunk); i < end; ++i) {
            const keyed_id row = s.from[i];
            uint32_t place = places[digit_of(&s, row.key)]++;
            if (s.to)
                s.to[place] = row;
            else
                s.order[place] = row.id;
        }
    }
}

// ---------------------------------------------------------------- all passes

static void by_all(sorting *s, thread_pool *threads, thread_pool_some *some)
{
    thread_pool_share(threads, some, s, s->n_chunks, 1);
}

// By so many bits of keys from s->low on, in passes of about as many each; the last one leaves
// ids alone.
static void sort_by_bits(sorting *s, thread_pool *threads, uint32_t bits, keyed_id *scratch)
{
    uint32_t n_passes = (bits + DIGIT_BITS - 1) / DIGIT_BITS;
    uint32_t each = (bits + n_passes - 1) / n_passes;
    s->from = scratch;
    s->digits = 1u << each;
    by_all(s, threads, make_rows);
    for (uint32_t pass = 0; pass < n_passes; ++pass) {
        keyed_id *other = s->from == scratch ? scratch + s->objects->all.n : scratch;
        s->shift = pass * each;
        s->to = pass + 1 < n_passes ? other : NULL;
        by_all(s, threads, count_digits);
        find_places(s);
        by_all(s, threads, move_rows);
        s->from = other;
    }
}

static uint32_t at_most(uint32_t n, uint32_t most)
{
    return n < most ? n : most;
}

// Longer keys than a row has are sorted by their low bits first.
static bool sort_objects(const grid *g, const grid_objects *objects, uint32_t n_threads,
                         thread_pool *threads, uint32_t *order, void *scratch, duet_error *err)
{
    sorting s = {.grid = g, .objects = objects, .order = order};
    s.n_chunks = n_threads > 1 ? n_threads * CHUNKS_A_THREAD : 1;
    s.places = malloc(s.n_chunks * sizeof *s.places);
    if (!s.places)
        return no_memory(err, "%u objects in order", s.objects->all.n);
    s.cells = number_cells(s.grid);
    uint32_t bits = bits_of_keys(&s.cells, s.grid);
    do {
        sort_by_bits(&s, threads, at_most(bits > s.low ? bits - s.low : 1, KEY_BITS), scratch);
        s.low += KEY_BITS;
    } while (s.low < bits);
    free(s.places);
    return true;
}

bool world_order(duet_world *world, uint32_t n_threads, uint32_t *order, void *scratch,
                 duet_error *err)
{
    if (world->objects.all.n == 0)
        return true;
    uint32_t n = at_most(at_most(n_threads, MOST_THREADS), world->objects.all.n / LEAST_OBJECTS);
    thread_pool *threads = n > 1 ? thread_pool_open(n - 1, NULL) : NULL; // or it takes longer
    bool ok = world_fit_grid(world, true, threads, err) &&
              sort_objects(&world->grid, &world->objects, n, threads, order, scratch, err);
    world_unmap_objects(world);
    thread_pool_close(threads);
    return ok;
}

bool duet_world_order(duet_world *world, uint32_t **order, uint32_t *n, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!world_is_idle(world, __func__, err) || !error_given(order, __func__, "order", err) ||
        !error_given(n, __func__, "n", err))
        return false;
    uint32_t *list = malloc((size_t)world->objects.all.n * sizeof *list + 1);
    void *scratch = malloc((size_t)world->objects.all.n * ORDER_SCRATCH + 1);
    bool ok = list && scratch;
    if (!ok)
        no_memory(err, "%u objects in order", world->objects.all.n);
    ok = ok && world_order(world, 1 + thread_pool_spare(MOST_THREADS), list, scratch, err);
    free(scratch);
    if (!ok) {
        free(list);
        return false;
    }
    *order = list;
    *n = world->objects.all.n;
    return true;
}

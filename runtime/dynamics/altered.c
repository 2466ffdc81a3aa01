// SPDX-License-Identifier: MIT
#include "kernels/dynamics/altered.h"
#include "base/compare.h"
#include "runtime/dynamics/motion.h"

#include <math.h>
#include <stdlib.h>

// More altered bodies are searched with all others, whose grid costs less then.
enum { LEAST_PART = 8 };

// Pairs that an altered body may have; with more, all are searched.
enum { PAIRS_OF_ONE = 64 };

static const char stage[] = "altered_pairs";

// ---------------------------------------------------------------- which bodies

static bool reserve(altered_bodies *a, uint64_t n)
{
    if (n <= a->capacity)
        return true;
    uint32_t *places = realloc(a->places, 2 * n * sizeof *places);
    if (!places)
        return false;
    a->places = places;
    a->capacity = (uint32_t)(2 * n);
    return true;
}

void motion_alter_all(duet_motion *m)
{
    product_forget(&m->products, PRODUCT_BOUNDS);
    product_forget(&m->products, PRODUCT_PAIRS);
    altered_forget(&m->altered);
}

void motion_alter_places(duet_motion *m, const uint32_t *places, uint32_t n)
{
    altered_bodies *a = &m->altered;
    uint64_t all = (uint64_t)a->n + n;
    if (n == 0)
        return;
    product_forget(&m->products, PRODUCT_PAIRS);
    if (product_is_forgotten(&m->products, PRODUCT_BOUNDS) || !(m->effects & DUET_EFFECT_SKIN) ||
        all > m->n / LEAST_PART || !reserve(a, all))
        motion_alter_all(m);
    else
        for (uint32_t i = 0; i < n; ++i)
            a->places[a->n++] = places[i];
}

static void list_once(altered_bodies *a)
{
    uint32_t n = 0;
    qsort(a->places, a->n, sizeof *a->places, compare_uint32);
    for (uint32_t i = 0; i < a->n; ++i)
        if (n == 0 || a->places[n - 1] != a->places[i])
            a->places[n++] = a->places[i];
    a->n = n;
}

// ---------------------------------------------------------------- a table of them

// Twice as wide as what is altered, in the mean: few bodies overlap more than eight.
static double edge_of(const duet_motion *m)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < m->altered.n; ++i) {
        const float *h = m->poses[m->altered.places[i]].half_extents;
        sum += fmax(fmax(h[0], h[1]), m->def.dims == 3 ? h[2] : 0.0f);
    }
    return 4.0 * sum / m->altered.n + 2.0 * (m->margin + motion_skin(m));
}

static uint32_t count_heads(uint32_t n_altered)
{
    uint32_t n = 1024;
    while (n < 16 * (uint64_t)n_altered && n < 1u << 31)
        n *= 2;
    return n;
}

static void measure_table(duet_motion *m)
{
    altered_bodies *a = &m->altered;
    a->n_heads = count_heads(a->n);
    a->per_edge = (float)fmin(1.0 / edge_of(m), 1e30);
    a->pair_capacity = m->graph.n_contacts + PAIRS_OF_ONE * a->n;
}

static bool reserve_table(duet_motion *m, duet_error *err)
{
    const uint64_t word = sizeof(uint32_t), n = m->altered.n;
    return motion_reserve(m, ALTERED, n, word, err) &&
           motion_reserve(m, IS_ALTERED, m->n, word, err) &&
           motion_reserve(m, ALTERED_HEADS, m->altered.n_heads, word, err) &&
           motion_reserve(m, ALTERED_ENTRIES_OF, ALTERED_CELLS * n, sizeof(cl_int4), err) &&
           motion_reserve(m, ALTERED_NEXTS, ALTERED_CELLS * n, word, err) &&
           motion_reserve(m, ALTERED_WIDE_ONES, n, word, err) &&
           motion_reserve(m, ALTERED_COUNT_WORDS, ALTERED_COUNTS, word, err) &&
           motion_reserve(m, PAIRS, m->altered.pair_capacity, 2 * word, err);
}

static bool send_altered(duet_motion *m, duet_error *err)
{
    const altered_bodies *a = &m->altered;
    return motion_clear(m, stage, IS_ALTERED, 0, m->n, err) &&
           motion_clear(m, stage, ALTERED_HEADS, 0, m->altered.n_heads, err) &&
           motion_clear(m, stage, ALTERED_COUNT_WORDS, 0, ALTERED_COUNTS, err) &&
           timeline_write_at(&m->times, stage, &m->buffers[ALTERED], 0, a->places,
                             a->n * sizeof *a->places, err);
}

// ---------------------------------------------------------------- in a step

bool motion_bound_altered(duet_motion *m, duet_error *err)
{
    if (m->altered.n == 0)
        return true;
    list_once(&m->altered);
    measure_table(m);
    return reserve_table(m, err) && send_altered(m, err) &&
           motion_launch(m, COMPUTE_ALTERED_AABBS, err) && motion_launch(m, PLACE_ALTERED, err);
}

bool motion_search_altered(duet_motion *m, cl_uint *n, duet_error *err)
{
    uint32_t counts[ALTERED_COUNTS] = {0};
    bool ok = motion_launch(m, FIND_ALTERED_PAIRS, err) && motion_launch(m, KEEP_PAIRS, err) &&
              motion_fetch(m, stage, ALTERED_COUNT_WORDS, 0, counts, sizeof counts, err);
    *n = counts[ALTERED_PAIRS];
    return ok;
}

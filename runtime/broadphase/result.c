// SPDX-License-Identifier: MIT
// What a step tells of the pairs that both devices found, and of how it went.
#include "runtime/broadphase/pair_hash.h"
#include "runtime/broadphase/world.h"

#include "base/error.h"

static uint32_t largest(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static uint32_t smallest(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

// A part reports the bad objects of its own cells. Two slabs share no cells; two whole
// grids are identical.
static uint32_t count_bad(const duet_world *world)
{
    uint32_t a = world->parts[0].found.bad;
    uint32_t b = world->parts[1].found.bad;
    return world->def.plan.mode == DUET_MODE_SLAB ? a + b : largest(a, b);
}

bool world_check_bad(const duet_world *world, duet_error *err)
{
    const part *a = &world->parts[0];
    const part *b = &world->parts[1];
    uint32_t bad = count_bad(world);
    if (bad == 0 || world->def.keep_bad)
        return true;
    return error_set(err, DUET_STATUS_BAD_OBJECT,
                     "object %u of %u is not a number, infinite, negative or without rotation "
                     "(%u such objects)",
                     smallest(a->found.first_bad, b->found.first_bad), world->n, bad);
}

static double kernel_ms(const part *p)
{
    return (double)(p->times.last_end - p->times.first_begin) * 1e-6;
}

void world_tell_result(duet_world *world, duet_result *result)
{
    const part *a = &world->parts[0];
    const part *b = &world->parts[1];
    uint32_t bad = count_bad(world);
    const grid_level *finest = &world->grid.levels[0];
    *result = (duet_result){
        .objects = world->n,
        .bad = bad,
        .first_bad = bad ? smallest(a->found.first_bad, b->found.first_bad) : 0,
        .candidates = a->n_candidates + b->n_candidates,
        .pairs = a->span.n + b->span.n,
        .spans = {a->span, b->span},
        .undecided = a->n_undecided + b->n_undecided,
        .device_ms = {a->wall_ms, b->wall_ms},
        .kernel_ms = {kernel_ms(a), kernel_ms(b)},
        .bytes = {part_bytes(a), part_bytes(b)},
        .cells = {(uint32_t)finest->cells.s[0], (uint32_t)finest->cells.s[1],
                  (uint32_t)finest->cells.s[2]},
        .grid_levels = world->grid.n_levels,
        .hashed = world->grid.kind == GRID_HASHED,
        .cell = world->grid.edge,
        .cell_widened = world->cell_widened,
        .runs = largest(a->runs, b->runs),
        .stages = world->stages,
        .timed = !a->times.untimed && !b->times.untimed,
    };
    if (world->left.device)
        result->spans[0].pairs = result->spans[1].pairs = NULL;
    for (int side = 0; side < 2; ++side) {
        const timeline *t = &world->parts[side].times;
        for (int i = 0; i < t->n_stages; ++i) {
            world->stages[result->n_stages] = t->stages[i];
            world->stages[result->n_stages++].device = side;
        }
    }
}

// ---------------------------------------------------------------- its pairs

// Pairs as a set, whoever found them and in whatever order.
uint64_t duet_pairs_hash(const duet_pair *pairs, uint64_t n)
{
    uint64_t sum = 0;
    for (uint64_t i = 0; pairs && i < n; ++i)
        sum += pair_hash((uint64_t)pairs[i].a << 32 | pairs[i].b);
    return sum;
}

uint64_t duet_result_get_hash(const duet_result *result)
{
    if (!result)
        return 0;
    return duet_pairs_hash(result->spans[0].pairs, result->spans[0].n) +
           duet_pairs_hash(result->spans[1].pairs, result->spans[1].n);
}

duet_pair duet_result_get_pair(const duet_result *result, uint64_t i)
{
    if (!result || i >= result->spans[0].n + result->spans[1].n)
        return (duet_pair){0, 0};
    bool of_a = i < result->spans[0].n;
    const duet_pair *pairs = result->spans[of_a ? 0 : 1].pairs;
    return pairs ? pairs[of_a ? i : i - result->spans[0].n] : (duet_pair){0, 0};
}

// SPDX-License-Identifier: MIT
// Finding the pairs of one device's objects.
#include "runtime/broadphase/part.h"

#include "base/error.h"

enum { SMALLEST_ROOM = 1024 };

// Pairs that fit a buffer; the kernels count places in 32 bits.
static uint32_t capacity_of(const buffer *b)
{
    size_t capacity = b->bytes / sizeof(duet_pair);
    return capacity > UINT32_MAX ? UINT32_MAX : (uint32_t)capacity;
}

static bool reserve_room(part *p, buffer *b, uint64_t pairs, duet_error *err)
{
    if (pairs > UINT32_MAX)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%s: %llu pairs, more than the %u that one device can list",
                         p->device->info.selector, (unsigned long long)pairs, UINT32_MAX);
    if (pairs < SMALLEST_ROOM)
        pairs = SMALLEST_ROOM;
    return buffer_reserve(b, p->device, (size_t)pairs * sizeof(duet_pair), err);
}

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

// Objects around which to search, at most.
static uint32_t search_work(const part_task *task, const part_range *range)
{
    return smaller(range->last, smaller(range->expected, task->n)) - range->first;
}

static bool run_rows(part *p, const part_task *task, const part_range *range, buffer *found,
                     duet_error *err)
{
    const grid *g = &task->grid;
    uint32_t n_home = range->home_to - range->key_from;
    uint32_t capacity = capacity_of(found);
    uint32_t last = smaller(range->last, range->expected);
    uint32_t pair_room = capacity_of(&p->pairs);
    uint32_t undecided_capacity = capacity_of(&p->undecided);
    kernel_arg args[20] = {ARG_BUFFER(p->bounds)};
    uint32_t n_args = 1;
    if (task->shape == DUET_SHAPE_POSES)
        args[n_args++] = ARG_BUFFER(p->boxes);
    const kernel_arg search[] = {
        ARG_BUFFER(p->starts), ARG_BUFFER(p->levels), ARG(g->n_levels),  ARG(g->n_cells),
        ARG(range->key_from),  ARG(n_home),           ARG(range->first), ARG(last),
        ARG_BUFFER(*found),    ARG(capacity)};
    for (size_t i = 0; i < sizeof search / sizeof search[0]; ++i)
        args[n_args++] = search[i];
    if (p->kernels.fused) {
        args[n_args++] = ARG_BUFFER(p->pairs);
        args[n_args++] = ARG(pair_room);
        args[n_args++] = ARG_BUFFER(p->undecided);
        args[n_args++] = ARG(undecided_capacity);
    }
    args[n_args++] = ARG_BUFFER(p->counters);
    return timeline_launch(&p->times, "candidates", p->kernels.candidates, search_work(task, range),
                           args, n_args, err);
}

static bool run_lanes(part *p, const part_task *task, const part_range *range, buffer *found,
                      duet_error *err)
{
    const grid *g = &task->grid;
    bool poses = task->shape == DUET_SHAPE_POSES;
    uint32_t n_home = range->home_to - range->key_from;
    uint32_t n_own = range->key_to - range->key_from;
    uint32_t last = smaller(range->last, range->expected);
    uint32_t capacity = capacity_of(found);
    uint32_t undecided_capacity = capacity_of(&p->undecided);
    kernel_arg args[17] = {ARG_BUFFER(p->bounds),
                           ARG(p->place_capacity),
                           poses ? ARG_BUFFER(p->boxes) : ARG_BUFFER(p->ids),
                           ARG_BUFFER(p->starts),
                           ARG_BUFFER(p->levels),
                           ARG(g->n_levels),
                           ARG(g->n_cells),
                           ARG(range->key_from),
                           ARG(n_home),
                           ARG(n_own),
                           ARG(range->first),
                           ARG(last),
                           ARG_BUFFER(*found),
                           ARG(capacity)};
    uint32_t n_args = 14;
    if (p->kernels.fused) {
        args[n_args++] = ARG_BUFFER(p->undecided);
        args[n_args++] = ARG(undecided_capacity);
    }
    args[n_args++] = ARG_BUFFER(p->counters);
    const char *stage = p->kernels.fused ? "search" : "candidates";
    return timeline_launch(&p->times, stage, p->kernels.candidates, search_work(task, range), args,
                           n_args, err);
}

static bool run_paper(part *p, const part_task *task, const part_range *range, buffer *found,
                      duet_error *err)
{
    cl_int4 cells = task->grid.levels[0].cells;
    uint32_t n_home = range->home_to - range->key_from;
    uint32_t n_own = range->key_to - range->key_from;
    uint32_t capacity = capacity_of(found);
    kernel_arg args[] = {ARG_BUFFER(p->keys),
                         ARG_BUFFER(p->ids),
                         ARG_BUFFER(p->starts),
                         ARG_BUFFER(p->bounds),
                         ARG(task->n),
                         ARG(range->first),
                         ARG(range->last),
                         ARG(cells),
                         ARG(range->key_from),
                         ARG(n_home),
                         ARG(n_own),
                         ARG_BUFFER(*found),
                         ARG(capacity),
                         ARG_BUFFER(p->counters)};
    return timeline_launch(&p->times, "candidates", p->kernels.candidates, search_work(task, range),
                           args, 14, err);
}

static bool run_narrow(part *p, uint64_t work, duet_error *err)
{
    uint32_t candidate_capacity = capacity_of(&p->candidates);
    uint32_t capacity = capacity_of(&p->pairs);
    uint32_t undecided_capacity = capacity_of(&p->undecided);
    buffer *boxes = p->variant.search == SEARCH_PAPER ? &p->objects : &p->boxes;
    kernel_arg args[] = {ARG_BUFFER(*boxes),      ARG_BUFFER(p->candidates),
                         ARG(candidate_capacity), ARG_BUFFER(p->pairs),
                         ARG(capacity),           ARG_BUFFER(p->undecided),
                         ARG(undecided_capacity), ARG_BUFFER(p->counters)};
    return timeline_launch(&p->times, "narrow", p->kernels.narrow, work, args, 8, err);
}

static bool run_candidates(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    buffer *found = p->kernels.narrow ? &p->candidates : &p->pairs;
    switch (p->variant.search) {
    case SEARCH_GPU:
        return run_rows(p, task, range, found, err);
    case SEARCH_SIMD:
        return run_lanes(p, task, range, found, err);
    case SEARCH_PAPER:
        break;
    }
    return run_paper(p, task, range, found, err);
}

// Candidates are not counted on the host before they are tested: the narrow
// kernel reads their number itself, and enough work-items for the last step's
// number are sent.
static uint64_t narrow_work(const part *p, uint32_t objects)
{
    uint64_t capacity = capacity_of(&p->candidates);
    uint64_t expected = 2 * (uint64_t)objects + SMALLEST_ROOM;
    return expected < capacity ? expected : capacity;
}

// True where all that was found has its place; else makes more.
static bool everything_fits(part *p, bool *fits, duet_error *err)
{
    struct {
        buffer *list;
        uint64_t found;
    } lists[] = {
        {&p->candidates, part_count(p, COUNT_CANDIDATES)},
        {&p->undecided, part_count(p, COUNT_UNDECIDED)},
        // undecided pairs may join the pairs
        {&p->pairs, part_count(p, COUNT_PAIRS) + part_count(p, COUNT_UNDECIDED)},
    };
    *fits = true;
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i) {
        uint64_t found = lists[i].found;
        if (found == 0 || found <= capacity_of(lists[i].list))
            continue;
        *fits = false;
        if (!reserve_room(p, lists[i].list, found + found / 16, err))
            return false;
    }
    return true;
}

// Where candidates are tested as they are found, the narrow kernel gets what a
// group had no space for, which is mostly nothing.
static bool test_listed(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    if (!p->kernels.narrow)
        return part_hear(p, err);
    if (!p->kernels.fused)
        return run_narrow(p, narrow_work(p, search_work(task, range)), err) && part_hear(p, err);
    if (!part_hear(p, err))
        return false;
    uint64_t listed = part_count(p, COUNT_CANDIDATES);
    return listed == 0 || listed > capacity_of(&p->candidates) ||
           (run_narrow(p, listed, err) && part_hear(p, err));
}

// The first search finds its counters as the step cleared them.
static bool search_once(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    return (p->runs++ == 0 ||
            timeline_fill(&p->times, "clear", &p->counters, 0, 0, COUNT_BAD, err)) &&
           run_candidates(p, task, range, err) && test_listed(p, task, range, err);
}

static bool under_limit(const part *p, const part_task *task, duet_error *err)
{
    uint64_t pairs = part_count(p, COUNT_PAIRS);
    if (task->max_pairs && pairs > task->max_pairs)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu pairs on %s, and the world allows %llu",
                         (unsigned long long)pairs, p->device->info.selector,
                         (unsigned long long)task->max_pairs);
    return true;
}

static bool reserve_first(part *p, const part_task *task, uint32_t objects, duet_error *err)
{
    uint64_t guess = objects;
    bool ok = p->pairs.mem || reserve_room(p, &p->pairs, guess, err);
    if (task->shape == DUET_SHAPE_POSES)
        ok = ok && (p->undecided.mem || reserve_room(p, &p->undecided, guess / 64, err));
    if (p->kernels.narrow)
        ok =
            ok && (p->candidates.mem ||
                   reserve_room(p, &p->candidates, p->kernels.fused ? guess / 64 : 2 * guess, err));
    return ok;
}

// A grid with less space than there are objects may have got more than it holds,
// and its starts then lead out of it. Lanes see that for themselves and find
// nothing, so that nobody waits for the answer between grid and search.
static bool check_placed(part *p, const part_task *task, const part_range *range, bool *placed,
                         duet_error *err)
{
    *placed = true;
    if (range->expected >= task->n || p->variant.search == SEARCH_SIMD)
        return true;
    bool ok = part_read_counters(p, err);
    *placed = p->counts[COUNT_PLACED] <= range->expected;
    return ok;
}

bool part_search(part *p, const part_task *task, const part_range *range, bool *placed,
                 duet_error *err)
{
    *placed = true;
    if (range->first >= range->last)
        return part_read_counters(p, err) && timeline_finish(&p->times, err);
    bool ok = check_placed(p, task, range, placed, err) &&
              reserve_first(p, task, search_work(task, range), err);
    bool fits = false;
    uint32_t extra = p->extra_searches;
    while (ok && *placed && (!fits || extra-- > 0)) {
        ok = search_once(p, task, range, err) && under_limit(p, task, err) &&
             everything_fits(p, &fits, err);
        *placed = p->counts[COUNT_PLACED] <= range->expected;
    }
    if (!ok || !*placed)
        return ok;
    p->n_candidates = p->kernels.listed
                          ? part_count(p, COUNT_PAIRS)
                          : part_count(p, COUNT_CANDIDATES) + part_count(p, COUNT_TESTED);
    return part_fetch(p, task, err);
}

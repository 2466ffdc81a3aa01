// SPDX-License-Identifier: MIT
// Finding the pairs of one device's objects.
#include "runtime/broadphase/part.h"

#include "base/error.h"

enum { LEAST_CAPACITY = 1024 };

// Pairs that fit a buffer; the kernels count places in 32 bits.
static uint32_t capacity_of(const buffer *b)
{
    size_t capacity = b->bytes / sizeof(duet_pair);
    return capacity > UINT32_MAX ? UINT32_MAX : (uint32_t)capacity;
}

static bool reserve_pairs(part *p, buffer *b, uint64_t pairs, duet_error *err)
{
    if (pairs > UINT32_MAX)
        return error_set(err, DUET_STATUS_TOO_MANY,
                         "%s: %llu pairs, more than the %u that one device can list",
                         p->device->info.selector, (unsigned long long)pairs, UINT32_MAX);
    if (pairs < LEAST_CAPACITY)
        pairs = LEAST_CAPACITY;
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

static bool run_narrow(part *p, uint64_t work, duet_error *err)
{
    return timeline_launch(&p->times, "narrow", p->kernels.narrow, work, p, err);
}

static bool run_candidates(part *p, const part_task *task, const part_range *range, duet_error *err)
{
    part_args *a = &p->args;
    a->found = p->kernels.narrow ? p->candidates : p->pairs;
    a->found_capacity = capacity_of(&a->found);
    a->candidate_capacity = capacity_of(&p->candidates);
    a->pair_capacity = capacity_of(&p->pairs);
    a->undecided_capacity = capacity_of(&p->undecided);
    bool decides = p->variant.search == SEARCH_SIMD && p->kernels.fused;
    return timeline_launch(&p->times, decides ? "search" : "candidates", p->kernels.candidates,
                           search_work(task, range), p, err);
}

// Candidates are not counted on the host before they are tested: the narrow
// kernel reads their number itself, and enough work-items for the last step's
// number are sent.
static uint64_t narrow_work(const part *p, uint32_t objects)
{
    uint64_t capacity = capacity_of(&p->candidates);
    uint64_t expected = 2 * (uint64_t)objects + LEAST_CAPACITY;
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
        if (!reserve_pairs(p, lists[i].list, found + found / 16, err))
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
    bool ok = p->pairs.mem || reserve_pairs(p, &p->pairs, guess, err);
    if (task->shape == DUET_SHAPE_POSES)
        ok = ok && (p->undecided.mem || reserve_pairs(p, &p->undecided, guess / 64, err));
    if (p->kernels.narrow)
        ok = ok &&
             (p->candidates.mem ||
              reserve_pairs(p, &p->candidates, p->kernels.fused ? guess / 64 : 2 * guess, err));
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
    part_set_args(p, task, range);
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

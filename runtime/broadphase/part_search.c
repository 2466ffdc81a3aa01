// SPDX-License-Identifier: MIT
// How a part finds the pairs of its objects: it searches and tests, again while lists are too
// short.
#include "runtime/broadphase/part_fetch.h"

#include "base/error.h"
#include "kernels/grid/pair_counts.h"

enum { LEAST_CAPACITY = 1024 };

// Pairs that fit a buffer; the kernels count places in 32 bits.
static uint32_t capacity_of(const buffer *b)
{
    size_t capacity = b->bytes / sizeof(duet_pair);
    return capacity > UINT32_MAX ? UINT32_MAX : (uint32_t)capacity;
}

static bool reserve_pairs(part *p, buffer *b, uint64_t pairs, duet_error *err)
{
    if (pairs < LEAST_CAPACITY)
        pairs = LEAST_CAPACITY;
    if (pairs > UINT32_MAX)
        pairs = UINT32_MAX;
    return buffer_reserve(b, p->device, (size_t)pairs * sizeof(duet_pair), err);
}

// Objects around which to search, at most.
static uint32_t search_work(const part *p)
{
    const part_range *r = &p->task.range;
    return (uint32_t)smaller(r->last, smaller(r->expected, p->objects.n)) - r->first;
}

static bool run_narrow(part *p, uint64_t work, duet_error *err)
{
    return timeline_launch(&p->times, "narrow", p->kernels.narrow, work, p, err);
}

static bool run_candidates(part *p, duet_error *err)
{
    part_args *a = &p->args;
    a->found = p->kernels.narrow ? p->candidates : p->pairs;
    a->found_capacity = capacity_of(&a->found);
    a->candidate_capacity = capacity_of(&p->candidates);
    a->pair_capacity = capacity_of(&p->pairs);
    a->undecided_capacity = capacity_of(&p->undecided);
    a->left_capacity = capacity_of(&p->left);
    bool decides = p->variant.search == SEARCH_SIMD && (p->facts & PART_FUSED);
    return timeline_launch(&p->times, decides ? "search" : "candidates", p->kernels.candidates,
                           search_work(p), p, err);
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

// True if all that was found has its place; else makes more.
static bool everything_fits(part *p, bool *fits, duet_error *err)
{
    struct {
        buffer *list;
        uint64_t found;
        const char *what;
    } lists[] = {
        {&p->candidates, p->result.found.candidates, "pairs whose bounds overlap"},
        {&p->undecided, p->result.found.undecided, "undecided pairs"},
        {&p->left, p->result.counted.left, "pairs"},
        // undecided pairs may join the pairs
        {&p->pairs, p->result.found.pairs + p->result.found.undecided, "pairs"},
    };
    *fits = true;
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i) {
        uint64_t found = lists[i].found;
        if (found == 0 || found <= capacity_of(lists[i].list))
            continue;
        *fits = false;
        if (found > UINT32_MAX)
            return error_set(
                err, DUET_STATUS_TOO_MANY, "%s: %llu %s, more than the %u that one device can list",
                p->device->info.selector, (unsigned long long)found, lists[i].what, UINT32_MAX);
        if (!reserve_pairs(p, lists[i].list, found + found / 16, err))
            return false;
    }
    return true;
}

// If candidates are tested as they are found, the narrow kernel gets what a
// group had no space for, which is mostly nothing.
static bool test_listed(part *p, duet_error *err)
{
    if (!p->kernels.narrow)
        return part_read_found(p, err);
    if (!(p->facts & PART_FUSED))
        return run_narrow(p, narrow_work(p, search_work(p)), err) && part_read_found(p, err);
    if (!part_read_found(p, err))
        return false;
    uint64_t listed = p->result.found.candidates;
    return listed == 0 || listed > capacity_of(&p->candidates) ||
           (run_narrow(p, listed, err) && part_read_found(p, err));
}

// The first search finds its counters as the step cleared them.
static bool search_once(part *p, duet_error *err)
{
    return (p->result.runs++ == 0 ||
            timeline_fill(&p->times, "clear", &p->counters, 0, 0, COUNT_BAD, err)) &&
           run_candidates(p, err) && test_listed(p, err);
}

static bool under_limit(const part *p, duet_error *err)
{
    uint64_t pairs = p->result.found.pairs;
    if (p->task.def->max_pairs && pairs > p->task.def->max_pairs)
        return error_set(err, DUET_STATUS_TOO_MANY, "%llu pairs on %s, and the world allows %llu",
                         (unsigned long long)pairs, p->device->info.selector,
                         (unsigned long long)p->task.def->max_pairs);
    return true;
}

static bool reserve_first(part *p, uint32_t objects, duet_error *err)
{
    uint64_t guess = objects;
    bool ok = p->pairs.mem || reserve_pairs(p, &p->pairs, guess, err);
    if (p->task.objects->shape != DUET_SHAPE_BOUNDS)
        ok = ok && (p->undecided.mem || reserve_pairs(p, &p->undecided, guess / 64, err));
    if (p->task.ids)
        ok = ok && (p->left.mem || reserve_pairs(p, &p->left, guess / 64, err)) &&
             buffer_reserve(&p->pair_counts, p->device, PAIR_COUNTS * sizeof(uint32_t), err);
    if (p->kernels.narrow)
        ok = ok && (p->candidates.mem ||
                    reserve_pairs(p, &p->candidates,
                                  (p->facts & PART_FUSED) ? guess / 64 : 2 * guess, err));
    return ok;
}

static void note_placed(part *p)
{
    if (p->result.found.placed > p->task.range.expected && p->state != PART_CROWDED)
        part_enter(p, PART_CROWDED);
}

// A grid with space for fewer objects than there are may get more than it holds, and
// its starts then point past its end. A search that is guarded checks that itself and finds
// nothing, so the host need not wait between grid and search.
static bool check_placed(part *p, duet_error *err)
{
    if (p->task.range.expected >= p->objects.n || p->variant.search != SEARCH_PAPER)
        return true;
    bool ok = part_read_counters(p, err);
    note_placed(p);
    return ok;
}

bool part_search(part *p, duet_error *err)
{
    if (p->task.range.first >= p->task.range.last)
        return part_read_counters(p, err) && timeline_finish(&p->times, err);
    bool ok = check_placed(p, err) && reserve_first(p, search_work(p), err);
    bool fits = false;
    while (ok && p->state != PART_CROWDED && !fits) {
        ok = search_once(p, err) && under_limit(p, err) && everything_fits(p, &fits, err);
        note_placed(p);
    }
    if (!ok || p->state == PART_CROWDED)
        return ok;
    p->result.n_candidates = (p->facts & PART_TESTS_BOXES)
                                 ? p->result.found.candidates + p->result.found.tested
                                 : p->result.found.pairs;
    return part_fetch(p, err);
}

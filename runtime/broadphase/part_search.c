// SPDX-License-Identifier: MIT
// Finding the pairs of one device's objects.
#include "base/clock.h"
#include "base/error.h"
#include "runtime/broadphase/part.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"

#include <stdlib.h>
#include <string.h>

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

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

// Objects around which to search, at most.
static uint32_t search_work(const part_task *task, const part_range *range)
{
    return (uint32_t)smaller(range->last, smaller(range->expected, task->n)) - range->first;
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

// A grid with space for fewer objects than there are may get more than it holds, and
// its starts then point past its end. The SIMD search checks that itself and finds
// nothing, so the host need not wait between grid and search.
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

// ---------------------------------------------------------------- fetching

// Bringing what a search found to the host.
//
// A device with memory of its own sends as many pairs as the last step had
// right behind the search, before anyone has asked how many there are: asking
// first takes as long as a tenth of the pairs.

// Undecided pairs that are sent unasked; there are mostly fewer.
enum { OPEN_AHEAD = 1024 };

// What is sent unasked besides the pairs.
typedef struct news {
    uint32_t counters[COUNTERS];
    duet_pair open[OPEN_AHEAD];
} news;

// The counters come first: the host goes on with them while the pairs travel.
static bool ask_ahead(part *p, cl_event *told, duet_error *err)
{
    size_t open_bytes = smaller(p->undecided.bytes, sizeof((news *)0)->open);
    size_t bytes = smaller(p->pairs_ahead * sizeof(duet_pair), p->fetched.size);
    bytes = smaller(bytes, p->pairs.bytes);
    if (!host_block_reserve(&p->news, p->device, 1, sizeof(news), err))
        return false;
    news *n = p->news.bytes;
    p->pairs_ahead = bytes / sizeof(duet_pair);
    bool ok =
        timeline_start_read(&p->times, "fetch pairs", &p->undecided, 0, n->open, open_bytes, err) &&
        timeline_start_read(&p->times, "fetch pairs", &p->counters, 0, n->counters,
                            sizeof n->counters, err);
    *told = timeline_last_event(&p->times);
    return ok && timeline_start_read(&p->times, "fetch pairs", &p->pairs, 0, p->fetched.bytes,
                                     bytes, err);
}

bool part_hear(part *p, duet_error *err)
{
    cl_event told = NULL;
    if (p->device->info.host_memory)
        return part_read_counters(p, err);
    if (!ask_ahead(p, &told, err))
        return false;
    timeline_spin(&p->times, told);
    if (!timeline_collect_to(&p->times, told, err))
        return false;
    memcpy(p->counts, ((news *)p->news.bytes)->counters, sizeof p->counts);
    return true;
}

// Where pairs come to lie on the host, with space behind them for the undecided.
// A block that must grow loses what was sent ahead, and locking its pages takes
// longer than a step: it grows by more than it must.
static bool reserve_span(part *p, duet_pair **pairs, duet_error *err)
{
    uint64_t most = part_count(p, COUNT_PAIRS) + part_count(p, COUNT_UNDECIDED);
    size_t bytes = (size_t)most * sizeof(duet_pair);
    *pairs = p->pairs.host;
    if (*pairs)
        return true;
    if (bytes > p->fetched.size) {
        p->pairs_ahead = 0;
        bytes += bytes / 16;
    }
    bool ok = host_block_reserve(&p->fetched, p->device, 1, bytes, err);
    *pairs = p->fetched.bytes;
    return ok;
}

// The pairs that were not sent ahead start to travel; those for the next step
// are a few more than now.
static bool fetch_rest(part *p, duet_pair *pairs, uint64_t n, duet_error *err)
{
    uint64_t there = p->device->info.host_memory ? 0 : p->pairs_ahead;
    bool ok = there >= n ||
              timeline_start_read(&p->times, "fetch pairs", &p->pairs, there * sizeof(duet_pair),
                                  pairs + there, (n - there) * sizeof(duet_pair), err);
    p->pairs_ahead = n + n / 64;
    return ok;
}

static bool fetch_open(part *p, const duet_pair **open, duet_pair *scratch, duet_error *err)
{
    const news *n = p->news.bytes;
    *open = p->undecided.host ? p->undecided.host : scratch;
    if (n && !p->device->info.host_memory && p->n_undecided <= OPEN_AHEAD) {
        *open = n->open;
        return true;
    }
    return timeline_read(&p->times, "fetch pairs", &p->undecided, (void *)*open,
                         p->n_undecided * sizeof **open, err);
}

// Decides on the host what float left open. Returns how many of them collide,
// which are written to colliding.
static uint64_t decide(part *p, const part_task *task, const duet_pair *open, duet_pair *colliding)
{
    uint64_t begun = clock_steady_ns();
    uint64_t n = 0;
    grid_objects objects = part_objects(task);
    for (uint64_t i = 0; i < p->n_undecided; ++i) {
        double shift[3];
        duet_pose scratch[2];
        const duet_pose *a = grid_pose_of(&objects, open[i].a, &scratch[0]);
        const duet_pose *b = grid_pose_of(&objects, open[i].b, &scratch[1]);
        origin_shift(shift, task->objects, task->origin, open[i].a, open[i].b);
        if (narrow_decide_apart(a, b, shift, task->dims))
            colliding[n++] = open[i];
    }
    if (p->n_undecided > 0)
        timeline_add_host(&p->times, "decide", (double)(clock_steady_ns() - begun) * 1e-6);
    return n;
}

// The undecided are decided while the pairs travel, and follow them once they
// are there.
static bool fetch_and_decide(part *p, const part_task *task, duet_pair *colliding, duet_error *err)
{
    duet_pair *pairs = NULL;
    const duet_pair *open = NULL;
    uint64_t n = part_count(p, COUNT_PAIRS);
    uint64_t n_colliding = 0;
    bool ok = reserve_span(p, &pairs, err) && fetch_rest(p, pairs, n, err) &&
              fetch_open(p, &open, colliding, err);
    if (ok)
        n_colliding = decide(p, task, open, colliding);
    ok = ok && timeline_finish(&p->times, err);
    if (ok && n_colliding > 0)
        memcpy(pairs + n, colliding, (size_t)n_colliding * sizeof *pairs);
    p->span = ok ? (duet_span){pairs, n + n_colliding} : (duet_span){0};
    return ok;
}

bool part_fetch(part *p, const part_task *task, duet_error *err)
{
    p->n_undecided = part_count(p, COUNT_UNDECIDED);
    size_t bytes = (size_t)p->n_undecided * sizeof(duet_pair);
    duet_pair *colliding = malloc(bytes + 1);
    if (!colliding)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %zu bytes", bytes);
    bool ok = fetch_and_decide(p, task, colliding, err);
    free(colliding);
    return ok;
}

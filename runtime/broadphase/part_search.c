// SPDX-License-Identifier: MIT
// How a part finds the pairs of its objects: it searches, tests, counts, brings pairs to the host
// and decides those that float left open.
#include "runtime/broadphase/part.h"

#include "base/clock.h"
#include "base/error.h"
#include "kernels/grid/pair_counts.h"

#include <stdlib.h>
#include <string.h>

part_found part_found_of(const uint32_t counts[COUNTERS])
{
    part_found found = {
        .candidates = (uint64_t)counts[COUNT_CANDIDATES + 1] << 32 | counts[COUNT_CANDIDATES],
        .pairs = (uint64_t)counts[COUNT_PAIRS + 1] << 32 | counts[COUNT_PAIRS],
        .undecided = (uint64_t)counts[COUNT_UNDECIDED + 1] << 32 | counts[COUNT_UNDECIDED],
        .tested = (uint64_t)counts[COUNT_TESTED + 1] << 32 | counts[COUNT_TESTED],
        .bad = counts[COUNT_BAD],
        .first_bad = ~counts[FIRST_BAD],
        .placed = counts[COUNT_PLACED],
    };
    memcpy(&found.widest, &counts[WIDEST], sizeof found.widest);
    return found;
}

// Waits for all that was launched.
static bool read_counters(part *p, duet_error *err)
{
    uint32_t counts[COUNTERS];
    bool ok = timeline_read(&p->times, "fetch pairs", &p->counters, counts, sizeof counts, err);
    if (ok)
        p->result.found = part_found_of(counts);
    return ok;
}

// ---------------------------------------------------------------- searching

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

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

// Objects around which to search, at most.
static uint32_t search_work(const part *p)
{
    const part_range *r = &p->task.range;
    return (uint32_t)smaller(r->last, smaller(r->expected, p->task.objects.n)) - r->first;
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
    bool decides = p->variant.search == SEARCH_SIMD && p->kernels.fused;
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

// A device with memory of its own sends as many pairs as the last step had right behind the search,
// before the host knows how many there are: asking first takes as long as a tenth of the pairs.

// Undecided pairs that are read early; there are mostly fewer.
enum { OPEN_EARLY = 1024 };

// Read early besides the pairs.
typedef struct early_read {
    uint32_t counters[COUNTERS];
    uint32_t pair_counts[PAIR_COUNTS];
    duet_pair open[OPEN_EARLY];
} early_read;

// If pairs are counted, only those that are left travel.
static buffer *pairs_to_fetch(part *p)
{
    return p->task.ids ? &p->left : &p->pairs;
}

static uint64_t count_to_fetch(const part *p)
{
    return p->task.ids ? p->result.counted.left : p->result.found.pairs;
}

// The counters come first: the host goes on with them while the pairs travel.
static bool start_early_read(part *p, cl_event *counters_read, duet_error *err)
{
    buffer *pairs = pairs_to_fetch(p);
    size_t open_bytes = smaller(p->undecided.bytes, sizeof((early_read *)0)->open);
    size_t bytes = smaller(p->pairs_early * sizeof(duet_pair), p->fetched.size);
    bytes = smaller(bytes, pairs->bytes);
    if (!host_block_reserve(&p->early, p->device, 1, sizeof(early_read), err))
        return false;
    early_read *n = p->early.bytes;
    p->pairs_early = bytes / sizeof(duet_pair);
    bool ok =
        timeline_start_read(&p->times, "fetch pairs", &p->undecided, 0, n->open, open_bytes, err) &&
        (!p->task.ids || timeline_start_read(&p->times, "fetch pairs", &p->pair_counts, 0,
                                             n->pair_counts, sizeof n->pair_counts, err)) &&
        timeline_start_read(&p->times, "fetch pairs", &p->counters, 0, n->counters,
                            sizeof n->counters, err);
    *counters_read = timeline_last_event(&p->times);
    return ok &&
           timeline_start_read(&p->times, "fetch pairs", pairs, 0, p->fetched.bytes, bytes, err);
}

// It reads itself how many pairs there are, and counts those that had a place.
static bool count_pairs(part *p, duet_error *err)
{
    return timeline_fill(&p->times, "count pairs", &p->pair_counts, 0, 0, PAIR_COUNTS, err) &&
           timeline_launch(&p->times, "count pairs", p->kernels.count_pairs, p->args.pair_capacity,
                           p, err);
}

static uint64_t wide(const uint32_t *words)
{
    return (uint64_t)words[1] << 32 | words[0];
}

// All that the host reads of memory that it shares with the device.
static bool see_found(part *p, duet_error *err)
{
    const buffer *const found[] = {&p->requests.words, &p->undecided, &p->pairs, &p->counters};
    bool ok = timeline_see(&p->times, "fetch pairs", found, sizeof found / sizeof found[0], err);
    if (ok)
        p->result.found = part_found_of(p->counters.host);
    return ok;
}

static bool read_found(part *p, duet_error *err)
{
    cl_event counters_read = NULL;
    if (p->device->info.host_memory)
        return see_found(p, err);
    if (p->task.pairs_on_device)
        return read_counters(p, err);
    if ((p->task.ids && !count_pairs(p, err)) || !start_early_read(p, &counters_read, err))
        return false;
    timeline_spin(&p->times, counters_read);
    if (!timeline_collect_to(&p->times, counters_read, err))
        return false;
    const early_read *read = p->early.bytes;
    const uint32_t *counts = read->pair_counts;
    p->result.found = part_found_of(read->counters);
    if (p->task.ids)
        p->result.counted = (part_counted){wide(counts + COUNT_COUNTED),
                                           wide(counts + COUNTED_HASH), wide(counts + COUNT_LEFT)};
    return true;
}

// If candidates are tested as they are found, the narrow kernel gets what a
// group had no space for, which is mostly nothing.
static bool test_listed(part *p, duet_error *err)
{
    if (!p->kernels.narrow)
        return read_found(p, err);
    if (!p->kernels.fused)
        return run_narrow(p, narrow_work(p, search_work(p)), err) && read_found(p, err);
    if (!read_found(p, err))
        return false;
    uint64_t listed = p->result.found.candidates;
    return listed == 0 || listed > capacity_of(&p->candidates) ||
           (run_narrow(p, listed, err) && read_found(p, err));
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
    if (p->task.objects.shape != DUET_SHAPE_BOUNDS)
        ok = ok && (p->undecided.mem || reserve_pairs(p, &p->undecided, guess / 64, err));
    if (p->task.ids)
        ok = ok && (p->left.mem || reserve_pairs(p, &p->left, guess / 64, err)) &&
             buffer_reserve(&p->pair_counts, p->device, PAIR_COUNTS * sizeof(uint32_t), err);
    if (p->kernels.narrow)
        ok = ok &&
             (p->candidates.mem ||
              reserve_pairs(p, &p->candidates, p->kernels.fused ? guess / 64 : 2 * guess, err));
    return ok;
}

static void note_placed(part *p)
{
    if (p->result.found.placed > p->task.range.expected)
        p->state = PART_CROWDED;
}

// A grid with space for fewer objects than there are may get more than it holds, and
// its starts then point past its end. A search that is guarded checks that itself and finds
// nothing, so the host need not wait between grid and search.
static bool check_placed(part *p, duet_error *err)
{
    if (p->task.range.expected >= p->task.objects.n || p->kernels.guarded)
        return true;
    bool ok = read_counters(p, err);
    note_placed(p);
    return ok;
}

// ---------------------------------------------------------------- fetching

// Reserves host memory for the pairs, with space behind them for the undecided.
// A block that must grow loses what was read early, and locking its pages takes longer than a step:
// it grows by more than it must.
static bool reserve_span(part *p, uint64_t n, duet_pair **pairs, duet_error *err)
{
    uint64_t most = n + p->result.found.undecided;
    size_t bytes = (size_t)most * sizeof(duet_pair);
    *pairs = p->pairs.host;
    if (*pairs)
        return true;
    if (bytes > p->fetched.size) {
        p->pairs_early = 0;
        bytes += bytes / 16;
    }
    bool ok = host_block_reserve(&p->fetched, p->device, 1, bytes, err);
    *pairs = p->fetched.bytes;
    return ok;
}

// Starts to read the pairs that were not read early, unless the host has seen them; the next step
// reads a few more than now.
static bool fetch_rest(part *p, buffer *from, duet_pair *pairs, uint64_t n, duet_error *err)
{
    uint64_t there = p->pairs_early;
    bool ok = from->host || there >= n ||
              timeline_start_read(&p->times, "fetch pairs", from, there * sizeof(duet_pair),
                                  pairs + there, (n - there) * sizeof(duet_pair), err);
    p->pairs_early = n + n / 64;
    return ok;
}

static bool fetch_open(part *p, const duet_pair **open, duet_pair *scratch, duet_error *err)
{
    const early_read *n = p->early.bytes;
    bool ahead = n && p->result.n_undecided <= OPEN_EARLY;
    *open = p->undecided.host ? p->undecided.host : ahead ? n->open : scratch;
    return *open != scratch || timeline_read(&p->times, "fetch pairs", &p->undecided, (void *)*open,
                                             p->result.n_undecided * sizeof **open, err);
}

// The objects that the host decides with: all, or if it does not see them the objects of the open
// pairs, two for each.
typedef struct open_objects {
    grid_objects objects;
    void *rows; // gathered; NULL: all are seen
    duet_size *sizes;
} open_objects;

static void free_open_objects(open_objects *o)
{
    free(o->rows);
    free(o->sizes);
}

static bool gather(part *p, const duet_pair *open, open_objects *o, duet_error *err)
{
    size_t row = p->task.objects.row_bytes, n = 2 * (size_t)p->result.n_undecided;
    o->rows = malloc(n * row);
    o->sizes = malloc(n * sizeof *o->sizes);
    if (!o->rows || !o->sizes)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %zu objects", n);
    for (size_t i = 0; p->task.objects.sizes && i < n; ++i)
        o->sizes[i] = p->task.objects.sizes[i % 2 ? open[i / 2].b : open[i / 2].a];
    o->objects.array = o->rows;
    o->objects.sizes = p->task.objects.sizes ? o->sizes : NULL;
    if (!buffer_reserve(&p->gathered, p->device, n * row, err))
        return false;
    p->args.row_words = (cl_uint)(row / sizeof(cl_uint));
    p->args.n_ids = (cl_uint)n;
    return timeline_launch(&p->times, "fetch objects", p->kernels.gather, n, p, err) &&
           timeline_read(&p->times, "fetch objects", &p->gathered, o->rows, n * row, err);
}

static bool see_open_objects(part *p, const duet_pair *open, open_objects *o, duet_error *err)
{
    *o = (open_objects){.objects = p->task.objects};
    return p->task.objects.array || p->result.n_undecided == 0 || gather(p, open, o, err);
}

// Decides on the host what float left open. Returns how many of them collide,
// which are written to colliding, which may be where the open ones are.
static uint64_t decide(part *p, const open_objects *o, const duet_pair *open, duet_pair *colliding)
{
    uint64_t begun = clock_steady_ns();
    uint64_t n = 0;
    for (uint64_t i = 0; i < p->result.n_undecided; ++i) {
        uint32_t first = o->rows ? 2 * (uint32_t)i : open[i].a;
        uint32_t second = o->rows ? first + 1 : open[i].b;
        if (grid_objects_collide(&o->objects, first, second))
            colliding[n++] = open[i];
    }
    if (p->result.n_undecided > 0)
        timeline_add_host(&p->times, "decide", clock_ms_since(begun));
    return n;
}

// The undecided are decided while the pairs travel, and follow them once they
// are there.
static bool fetch_and_decide(part *p, duet_pair *colliding, duet_error *err)
{
    duet_pair *pairs = NULL;
    const duet_pair *open = NULL;
    uint64_t n = count_to_fetch(p);
    uint64_t n_colliding = 0;
    open_objects seen = {0};
    bool ok = reserve_span(p, n, &pairs, err) && fetch_rest(p, pairs_to_fetch(p), pairs, n, err) &&
              fetch_open(p, &open, colliding, err) && see_open_objects(p, open, &seen, err);
    if (ok)
        n_colliding = decide(p, &seen, open, colliding);
    free_open_objects(&seen);
    ok = ok && timeline_finish(&p->times, err);
    if (ok && n_colliding > 0)
        memcpy(pairs + n, colliding, (size_t)n_colliding * sizeof *pairs);
    p->result.span = ok ? (duet_span){pairs, n + n_colliding} : (duet_span){0};
    return ok;
}

// The pairs stay where they are, those that are decided follow them, and the span only
// counts them.
static bool decide_on_device(part *p, duet_pair *colliding, duet_error *err)
{
    uint64_t n_colliding = 0;
    open_objects seen = {0};
    bool ok = timeline_read(&p->times, "fetch pairs", &p->undecided, colliding,
                            p->result.n_undecided * sizeof *colliding, err) &&
              see_open_objects(p, colliding, &seen, err);
    if (ok)
        n_colliding = decide(p, &seen, colliding, colliding);
    free_open_objects(&seen);
    p->result.span.n = p->result.found.pairs + n_colliding;
    return ok &&
           timeline_write_at(&p->times, "send pairs", &p->pairs,
                             p->result.found.pairs * sizeof *colliding, colliding,
                             (size_t)n_colliding * sizeof *colliding, err) &&
           timeline_finish(&p->times, err);
}

static bool fetch(part *p, duet_error *err)
{
    p->result.n_undecided = p->result.found.undecided;
    size_t bytes = (size_t)p->result.n_undecided * sizeof(duet_pair);
    duet_pair *colliding = malloc(bytes + 1);
    if (!colliding)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no host memory for %zu bytes", bytes);
    bool ok = p->task.pairs_on_device ? decide_on_device(p, colliding, err)
                                      : fetch_and_decide(p, colliding, err);
    free(colliding);
    return ok;
}

bool part_search(part *p, duet_error *err)
{
    if (p->task.range.first >= p->task.range.last)
        return read_counters(p, err) && timeline_finish(&p->times, err);
    bool ok = check_placed(p, err) && reserve_first(p, search_work(p), err);
    bool fits = false;
    while (ok && p->state != PART_CROWDED && !fits) {
        ok = search_once(p, err) && under_limit(p, err) && everything_fits(p, &fits, err);
        note_placed(p);
    }
    if (!ok || p->state == PART_CROWDED)
        return ok;
    p->result.n_candidates = p->kernels.listed
                                 ? p->result.found.pairs
                                 : p->result.found.candidates + p->result.found.tested;
    return fetch(p, err);
}

// The pairs that the host decided stand at the span's end, and nowhere else.
bool part_read_counted(part *p, duet_error *err)
{
    uint64_t n = p->result.found.pairs, n_decided = p->result.span.n - p->result.counted.left;
    if (p->result.counted.n == 0)
        return true;
    duet_pair *decided = malloc((size_t)n_decided * sizeof *decided + 1);
    if (!decided)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%llu pairs: no memory",
                         (unsigned long long)n_decided);
    if (n_decided > 0)
        memcpy(decided, p->result.span.pairs + p->result.counted.left,
               (size_t)n_decided * sizeof *decided);
    bool ok = host_block_reserve(&p->fetched, p->device, 1,
                                 (size_t)(n + n_decided) * sizeof *decided, err) &&
              timeline_read(&p->times, "fetch pairs", &p->pairs, p->fetched.bytes,
                            (size_t)n * sizeof *decided, err) &&
              timeline_finish(&p->times, err);
    duet_pair *all = p->fetched.bytes;
    if (ok && n_decided > 0)
        memcpy(all + n, decided, (size_t)n_decided * sizeof *decided);
    free(decided);
    p->result.span = ok ? (duet_span){all, n + n_decided} : (duet_span){0};
    p->result.counted = (part_counted){0};
    return ok;
}

// SPDX-License-Identifier: MIT
#include "runtime/broadphase/part_fetch.h"

#include "base/clock.h"
#include "base/error.h"
#include "kernels/grid/pair_counts.h"

#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- what was found

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

bool part_read_counters(part *p, duet_error *err)
{
    uint32_t counts[COUNTERS];
    bool ok = timeline_read(&p->times, "fetch pairs", &p->counters, counts, sizeof counts, err);
    if (ok)
        p->result.found = part_found_of(counts);
    return ok;
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

bool part_read_found(part *p, duet_error *err)
{
    cl_event counters_read = NULL;
    if (p->device->info.host_memory)
        return see_found(p, err);
    if (p->task.pairs_on_device)
        return part_read_counters(p, err);
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

// ---------------------------------------------------------------- pairs

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
    void *rows;       // gathered; NULL: all are seen
    duet_size *sizes; // NULL: the rows have theirs
} open_objects;

static void free_open_objects(open_objects *o)
{
    free(o->rows);
    free(o->sizes);
}

static bool gather(part *p, const duet_pair *open, open_objects *o, duet_error *err)
{
    const duet_size *sizes = p->task.objects->sizes.rows;
    size_t row = p->task.objects->all.row_bytes, n = 2 * (size_t)p->result.n_undecided;
    o->rows = malloc(n * row);
    o->sizes = sizes ? malloc(n * sizeof *o->sizes) : NULL;
    if (!o->rows || (sizes && !o->sizes))
        return no_memory(err, "%zu objects", n);
    for (size_t i = 0; sizes && i < n; ++i)
        o->sizes[i] = sizes[i % 2 ? open[i / 2].b : open[i / 2].a];
    o->objects.all.rows = o->rows;
    o->objects.sizes.rows = o->sizes;
    if (!buffer_reserve(&p->gathered, p->device, n * row, err))
        return false;
    p->args.row_words = (cl_uint)(row / sizeof(cl_uint));
    p->args.n_ids = (cl_uint)n;
    return timeline_launch(&p->times, "fetch objects", p->kernels.gather, n, p, err) &&
           timeline_read(&p->times, "fetch objects", &p->gathered, o->rows, n * row, err);
}

static bool see_open_objects(part *p, const duet_pair *open, open_objects *o, duet_error *err)
{
    *o = (open_objects){.objects = *p->task.objects};
    return o->objects.all.rows || p->result.n_undecided == 0 || gather(p, open, o, err);
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
    open_objects objects = {0};
    bool ok = reserve_span(p, n, &pairs, err) && fetch_rest(p, pairs_to_fetch(p), pairs, n, err) &&
              fetch_open(p, &open, colliding, err) && see_open_objects(p, open, &objects, err);
    if (ok)
        n_colliding = decide(p, &objects, open, colliding);
    free_open_objects(&objects);
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
    open_objects objects = {0};
    bool ok = timeline_read(&p->times, "fetch pairs", &p->undecided, colliding,
                            p->result.n_undecided * sizeof *colliding, err) &&
              see_open_objects(p, colliding, &objects, err);
    if (ok)
        n_colliding = decide(p, &objects, colliding, colliding);
    free_open_objects(&objects);
    p->result.span.n = p->result.found.pairs + n_colliding;
    return ok &&
           timeline_write_at(&p->times, "send pairs", &p->pairs,
                             p->result.found.pairs * sizeof *colliding, colliding,
                             (size_t)n_colliding * sizeof *colliding, err) &&
           timeline_finish(&p->times, err);
}

bool part_fetch(part *p, duet_error *err)
{
    p->result.n_undecided = p->result.found.undecided;
    size_t bytes = (size_t)p->result.n_undecided * sizeof(duet_pair);
    duet_pair *colliding = malloc(bytes + 1);
    if (!colliding)
        return no_memory(err, "%zu bytes", bytes);
    bool ok = p->task.pairs_on_device ? decide_on_device(p, colliding, err)
                                      : fetch_and_decide(p, colliding, err);
    free(colliding);
    return ok;
}

// The pairs that the host decided stand at the span's end, and nowhere else.
bool part_read_counted(part *p, duet_error *err)
{
    uint64_t n = p->result.found.pairs, n_there = count_to_fetch(p);
    if (n_there == n)
        return true;
    uint64_t n_decided = p->result.span.n - n_there;
    duet_pair *decided = malloc((size_t)n_decided * sizeof *decided + 1);
    if (!decided)
        return no_memory(err, "%llu pairs", (unsigned long long)n_decided);
    if (n_decided > 0)
        memcpy(decided, p->result.span.pairs + n_there, (size_t)n_decided * sizeof *decided);
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
    p->result.counted = (part_counted){.left = n};
    return ok;
}

// SPDX-License-Identifier: MIT
// Bringing what a search found to the host.
//
// A device with memory of its own sends as many pairs as the last step had
// right behind the search, before anyone has asked how many there are: asking
// first takes as long as a tenth of the pairs.
#include "runtime/broadphase/part.h"

#include "base/clock.h"
#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/origin.h"

#include <stdlib.h>
#include <string.h>

// Undecided pairs that are sent unasked; there are mostly fewer.
enum { OPEN_AHEAD = 1024 };

// What is sent unasked besides the pairs.
typedef struct news {
    uint32_t counters[COUNTERS];
    duet_pair open[OPEN_AHEAD];
} news;

static size_t smaller(size_t a, size_t b)
{
    return a < b ? a : b;
}

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

// SPDX-License-Identifier: MIT
// Finds the pairs among the objects of a search set: a device pair, the plain C reference, or in a
// forecast nothing, in the time that devices would take.
#ifndef CLUSTER_WORKER_H
#define CLUSTER_WORKER_H

#include "kernels/grid/interior.h"
#include "runtime/broadphase/global_ids.h"
#include "runtime/duet.h"

typedef struct worker worker;

// Pairs that were found, by places in the objects' array, a < b. The worker's until it finds again.
typedef struct worker_found {
    duet_span spans[2];
    uint64_t n_counted; // pairs that are in no span,
    uint64_t hash;      // and their pair hash by global ids
    bool has_bad;       // an object that its devices refuse
    uint32_t first_bad;
} worker_found;

enum { WORKER_ORDER_SCRATCH = 16 };

// Its objects lie in its own memory, where the caller writes them.
struct worker {
    const char *name; // its devices' selectors, "A,B", or the one device's

    // Space for n objects, which are to be written before the next find. If there were as many
    // before they are still there.
    void *(*map)(worker *w, uint32_t n, duet_error *err);
    // Space for n objects, of which the first `kept` stay; the others are to be written. NULL
    // without memory: those are where they were.
    void *(*extend)(worker *w, uint32_t n, uint32_t kept, duet_error *err);
    // The first n objects are written and stay so: they may be on their way to the devices while
    // others are written behind them.
    void (*begin)(worker *w, uint32_t n);

    // Begins to classify which of these lie deep inside of a box; false if the host must look at
    // all.
    bool (*find_interior)(worker *w, const float inside_lower[3], const float inside_upper[3]);
    // Waits for blocks of objects from `from` on, 0 at first. Returns up to which object they are
    // there.
    uint32_t (*await_interior)(worker *w, uint32_t from, const interior_block **blocks);
    // Finds the order in which objects are best kept: order[i] becomes the one that comes i-th, by
    // so many threads, with the caller's. scratch has WORKER_ORDER_SCRATCH bytes for each.
    bool (*order)(worker *w, uint32_t n_threads, uint32_t *order, void *scratch, duet_error *err);

    // Uses the grid that was fitted to the objects of that domain before, if there is one.
    bool (*use_grid)(worker *w, uint32_t domain, duet_error *err);
    // Fits all grids anew: the objects lie elsewhere than before.
    void (*forget_grids)(worker *w);

    // Finds all pairs. ids: of the first objects, whose pairs with each other a device may count
    // and keep; NULL: all pairs are brought.
    bool (*find)(worker *w, const global_ids *ids, worker_found *found, duet_error *err);
    // Brings the pairs that the last find counted into its spans.
    bool (*bring)(worker *w, worker_found *found, duet_error *err);

    bool (*set_level)(worker *w, duet_level level, duet_error *err);
    bool (*set_plan)(worker *w, const duet_plan *plan, duet_error *err);
    duet_plan (*plan)(const worker *w);
    bool (*load_profile)(worker *w, const char *path, duet_profile *profile, duet_error *err);
    void (*close)(worker *w);
};

worker *worker_open_pair(const duet_world_def *def, duet_error *err);

// Finds pairs by the plain C reference; or nothing, in the time that a simulation says. s NULL:
// none.
struct simulation;
worker *worker_open_plain(const duet_world_def *def, const struct simulation *s, duet_error *err);

#endif

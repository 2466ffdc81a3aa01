// SPDX-License-Identifier: MIT
// What finds the pairs among the objects that a rank sees, homes and ghosts alike: its device
// pair, or the plain C reference, or nothing but what its devices would take.
#ifndef CLUSTER_WORKER_H
#define CLUSTER_WORKER_H

#include "kernels/grid/skim.h"
#include "runtime/broadphase/global_ids.h"
#include "runtime/duet.h"

typedef struct worker worker;

// What was found, by places in the objects' array, a < b. The worker's until it finds again.
typedef struct worker_found {
    duet_span spans[2];
    uint64_t n_counted; // pairs that are in no span,
    uint64_t hash;      // and their pair hash by global ids
    bool has_bad;       // an object that its devices refuse
    uint32_t first_bad;
} worker_found;

enum { WORKER_ORDER_SCRATCH = 16 };

struct worker {
    const char *name; // of its devices, "A,B", or of the one
    // Space for n objects, which are to be written before the next find. Where there were as many
    // before they are still there.
    void *(*map)(worker *w, uint32_t n, duet_error *err);
    // The first n that were mapped are written and stay so: they may be on their way to the
    // devices while others are written behind them. So may ids, which tell_ids will name (NULL:
    // none).
    void (*begin)(worker *w, uint32_t n, const global_ids *ids);
    // Which of these lie deep inside of a box, found where they are on their way to: NULL, or
    // false, where the host must look at all. The other one waits for the blocks of objects from
    // `from` on, 0 at first, and returns up to which object they are there.
    bool (*skim)(worker *w, const float inside_lower[3], const float inside_upper[3]);
    uint32_t (*await_skim)(worker *w, uint32_t from, const skim_block **blocks);
    // Space for n objects, of which the first `kept` stay; the others are to be written.
    void *(*extend)(worker *w, uint32_t n, uint32_t kept, duet_error *err);
    // Of the objects that were mapped and written, the order in which they are best kept:
    // order[i] becomes the one that comes i-th, by so many threads, with the caller's. scratch is
    // memory of WORKER_ORDER_SCRATCH bytes for each. NULL: any.
    bool (*order)(worker *w, uint32_t n_threads, uint32_t *order, void *scratch, duet_error *err);
    // The objects lie elsewhere than those before: a grid that was fitted to these is of no use.
    void (*move)(worker *w);
    // From here on the objects are those of another place, numbered from 0, where the grid that was
    // fitted to its last ones is used again; NULL: it has none.
    bool (*turn_to)(worker *w, uint32_t place, duet_error *err);
    bool (*find)(worker *w, worker_found *found, duet_error *err);
    // Before that: which objects are at home, and their ids. Pairs of two of these are then counted
    // where they are found, and stay there. NULL: all are brought.
    void (*tell_ids)(worker *w, const global_ids *ids);
    // Those that the last find counted come into its spans.
    bool (*bring)(worker *w, worker_found *found, duet_error *err);
    // Whether it leaves the host's processors to others; NULL: not.
    bool (*spares_host)(const worker *w);
    bool (*set_level)(worker *w, duet_level level, duet_error *err);
    bool (*set_plan)(worker *w, const duet_plan *plan, duet_error *err);
    duet_plan (*plan)(const worker *w); // that it has; NULL: it needs none
    bool (*load_profile)(worker *w, const char *path, duet_profile *profile, duet_error *err);
    void (*close)(worker *w);
};

worker *worker_open_pair(const duet_world_def *def, duet_error *err);
worker *worker_open_plain(const duet_world_def *def, duet_error *err);

// Finds nothing, in the time that the simulation says.
struct simulation;
worker *worker_open_simulated(const duet_world_def *def, const struct simulation *s,
                              duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// A scene's bodies in motion over all ranks: the bits of one motion, wherever the domains' borders
// lie.
//
// All calls but moving_end are collective. A rank that failed, as `own` says, takes part in them,
// and they return whether no rank had; after that a rank may have failed alone, as own says then.
#ifndef CLUSTER_MOVING_H
#define CLUSTER_MOVING_H

#include "cluster/moving_phases.h"
#include "cluster/ranks.h"
#include "runtime/dynamics/pair_list.h"

typedef struct moving moving;

typedef struct moving_counts {
    uint64_t step;     // steps taken
    uint64_t bodies;   // of all ranks, as are
    uint64_t contacts; // that push
    uint64_t ghosts;
    // By this rank, so far: bodies whose states were read, and rows of bodies; contacts that waited
    // for colours which others decide as well, and how often one was told to another rank; and
    // contacts of ghosts that it sent as bodies were exchanged.
    uint64_t read, sent, waited, told, shared;
    uint32_t colours;
    double slowest_ms, mean_ms; // that ranks were busy in the last step
    uint32_t slowest_rank;      // of the last steps that were compared
} moving_counts;

// This rank tells of the last step: contacts whose owner one of its domains owned then. All ascend,
// and the memory is the motion's, until the next call that changes it.
typedef struct moving_told {
    const pair_changes *changes;
    const duet_hit_event *hits;
    size_t n_hits;
} moving_told;

// Says what a motion over ranks begins with. plan NULL: the default one; resume NULL: the scene's
// beginning, else a file that moving_save wrote, which rank 0 reads.
typedef struct moving_start {
    const char *path;
    const duet_setting *settings;
    uint32_t n_settings;
    const char *resume;
    duet_device_pair *pair;
    const duet_plan *plan;
    uint32_t parts; // domains of each rank
} moving_start;

// Reads the scene on rank 0 and divides its bodies among domains. Returns NULL on all ranks
// after a failure of one.
moving *moving_begin(ranks *r, const moving_start *start, duet_error *own);
void moving_end(moving *m);

bool moving_step(moving *m, duet_error *own);

// The colours after which ghosts come at the latest; from the next step on so many, which changes
// no bit of it.
uint32_t moving_get_every(const moving *m);
bool moving_set_every(moving *m, uint32_t every, duet_error *own);
bool moving_hash(moving *m, uint64_t *hash, duet_error *own);

// Makes *whole a motion of all bodies on rank 0, to be destroyed, and NULL on others. A rank may
// have failed alone after it.
bool moving_gather(moving *m, duet_motion **whole, duet_error *own);

// Rank 0 writes all of it into one file, for which it needs memory for all bodies.
bool moving_save(moving *m, const char *path, duet_error *own);
moving_counts moving_get_counts(const moving *m);
const phase_cost *moving_get_costs(const moving *m); // [MOVING_PHASES]
moving_told moving_get_told(const moving *m);

// A domain of this rank, k of its parts, for who reads it: the motion of its own bodies and of
// others, and of each place the id of an own body, else DUET_NO_BODY. Not collective.
duet_motion *moving_get_motion(const moving *m, uint32_t k);
void moving_get_own_ids(const moving *m, uint32_t k, uint64_t *ids);

#endif

// SPDX-License-Identifier: MIT
// A query of a scene's objects as a machine that plans are measured on: of a plan only the share
// counts.
#ifndef TUNER_MEASURE_QUERY_H
#define TUNER_MEASURE_QUERY_H

#include "runtime/queries/any_query.h"
#include "tuner/measure.h"

typedef struct measure_query {
    duet_tree *tree; // holds the scene's objects
    query_name name;
    void *items; // drawn among the objects
    uint64_t n;
    any_query *query;
    core_watch *cores; // NULL: nobody looks at other programs
} measure_query;

// n items, drawn by the seed. All is to be closed, also after a failure.
bool measure_query_open(measure_query *q, duet_device_pair *pair, const duet_scene *scene,
                        const query_name *name, uint64_t n, uint64_t seed, duet_error *err);
void measure_query_close(measure_query *q);

// q must live as long as the machine. hash is that of the right hits.
measure_machine measure_query_machine(measure_query *q, uint64_t hash);

// By device B alone: hits are the same at every share, which each launch is checked for.
bool measure_query_right(measure_query *q, uint64_t *hash, uint64_t *n_hits, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// A query of any kind, by its name: for whoever asks a tree what another one chose. The public
// queries are such ones, each under a name of its own.
#ifndef RUNTIME_ANY_QUERY_H
#define RUNTIME_ANY_QUERY_H

#include "runtime/duet.h"
#include "runtime/queries/query_name.h"

typedef struct tree_query any_query;

// The result of a run, like the public queries'; the query's, until its next run.
typedef struct query_result {
    const uint32_t *hits;
    const float *normals; // [n_hits][3], for rays that ask for them; else NULL
    uint64_t n_hits;
    uint64_t undecided;
    double total_ms;
    double device_ms[2];
} query_result;

typedef struct any_query_def {
    query_name name;
    duet_level level; // boxes only
    bool normals;     // rays only
    const duet_filter *filter;
} any_query_def;

any_query *any_query_create(duet_tree *tree, const any_query_def *def, duet_error *err);
void any_query_destroy(any_query *q); // NULL is fine

// n items as the public call takes them, of the tree's kind. BAD_OBJECT names the first that the
// kernel takes for none.
bool any_query_run(any_query *q, const void *items, uint64_t n, query_result *found,
                   duet_error *err);

// Runs duet_box_query_run_itself; for boxes.
bool any_query_run_itself(any_query *q, const duet_filter *filters, uint64_t n, query_result *found,
                          duet_error *err);

size_t query_hit_bytes(query_item item);

#endif

// SPDX-License-Identifier: MIT
// A run that `duet cluster --keep` stored, for simulated ranks.
#ifndef CLI_CLUSTER_STORED_RUN_H
#define CLI_CLUSTER_STORED_RUN_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct stored_run {
    char uid[72]; // its first digits name it
    char scene[256];
    char level[16];
    uint32_t dims;
    uint64_t n;
    uint32_t parts;
    bool resident;
    uint32_t hosts;
    uint32_t ranks;
    double latency_ns; // of a message; 0: it had one rank
    double byte_ns;    // of each of its bytes
    // [n_seconds] What a step takes of each home that a rank has, seconds, but for the time that
    // all ranks waited for messages. Those with homes, in order.
    double *object_seconds;
    uint32_t n_seconds;
    // [n_seconds] Of ranks apart, which did not share the objects: how much longer a step takes
    // each of k + 1 of them on a host than the first by itself, whose all times above are. NULL: no
    // such run.
    double *company;
} stored_run;

// What a ghost takes of a rank, in homes: others' owners are looked up for its pairs, and somebody
// has to send it.
#define STORED_RUN_GHOST 3.0

// Reads the run of the user's store whose uid begins with `uid`. *found is false if there is none,
// or if a profile's uid begins so too. BAD_INPUT if the run has an impossible number.
bool stored_run_read(stored_run *run, const char *uid, bool *found, duet_error *err);
void stored_run_end(stored_run *run);

// Whether the time is possible: above 0, and no longer than a step can take.
bool stored_time_can_be(double object_seconds);

#endif

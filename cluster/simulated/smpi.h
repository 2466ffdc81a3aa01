// SPDX-License-Identifier: MIT
// Ranks that SimGrid simulates, all in this process and one after the other.
#ifndef CLUSTER_SIMULATED_SMPI_H
#define CLUSTER_SIMULATED_SMPI_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

// Runs `body` on n ranks, which MPI connects, dealt out in turn to the hosts of the platform in
// that file. May be called once in a process.
bool smpi_run(const char *platform, int n, void (*body)(void *context), void *context,
              duet_error *err);

// Between the two, on one rank: lets simulated time pass for it alone.
void smpi_pass(double seconds);

// Memory of that size that costs nothing, and whose bytes are not carried.
void *smpi_ballast(uint64_t bytes);

#endif

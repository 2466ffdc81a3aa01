// SPDX-License-Identifier: MIT
// A platform of SimGrid's made from a measured network.
#ifndef CLUSTER_SIMULATED_PLATFORM_H
#define CLUSTER_SIMULATED_PLATFORM_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

// Any message takes latency + bytes / bandwidth. Hosts hang on one switch, each by a link that its
// messages to and from other hosts share; those within a host share nothing.
typedef struct platform {
    uint32_t hosts;
    double latency_s;
    double bytes_a_second;
} platform;

// The file that smpi_run reads, in memory: it is gone with the process. Call platform_close once it
// is read.
typedef struct platform_file {
    char path[32];
    int file; // negative: there is none
} platform_file;

bool platform_write(platform_file *f, const platform *p, duet_error *err);
void platform_close(platform_file *f);

#endif

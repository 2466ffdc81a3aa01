// SPDX-License-Identifier: MIT
// The energy that the machine's processors have used, by what the system lets one read.
//
// NVIDIA's GPUs count it themselves (NVML, of which nothing is needed when Duet is built); packages
// of CPUs do in /sys/class/powercap, which mostly root alone can read. In the place of both, a file
// can say it: for tests, and for meters that a script of one's own reads.
#ifndef BASE_ENERGY_METER_H
#define BASE_ENERGY_METER_H

#include "base/error.h"

#include <stdint.h>

typedef struct energy_meter energy_meter;

// The file has a number, then J, of the joules used until now; or W, of watts since it was opened.
typedef struct energy_meter_def {
    const char *file;     // NULL: the system's counters are read
    const char *powercap; // a folder like /sys/class/powercap
    const char *nvml;     // the library
    const char *gpus[2];  // names of the GPUs that count; NULL: none
} energy_meter_def;

// The file that DUET_ENERGY names, or else the system's counters, without GPUs.
energy_meter_def energy_meter_default_def(void);

// NULL with NOT_FOUND if nothing can be read: the line says what was tried.
energy_meter *energy_meter_open(const energy_meter_def *def, duet_error *err);
void energy_meter_close(energy_meter *m); // NULL does nothing

// Joules of all that is read, since some moment.
double energy_meter_read(energy_meter *m);

// The part of it that moves in the longest steps: of GPUs, if any are read.
double energy_meter_slowest(energy_meter *m);

// Names what is read: "NVIDIA H200, package-0".
const char *energy_meter_describe(const energy_meter *m);

// How long to let something run between two readings, at least: counters move in steps.
uint64_t energy_meter_window_ns(const energy_meter *m);

#endif

// SPDX-License-Identifier: MIT
// A world as the profile store knows it: its devices, its workload, its
// kernels.
#ifndef RUNTIME_PROFILED_H
#define RUNTIME_PROFILED_H

#include "profiles/lookup.h"
#include "runtime/world.h"

typedef struct profiled {
    profile_pair pair; // its strings are the device pair's, or lie in parts
    profile_workload workload;
    char parts[2][24];         // "0-0" of a part of a CPU
    char kernels[PROFILE_SHA]; // of all kernel text
} profiled;

// Looks at every object. BAD_ARGUMENT for a world without objects.
bool profiled_world(const duet_world *world, profiled *p, duet_error *err);

// p must live as long as the request is used.
profile_request profiled_request(const profiled *p);

// A stored plan, and one to store, measured at that level of accuracy. BAD_INPUT
// for a mode that there is not.
bool profiled_read_plan(const profile_plan *stored, duet_plan *plan, duet_error *err);
profile_plan profiled_write_plan(const duet_plan *plan, const char *level);

#endif

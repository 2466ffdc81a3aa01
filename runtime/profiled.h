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
    char parts[2][24];               // "0-0" of a part of a CPU
    char kernels[PROFILE_SHA];       // of all kernel text
    const char *levels[DUET_LEVELS]; // that may be within the accuracy asked for
    uint32_t n_levels;               // 0: the workload's own level is asked for
    duet_accuracy accuracy;
} profiled;

// A workload whose level is chosen by an accuracy is stored as of this level.
#define PROFILED_ANY_LEVEL "auto"

// Looks at every object. BAD_ARGUMENT for a world without objects.
bool profiled_world(const duet_world *world, profiled *p, duet_error *err);

// From here on it is the workload at that level, whatever was asked for.
void profiled_settle(profiled *p, duet_level level);

// p must live as long as the request is used.
profile_request profiled_request(const profiled *p);

// The level that the store knows by that name. BAD_INPUT where there is none.
bool profiled_read_level(const char *name, duet_level *level, duet_error *err);

// A stored plan, and one to store, measured at that level of accuracy. BAD_INPUT
// for a mode that there is not.
bool profiled_read_plan(const profile_plan *stored, duet_plan *plan, duet_error *err);
profile_plan profiled_write_plan(const duet_plan *plan, const char *level);

#endif

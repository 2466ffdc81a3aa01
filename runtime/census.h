// SPDX-License-Identifier: MIT
// What of a world's objects decides how long a step takes: the workload that
// profiles are kept for. It is the scene's, whatever grid a plan makes of it.
#ifndef RUNTIME_CENSUS_H
#define RUNTIME_CENSUS_H

#include "profiles/workload.h"
#include "runtime/world.h"

// The world has objects. Takes about as long as reading them once.
profile_workload census(const duet_world *world);

#endif

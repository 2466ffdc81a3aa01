// SPDX-License-Identifier: MIT
// A profile that is chosen for more than one pair. For one pair duet_motion_load_profile and its
// like choose.
#ifndef RUNTIME_CHOOSE_PROFILE_H
#define RUNTIME_CHOOSE_PROFILE_H

#include "runtime/duet.h"

// Chooses the plan of a motion m that is a part of one over ranks, by the objective that its tuning
// had. The motion keeps the plan that it has; path is duet_world_load_profile's.
bool choose_over_ranks(const duet_motion *m, const char *objective, const char *path,
                       duet_profile *profile, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// Profiles as people see them: each row of a query as an object, whose members are the query's
// columns.
#ifndef PROFILES_PROFILE_VIEW_H
#define PROFILES_PROFILE_VIEW_H

#include "profiles/store.h"

#include <cjson/cJSON.h>

// Adds live profiles and then, if asked for, the dead ones to a list, each by pair and by size; only
// those whose uid begins with `uid`. more: columns besides, as ", p.pair_id", or "".
bool profile_view_add(store *s, const char *uid, bool dead_too, const char *more, cJSON *list,
                      duet_error *err);

// Adds "session", from which the profile of that uid comes; nothing if it has none.
bool profile_view_add_session(store *s, const char *uid, cJSON *o, duet_error *err);

// Adds "trials" of that session and, if energy was measured, "pareto": the plans that no other beats
// in both time and energy.
bool profile_view_add_trials(store *s, const char *uid, cJSON *o, duet_error *err);

#endif

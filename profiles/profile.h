// SPDX-License-Identifier: MIT
// A profile: the plan that a search chose, with what it is worth and why; how
// people are shown it; and what each level of accuracy costs on a workload.
#ifndef PROFILES_PROFILE_H
#define PROFILES_PROFILE_H

#include "profiles/session.h"

typedef struct profile_row {
    int64_t pair_id;
    int64_t workload_id;
    const char *kernels;   // the session's
    const char *objective; // "time"
    profile_plan plan;
#define FIGURE(type, name) type name;
#define WORD(name) const char *name; // best_mode NULL: the plan is that one
#define COUNT(name) int64_t name;
#include "profiles/profile_figures.inl"
    const char *terms;    // the best plan's, a JSON object as a trial's; NULL: not known
    const char *origin;   // "measured", "online" or "manual"
    const char *session;  // NULL only for "manual"
    int64_t trial_number; // the plan's trial in that session; -1: none
} profile_row;

// A plan that was not raced often enough is never loaded.
#define PROFILE_TOO_FEW_ROUNDS "too few rounds for a verdict"

// The place that a row got.
typedef struct profile_placed {
    char uid[PROFILE_ID];
    char unused[128]; // why it is not live; empty: it is
} profile_placed;

// Stores it. It becomes the live profile of its pair, workload, kernels,
// objective and level, unless `unused` (else NULL) says why not, or one that
// is live has better evidence (it was measured beside fewer other programs, it has a
// verdict, as `faster` says more than `same`, more rounds, a narrower interval), or
// was searched with other options and has the faster step for sure. A profile that was
// measured in quiet always replaces one that was not. One that was live stays in the store, dead
// for `reason`. placed may be NULL.
bool profile_put(store *s, const profile_row *row, const char *unused, const char *reason,
                 profile_placed *placed, duet_error *err);

// The one profile whose uid begins with `uid`. BAD_ARGUMENT for none or
// several.
bool profile_find(store *s, const char *uid, char whole[PROFILE_ID], duet_error *err);

// Makes a stored profile the live one of its key. BAD_ARGUMENT for one without a
// verdict.
bool profile_use(store *s, const char *uid, duet_error *err);

// Removes a profile; its session and trials stay.
bool profile_forget(store *s, const char *uid, duet_error *err);

#endif

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

// ---------------------------------------------------------------- as people see it

typedef struct profile_entry_device {
    const char *name;
    const char *part; // NULL: the whole device
    const char *driver;
    const char *platform_version;
} profile_entry_device;

// The session that a profile comes from; all NULL and 0 if it has none.
typedef struct profile_entry_session {
    const char *id;
    const char *state;
    const char *strategy;
    const char *options; // JSON
    const char *script;  // its text; NULL: none
    const char *tool_version;
    const char *host;
    int64_t seed;
    int64_t resumed; // how often
    int64_t trials;
    int64_t launches;
    double load;
    double timer_ns;
    int64_t started_ns;
    int64_t ended_ns; // 0: not yet
} profile_entry_session;

// A profile with the names that its ids stand for.
typedef struct profile_entry {
    const char *uid;
    profile_entry_device a;
    profile_entry_device b;
    const char *scene; // the workload's name; may be NULL
    int64_t dims;
    int64_t n;
    const char *query; // "rays closest", of whose items n is; NULL: of steps
    int64_t boxes;     // that are asked
    bool moving;       // measured on steps of a motion
    const char *family;
    profile_row row;
    int64_t created_ns;
    const char *dead_reason; // NULL: live
    profile_entry_session session;
} profile_entry;

// Called for each profile; what the entry points to is valid in the call.
// False stops the walk.
typedef bool profile_entry_visit(void *context, const profile_entry *entry);

// Live profiles and then, if asked for, the dead ones, each by pair and by size;
// only those whose uid begins with `uid`, unless that is NULL.
bool profile_entry_each(store *s, const char *uid, bool dead_too, profile_entry_visit *visit,
                        void *context, duet_error *err);

#endif

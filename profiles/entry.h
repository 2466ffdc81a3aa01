// SPDX-License-Identifier: MIT
// Profiles as people are shown them: with the names that their ids stand for.
#ifndef PROFILES_ENTRY_H
#define PROFILES_ENTRY_H

#include "profiles/profile.h"

typedef struct profile_entry_device {
    const char *name;
    const char *part; // NULL: the whole device
    const char *driver;
    const char *platform_version;
} profile_entry_device;

// The session that a profile comes from; all NULL and 0 where it has none.
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

typedef struct profile_entry {
    const char *uid;
    profile_entry_device a;
    profile_entry_device b;
    const char *scene; // the workload's name; may be NULL
    int64_t dims;
    int64_t n;
    const char *family;
    profile_row row; // without session and trial_number
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

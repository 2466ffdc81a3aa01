// SPDX-License-Identifier: MIT
// Which plan an application gets, and how good the evidence for it is.
//
// The grades go from what was measured here to what is a guess, and the
// grade says where it ended. No row of other devices is ever handed out as if
// it were these devices' own.
//
// Who asks for a level of accuracy gets what was measured at that level, and
// nothing else. Who asks for an accuracy gets, of the levels that were measured
// to be within it, the one with the best evidence and then the fastest; certified is within
// any. So no profile ever brings less than was asked for.
#ifndef PROFILES_LOOKUP_H
#define PROFILES_LOOKUP_H

#include "profiles/profile.h"

// Best first.
typedef enum profile_grade {
    PROFILE_EXACT,        // measured on these devices, drivers, kernels and workload
    PROFILE_OTHER_DRIVER, // the same, under another version of a driver
    PROFILE_INTERPOLATED, // measured on this pair for a scene like this: next to a size measured,
                          // or between
    PROFILE_TRANSFERRED,  // a plan without figures: of the pair's nearest workload, as far as that
                          // is surely the faster one, or from each device's fits
    PROFILE_STALE,        // the kernels changed since: only a place to start a search from
    PROFILE_DEFAULT       // nothing is known; the plan is not set
} profile_grade;

const char *profile_grade_name(profile_grade grade); // "exact", "other driver", ...

typedef struct profile_request {
    const profile_pair *pair;
    const profile_workload *workload;
    const char *kernels;
    const char *objective;
    const char *const *levels; // that will do where an accuracy is asked for
    uint32_t n_levels;         // 0: the workload's own level is asked for
    double max_missed_rate;    // accuracy asked for; a profile that gave less is passed over
    double max_false_rate;
    char host[PROFILE_SHA]; // fits of this machine come before those of others
} profile_request;

// Objective "time", no limit on rates, this host.
profile_request profile_default_request(void);

typedef struct profile_found {
    profile_grade grade;
    profile_plan plan;
    uint32_t
        share_low; // the best share may lie from here on: equal to the share where it was measured
    uint32_t share_high;
#define FIGURE(type, name) type name;
#define WORD(name) char name[16];
#define COUNT(name) int64_t name;
#include "profiles/profile_figures.inl"
    char terms[512];    // equations 4 to 6 of the best plan that shares the work, as JSON; empty if
                        // not known
    int64_t created_ns; // calendar; 0 if predicted
    char session[PROFILE_ID];
    char uid[PROFILE_ID]; // the profile's; empty if predicted
    char unused[128];     // why it is not live; empty: it is
} profile_found;

// Looks in one store. found is always filled; why, unless NULL, takes one line
// a grade, with the reason why it did or did not hold.
bool profile_lookup(store *s, const profile_request *request, profile_found *found, text *why,
                    duet_error *err);

// The one stored profile of that uid, live or not: as of grade exact.
bool profile_read(store *s, const char *uid, profile_found *found, duet_error *err);

// Looks in the user's file, as an application does at its start, and in the
// system's if that has nothing better; neither is written, made, or waited for.
// A missing file is no failure. On any failure found has the best
// that the other file gave, or the default grade.
bool profile_lookup_files(const char *user_path, const char *system_path,
                          const profile_request *request, profile_found *found, text *why,
                          duet_error *err);

#endif

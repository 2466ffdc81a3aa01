// SPDX-License-Identifier: MIT
// The store of profiles as a program sees it: what is in it, and rows out and
// in. What an application loads from it is duet_world_load_profile (duet_world.h).
//
// A path of NULL is the user's store (DUET_PROFILE). NOT_FOUND where there is
// no file, STORE_FAILED where it is none of ours or cannot be read. What else is
// NULL is BAD_ARGUMENT, as duet.h has it.
#ifndef DUET_PROFILES_H
#define DUET_PROFILES_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

typedef struct duet_stored_device {
    char name[256];
    char part[24]; // "0-3" of a CPU, "second" of two equal devices; empty: the whole device
    char driver[128];
} duet_stored_device;

// One profile: the plan that a tuning chose, and what it is worth.
typedef struct duet_stored_profile {
    char uid[72];       // its first digits name it
    char replaced[256]; // why it is not used; empty: it is live
    char scene[256];    // empty: not known
    uint32_t dims;
    uint64_t objects;
    char query[32]; // "rays closest", asked of the objects; empty: of steps
    uint64_t items; // of the query
    bool moving;    // of steps of a motion
    duet_stored_device a;
    duet_stored_device b;
    uint32_t share; // A's part, out of 65536
    char mode[16];
    char variant_a[192];
    char variant_b[192];
    char level[16];
    double step_ms; // the median, and its interval
    double low_ms;
    double high_ms;
    double gain; // over the best single device: 0.25 is a quarter faster
    double gain_low;
    double gain_high;
    char verdict[16];
    uint32_t rounds;    // of the race that the verdict is of; 0: not known
    uint32_t watched;   // launches whose threads were watched; 0: not known
    uint32_t disturbed; // and those of them that waited for a core
    double whole_ms;    // a step by the device that A and B are parts of; NaN: not raced
    double whole_gain;  // of the plan over it; NaN: not raced
    double whole_gain_low;
    double whole_gain_high;
    double missed_rate; // of the pairs that collide
    double false_rate;
    char origin[16];    // "measured", "online" or "manual"
    char session[72];   // that it comes from; empty: put in by hand
    int64_t measured_s; // since 1970, UTC
} duet_stored_profile;

// What a store holds; live ones first, by device pair and size.
typedef struct duet_profile_list duet_profile_list;

DUET_API duet_profile_list *duet_profile_list_create(const char *path, bool replaced_too,
                                                     duet_error *err);
DUET_API void duet_profile_list_destroy(duet_profile_list *list);
DUET_API uint32_t duet_profile_list_get_count(const duet_profile_list *list);
DUET_API const duet_stored_profile *duet_profile_list_get_profile(const duet_profile_list *list,
                                                                  uint32_t i);

// A plan that was measured on the way to a profile.
typedef struct duet_stored_trial {
    uint32_t share;
    char mode[16];
    char variant_a[192];
    char variant_b[192];
    uint32_t samples;
    double step_ms; // the median, and its interval; NaN unless ok, as those below
    double low_ms;
    double high_ms;
    double a_ms; // A's part of it, and B's
    double b_ms;
    char outcome[16]; // "ok", "build", "launch", "wrong", "timeout" or "pruned"
    char reason[256]; // where not ok
} duet_stored_trial;

// The trials of the profile that is named by its uid's first digits, in order;
// none where it was put in by hand. The caller frees them with duet_free.
DUET_API bool duet_profile_get_trials(const char *path, const char *uid, duet_stored_trial **trials,
                                      uint32_t *n, duet_error *err);

// Makes the profile that is named by its uid's first digits the one that
// applications load in its place. BAD_ARGUMENT for one without a verdict.
DUET_API bool duet_profile_use(const char *path, const char *uid, duet_error *err);

// Removes such a profile; its trials stay.
DUET_API bool duet_profile_forget(const char *path, const char *uid, duet_error *err);

// Writes all rows as JSON lines (docs/store.md) to a file.
DUET_API bool duet_profiles_export(const char *path, const char *file, duet_error *err);

typedef struct duet_import_counts {
    uint64_t added;
    uint64_t known; // were there already, and stay as they are
} duet_import_counts;

// Takes such a file's rows in: all or, where a line is wrong, none. Makes the
// store where there is none. counts may be NULL.
DUET_API bool duet_profiles_import(const char *path, const char *file, duet_import_counts *counts,
                                   duet_error *err);

DUET_C_END

#endif

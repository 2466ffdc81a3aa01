// SPDX-License-Identifier: MIT
// The profile store as a program sees it: its profiles, and export and import of rows. Applications
// load from it by duet_world_load_profile (duet_world.h).
//
// A path of NULL is the user's store (DUET_PROFILE). NOT_FOUND if there is no file, STORE_FAILED if
// it is not a store or cannot be read. Other NULL pointers are BAD_ARGUMENT, as in duet.h.
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
    char uid[72];       // identifies it; its first digits suffice
    char replaced[256]; // why it is not used; empty: it is live
    char scene[256];    // empty: not known
    uint32_t dims;
    uint64_t objects;
    char query[32]; // query of the objects, "rays closest"; empty: a step
    uint64_t items; // items of the query
    bool moving;    // measured on steps of a motion
    duet_stored_device a;
    duet_stored_device b;
    uint32_t share; // A's part, out of 65536
    char mode[16];
    char variant_a[192];
    char variant_b[192];
    char level[16];
    char objective[96]; // what it makes small: "time", "energy", or time over ranks
    double step_ms;     // the median, and its interval
    double low_ms;
    double high_ms;
    double gain; // over the best single device: 0.25 is a quarter faster
    double gain_low;
    double gain_high;
    char verdict[16];
    uint32_t rounds;    // rounds of the race that gave the verdict; 0: not known
    uint32_t watched;   // launches whose threads were watched; 0: not known
    uint32_t disturbed; // watched launches that waited for a core
    double whole_ms;    // a step by the device that A and B are parts of; NaN: not raced
    double whole_gain;  // gain of the plan over it; NaN: not raced
    double whole_gain_low;
    double whole_gain_high;
    double missed_rate; // missed pairs, by pairs that collide
    double false_rate;
    char origin[16];    // "measured", "online" or "manual"
    char session[72];   // session that it comes from; empty: entered by hand
    int64_t measured_s; // since 1970, UTC
} duet_stored_profile;

// The profiles of a store; live ones first, by device pair and size.
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
    double step_ms; // the median, and its interval; this and the following are NaN unless ok
    double low_ms;
    double high_ms;
    double a_ms; // A's part of it, and B's
    double b_ms;
    char outcome[16]; // "ok", "build", "launch", "wrong", "timeout" or "pruned"
    char reason[256]; // reason if not ok
} duet_stored_trial;

// Gets the trials of a profile, in order; none if it was entered by hand. uid may be the first
// digits of its uid. The caller frees *trials with duet_free.
DUET_API bool duet_profile_get_trials(const char *path, const char *uid, duet_stored_trial **trials,
                                      uint32_t *n, duet_error *err);

// Makes a profile the one that applications load for its devices and workload. BAD_ARGUMENT for a
// profile without a verdict.
DUET_API bool duet_profile_use(const char *path, const char *uid, duet_error *err);

// Removes a profile; its trials stay.
DUET_API bool duet_profile_forget(const char *path, const char *uid, duet_error *err);

// Writes all rows as JSON lines (docs/store.md) to a file.
DUET_API bool duet_profiles_export(const char *path, const char *file, duet_error *err);

typedef struct duet_import_counts {
    uint64_t added;
    uint64_t known; // rows that were there already, and stay as they are
} duet_import_counts;

// Adds the rows of an exported file: all or, if a line is wrong, none. Creates the store if there
// is none. counts may be NULL.
DUET_API bool duet_profiles_import(const char *path, const char *file, duet_import_counts *counts,
                                   duet_error *err);

DUET_C_END

#endif

// SPDX-License-Identifier: MIT
// A look-up on its way down the grades, for lookup.c, which decides, lookup_rows.c, which asks the
// store, and lookup_why.c, which says in words why a grade held or did not.
#ifndef PROFILES_LOOKUP_STEPS_H
#define PROFILES_LOOKUP_STEPS_H

#include "profiles/forecast.h"
#include "profiles/lookup.h"
#include "profiles/neighbour.h"
#include "profiles/sql.h"

// Live profiles of the pair for other workloads of the family.
typedef struct neighbours {
    double at[NEIGHBOUR_QUANTITIES]; // the workload asked for
    neighbour below;                 // the nearest sizes of scenes that are alike
    neighbour above;
    neighbour nearest; // the nearest of the scenes up to these, alike or not
} neighbours;

// A request at one level of accuracy, with its keys, on its way down the grades.
typedef struct lookup {
    store *s;
    const profile_request *request;
    profile_workload at; // the request's, at that level
    char env[2][PROFILE_SHA];
    char seat[2][PROFILE_SHA];
    char workload[PROFILE_SHA];
    int64_t pair_id; // 0 if these devices were never measured together
    text family;     // the workload's
    neighbours near; // from the grade "interpolated" on
    profile_found *found;
    text *why; // NULL: nobody asks
    duet_error *err;
} lookup;

// ---------------------------------------------------------------- rows

bool rows_find_pair(lookup *l);

// Each fills found from the best live profile of that grade; *held tells whether there is one.
bool rows_take_exact(lookup *l, bool *held);
bool rows_take_other_driver(lookup *l, bool *held);
bool rows_take_stale(lookup *l, bool *held);

bool rows_find_neighbours(lookup *l);

// Whether any workload like this was measured at this level.
bool rows_are_measured(lookup *l, bool *measured);

// ---------------------------------------------------------------- words

// Each adds to why, unless that is NULL.
bool why_not(lookup *l, const char *reason); // true
bool why_found(lookup *l, int64_t id);       // says where the profile of that id comes from
bool why_not_exact(lookup *l);               // says what an exact profile lacks
void why_not_between(lookup *l);             // why what was measured does not surround the workload
void why_between(lookup *l);
void why_next(lookup *l);
void why_motion(lookup *l, double n, bool held);
void why_transferred(lookup *l, const neighbour *near, double ratio, bool held);
void why_forecast(lookup *l, const forecast *f, bool held);

#endif

// SPDX-License-Identifier: MIT
// A world as the profile store knows it, what a tree is asked, a motion or a task: its devices, its
// workload, its kernels.
#ifndef RUNTIME_PROFILE_SUBJECT_H
#define RUNTIME_PROFILE_SUBJECT_H

#include "profiles/lookup.h"
#include "runtime/duet.h"
#include "runtime/queries/tree_share.h"

#define PROFILE_PART 24 // with the NUL
#define PROFILE_EFFECTS 320
#define PROFILE_TASK 224

typedef struct profile_subject {
    profile_pair pair; // its strings are the device pair's, or lie in parts
    profile_workload workload;
    char parts[2][PROFILE_PART];     // "0-0" of a part of a CPU, "second" of an equal device
    char query[QUERY_NAME];          // the workload's
    char task[PROFILE_TASK];         // its words instead of a query
    char effects[PROFILE_EFFECTS];   // a motion's
    char kernels[PROFILE_SHA];       // hash of all kernel text
    const char *levels[DUET_LEVELS]; // that may be within the accuracy asked for
    uint32_t n_levels;               // 0: the workload's own level is asked for
    duet_accuracy accuracy;
    const char *objective; // NULL: the time on one pair
} profile_subject;

// A workload whose level is chosen by an accuracy is stored as of this level.
#define PROFILE_ANY_LEVEL "auto"

// Looks at every object. BAD_ARGUMENT for a world without objects.
bool profile_subject_read(duet_world *world, profile_subject *p, duet_error *err);

// n items of that query, at level certified. BAD_ARGUMENT for a tree without objects, or no items.
bool profile_subject_read_query(const duet_tree *tree, const query_name *query, uint64_t n,
                                profile_subject *p, duet_error *err);

// Makes the subject of a motion's bodies as they were created. BAD_ARGUMENT for a motion without
// bodies, or in which nothing happens.
bool profile_subject_read_motion(const duet_motion *motion, profile_subject *p, duet_error *err);

// A task with the text of its kernel as it is now.
bool profile_subject_read_task(const duet_task_file *t, const duet_device_pair *pair,
                               profile_subject *p, duet_error *err);

// From here on it is the workload at that level, whatever was asked for.
void profile_subject_settle(profile_subject *p, duet_level level);

// p must live as long as the request is used.
profile_request profile_subject_request(const profile_subject *p);

// Looks in the store at the path alone; without one in the user's and, where that has nothing
// better, in the system's. Otherwise like profile_lookup_files.
bool profile_subject_look(const char *path, const profile_request *request, profile_found *found,
                          text *why, duet_error *err);

// The level that the store knows by that name. BAD_INPUT where there is none.
bool profile_subject_read_level(const char *name, duet_level *level, duet_error *err);

// A stored plan, and one to store, measured at that level of accuracy. BAD_INPUT
// for a mode that there is not.
bool profile_subject_read_plan(const profile_plan *stored, duet_plan *plan, duet_error *err);
profile_plan profile_subject_write_plan(const duet_plan *plan, const char *level);

#endif

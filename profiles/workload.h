// SPDX-License-Identifier: MIT
// A workload: the class of scenes that one profile serves.
#ifndef PROFILES_WORKLOAD_H
#define PROFILES_WORKLOAD_H

#include "profiles/device.h"

typedef struct profile_workload {
    uint32_t dims;       // 2 or 3
    uint64_t n;          // objects
    uint32_t cells[3];   // the grid; in 2D cells[2] is not read
    double cell;         // cell edge
    double occ_mean;     // objects in a cell, over all cells
    double occ_p99;      // and in the fullest hundredth of them
    double size_ratio;   // largest extent by smallest; 1: all alike
    const char *shape;   // "poses" or "bounds"
    bool rotated;        // some object has a rotation
    const char *effects; // words in any order, "gravity motion"; NULL: none
    const char *level;   // of accuracy, "certified"; "auto": any that meets the budget
    const char *name;    // the scene's; told to people and not part of the key
} profile_workload;

// The text that the key is made of. What is measured from the objects is
// rounded to parts of an octave, so that two draws of one scene are one workload.
void profile_workload_text(const profile_workload *w, text *t);

// What workloads of different size must share to be neighbours.
void profile_workload_family(const profile_workload *w, text *t);

bool profile_workload_key(const profile_workload *w, char key[PROFILE_SHA], duet_error *err);

// Finds or adds it. BAD_ARGUMENT names a field that cannot be.
bool profile_workload_put(store *s, const profile_workload *w, int64_t *workload_id,
                          duet_error *err);

#endif

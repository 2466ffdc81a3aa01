// SPDX-License-Identifier: MIT
// Which bodies may touch: makes a motion's bounds, pairs and rows (products.h).
#ifndef RUNTIME_CONTACT_GRAPH_H
#define RUNTIME_CONTACT_GRAPH_H

#include "runtime/opencl/scan.h"

typedef struct contact_graph {
    duet_world *world;    // a world of bounds; NULL without contact
    duet_result searched; // its last result; zero once it was taken
    scan scan;
    buffer pairs; // that rows are made of
    cl_uint n_pairs;
    cl_uint n_contacts; // in rows
    cl_uint n_without;  // bodies, if the device has rows of so many without contacts; else 0
    // other arguments of a launch
    cl_uint n_old, fill, of_all;
    buffer row_starts, row_values;
} contact_graph;

bool motion_make_bounds(duet_motion *m, duet_error *err);
bool motion_make_pairs(duet_motion *m, duet_error *err);
bool motion_make_rows(duet_motion *m, duet_error *err);

// Returns how many contacts rows of so many pairs may have at most, with walls and the ground.
uint64_t motion_most_contacts(const duet_motion *m, uint64_t pairs);

// Takes the result of the last search of all bodies. Returns false if there was none since the last
// call.
bool motion_take_search(duet_motion *m, duet_result *search);

// Lets the next search fit its grid anew: bodies lie elsewhere than before.
void motion_refit_grid(duet_motion *m);

// Sends a check that sets FLAG_MOVED if a body has left its bounds, of all bodies or of the listed
// ones; once flags are read, notes in the products whether bounds hold.
bool motion_check_bounds(duet_motion *m, bool of_all, duet_error *err);
void motion_note_bounds(duet_motion *m);

#endif

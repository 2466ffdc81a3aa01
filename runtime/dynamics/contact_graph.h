// SPDX-License-Identifier: MIT
// Which bodies may touch: makes a motion's bounds, pairs and rows (products.h).
#ifndef RUNTIME_CONTACT_GRAPH_H
#define RUNTIME_CONTACT_GRAPH_H

#include "runtime/dynamics/motion.h"

bool motion_make_bounds(duet_motion *m, duet_error *err);
bool motion_make_pairs(duet_motion *m, duet_error *err);
bool motion_make_rows(duet_motion *m, duet_error *err);

// Sends a check that sets FLAG_MOVED if a body has left its bounds; once flags are read, notes in
// the products whether bounds hold.
bool motion_check_bounds(duet_motion *m, duet_error *err);
void motion_note_bounds(duet_motion *m);

#endif

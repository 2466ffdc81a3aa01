// SPDX-License-Identifier: MIT
// What contacts do to bodies in a step: makes manifolds and colours (products.h), and solves
// contacts.
#ifndef RUNTIME_SOLVER_H
#define RUNTIME_SOLVER_H

#include "runtime/dynamics/motion.h"

bool motion_make_manifolds(duet_motion *m, duet_error *err);
bool motion_make_colours(duet_motion *m, duet_error *err);

// With contact response: the substeps, of bodies and colours that are right; then what they leave
// goes to the objects.
bool motion_solve(duet_motion *m, duet_error *err);
bool motion_finalize(duet_motion *m, duet_error *err);

#endif

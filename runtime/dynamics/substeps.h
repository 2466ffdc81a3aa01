// SPDX-License-Identifier: MIT
// How many substeps hold what stands when a motion begins (docs/notes/effects.md, "Why a tall stack
// stands").
#ifndef RUNTIME_SUBSTEPS_H
#define RUNTIME_SUBSTEPS_H

#include "runtime/duet.h"

// Sets the def's substeps where they are left to the motion, and notes why. Needs effects and
// margin.
bool motion_choose_substeps(duet_motion *m, duet_error *err);

#endif

// SPDX-License-Identifier: MIT
// What a recording has of steps, among the commands of runtime/commands/recording.h: runs of them,
// and the state's hash every so often, so that a replay that parts from it ends where that is seen.
#ifndef RUNTIME_RECORDED_STEPS_H
#define RUNTIME_RECORDED_STEPS_H

#include "base/text.h"
#include "runtime/duet.h"

// Begins each record.
typedef struct recorded {
    uint32_t kind;
    uint32_t n; // bodies, or steps
    uint32_t fields;
    uint32_t unused;
} recorded;

// Kinds besides the commands' numbers. A hash of 8 bytes follows the second; its record comes
// behind one of steps, and is of the state that the last of them left.
enum { RECORDED_STEPS = 0, RECORDED_HASH = 254 };

// Begins with a recording that has no steps.
void recorded_steps_begin(duet_motion *m, text *recording);

// Adds the steps since the last record.
void recorded_steps_add(duet_motion *m);

// Adds the hash after a step of a recorded motion, if it is due: each 32nd step, and of more than
// 65 536 bodies less often, for a hash takes as long as they are many, however fast the device is.
// A state that is no longer finite has none.
void recorded_steps_note(duet_motion *m);

#endif

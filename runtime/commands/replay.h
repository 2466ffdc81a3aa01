// SPDX-License-Identifier: MIT
// A replay in two halves, for callers that look at the state between commands and step.
#ifndef RUNTIME_REPLAY_H
#define RUNTIME_REPLAY_H

#include "runtime/duet_replay.h"

// Gives the motion the commands that come before the next step, once: duet_replay_advance then
// steps alone. Fails as that does. *given: some came with this call.
bool replay_give(duet_replay *replay, duet_motion *motion, bool *given, duet_error *err);

#endif

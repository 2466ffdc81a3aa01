// SPDX-License-Identifier: MIT
// A motion's state kept in memory, in the form of its file without the sum, for callers that go
// back to it.
#ifndef RUNTIME_KEPT_MOTION_H
#define RUNTIME_KEPT_MOTION_H

#include "base/text.h"
#include "runtime/duet_motion.h"

// Replaces what `kept` holds by the state of a motion that is whole.
bool motion_keep(duet_motion *m, text *kept, duet_error *err);

// Loads what was kept of this motion, as duet_motion_load.
bool motion_return(duet_motion *m, const text *kept, duet_error *err);

#endif

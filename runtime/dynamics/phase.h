// SPDX-License-Identifier: MIT
// What a motion is doing, and so which public calls it takes.
//
//                advance_begin, advance              map_states
//     STEPPING <------------------------- READY ----------------------> MAPPED --+ map_states,
//         |  |                             ^ ^ ^                          |  | ^--+ unmap_states
//         |  +-----------------------------+ | +--------------------------+  |
//         |       advance_end, advance       |    unmap_states of the last   |
//         |                                  | load                          |
//         +------------------------------> BROKEN <--------------------------+
//           the step failed                  ^     a command was left half-way, in READY as well
//
//   READY     the state is that of a whole step and of whole commands; the host may read it and
//             change it
//   STEPPING  the state is the step's: a thread of the motion's own may be changing it
//   MAPPED    as READY, but parts of the state are the caller's (duet_motion.mapped); other parts
//             may be mapped or unmapped, and nothing else is to be done
//   BROKEN    the state is that of no step; what was mapped still has its memory, until the motion
//             is loaded or destroyed
#ifndef RUNTIME_PHASE_H
#define RUNTIME_PHASE_H

#include "runtime/duet.h"
#include "runtime/duet_motion_map.h"

#include <stdbool.h>

typedef enum motion_phase {
    MOTION_READY,
    MOTION_STEPPING,
    MOTION_MAPPED,
    MOTION_BROKEN,
} motion_phase;

// Whether there is a motion, and it is READY; READY or MAPPED; READY or BROKEN. BAD_ARGUMENT says
// what is expected first.
bool motion_is_whole(const duet_motion *m, const char *call, duet_error *err);
bool motion_is_steady(const duet_motion *m, const char *call, duet_error *err);
bool motion_is_loadable(const duet_motion *m, const char *call, duet_error *err);

// The transitions. A step begins, and ends well or not; a part of the state is mapped, and
// unmapped; a command that has begun to change the state ends, made or left half-way, and returns
// that; a state is loaded.
void motion_enter_step(duet_motion *m);
void motion_leave_step(duet_motion *m, bool made);
void motion_note_map(duet_motion *m, duet_state_part part);
void motion_note_unmap(duet_motion *m, duet_state_part part);
bool motion_keep_whole(duet_motion *m, bool made);
void motion_mend(duet_motion *m);

#endif

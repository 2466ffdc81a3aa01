// SPDX-License-Identifier: MIT
// States of a motion in place: the next step begins with what is written there.
#ifndef DUET_MOTION_MAP_H
#define DUET_MOTION_MAP_H

#include "duet_motion.h"

DUET_C_BEGIN

// A part of the state: rows of four numbers, float, or double in a motion with doubles.
typedef enum duet_state_part {
    DUET_STATE_CENTRES,           // xyz; the fourth is not read. Not with origin cells
    DUET_STATE_ROTATIONS,         // quaternion xyzw; with the effect rotation
    DUET_STATE_VELOCITIES,        // xyz, and 1 / mass, or 0, which is not read
    DUET_STATE_ANGULAR_VELOCITIES // xyz, along the world's axes; with the effect angular_velocity
} duet_state_part;

DUET_API const char *duet_state_part_name(duet_state_part part); // "centres"; NULL outside

typedef enum duet_map_access {
    DUET_MAP_READ,
    DUET_MAP_WRITE // and read
} duet_map_access;

// Maps rows [n] of the objects at the places first .. first + n - 1. If B works on host memory,
// they are the motion's own, without a copy; otherwise they are fetched, and unmap sends what was
// written. Each part can be mapped once at a time. Until it is unmapped, only this call,
// duet_motion_destroy and calls without a duet_error can be used; others are BAD_ARGUMENT.
DUET_API void *duet_motion_map_states(duet_motion *motion, duet_state_part part,
                                      duet_map_access access, uint32_t first, uint32_t n,
                                      duet_error *err);

// Ends a mapping. With WRITE the two calls are a command to those bodies, in the order of the
// calls (duet_motion_commands.h): map removes their targets, and unmap wakes them. Rotations
// need not have length 1. A disabled body stands still whatever is written. Refused while the
// motion is recorded (duet_replay.h). BAD_OBJECT names the first row that is not finite, or is no
// rotation; all stays mapped, so that it can be mended.
DUET_API bool duet_motion_unmap_states(duet_motion *motion, duet_state_part part, duet_error *err);

DUET_C_END

#endif

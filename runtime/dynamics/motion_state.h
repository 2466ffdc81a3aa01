// SPDX-License-Identifier: MIT
// The state of a motion on B, as the host writes it: what bodies are given, and which are awake.
#ifndef RUNTIME_MOTION_STATE_H
#define RUNTIME_MOTION_STATE_H

#include "runtime/dynamics/motion.h"

// Puts poses and bodies into B's buffers, and 0 into what they lack.
bool motion_reset(duet_motion *m, duet_error *err);

// The rotation and the angular velocity that an object was given.
void motion_given_state(const duet_motion *m, uint32_t id, duet_state *state);

// One over the inertia of an object about each of its own axes; 0: never turned about it.
void motion_inverse_inertia(const duet_motion *m, uint32_t id, double inverse[3]);

// Puts what poses and bodies say of some objects into B's buffers; places NULL: of all n.
enum motion_part {
    PART_POSE = 1 << 0, // centre and rotation
    PART_SIZE = 1 << 1,
    PART_VELOCITY = 1 << 2,
    PART_ANGULAR_VELOCITY = 1 << 3,
    PART_MASS = 1 << 4,
    PART_SURFACE = 1 << 5, // what contacts know of a body
    PART_FILTER = 1 << 6,
    PART_SENSOR = 1 << 7,
    PART_ALL = (1 << 8) - 1
};
bool motion_send_places(duet_motion *m, const uint32_t *places, uint32_t n, uint32_t parts,
                        duet_error *err);

// Fills rows of some objects, one behind the other, with what poses and bodies say of them; what a
// buffer has besides is left.
void motion_fill_given(duet_motion *m, motion_buffer which, const uint32_t *places, uint32_t n,
                       void *packed);

// The time at rest of what a command changed since the last step.
#define RESTS_CHANGED (-1.0f)

// Bodies that were changed are awake, and those that they touch will be.
bool motion_wake_places(duet_motion *m, const uint32_t *places, uint32_t n, duet_error *err);
// The same, or asleep, of bodies that are where they were, or altered: the others' bounds hold as
// they did.
bool motion_set_asleep(duet_motion *m, const uint32_t *places, uint32_t n, bool asleep,
                       duet_error *err);
bool motion_wake_all(duet_motion *m, duet_error *err);

#endif

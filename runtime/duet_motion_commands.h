// SPDX-License-Identifier: MIT
// Commands to a motion between its steps: bodies that come and go, and what is set,
// pushed or aimed at while it runs.
//
// Each call takes effect at once, in the order of the calls, and is what the next step
// begins with; get_states shows it. A call checks all of its list first: where it fails
// with BAD_ARGUMENT or BAD_OBJECT nothing has changed. A command wakes its bodies, and
// they wake what they touch. The same commands give the same bits on every device.
//
// Effects are those that a motion was made with. What needs another one is refused by its
// name; wants asks for it when the motion is made.
#ifndef DUET_MOTION_COMMANDS_H
#define DUET_MOTION_COMMANDS_H

#include "duet_motion.h"

DUET_C_BEGIN

// A body's id: its place, and 2^32 times how many bodies had that place before. Those that
// a motion is made of have the ids 0, 1, 2 ... An id of a removed body never is another's.
#define DUET_NO_BODY UINT64_MAX

// Which bodies a command is for: those of ids [n], or where ids is NULL those at the places
// first .. first + n - 1. States, contacts and events count by place.
typedef struct duet_body_list {
    const uint64_t *ids;
    uint32_t first;
    uint32_t n;
} duet_body_list;

// ---------------------------------------------------------------- bodies come and go

// Adds n bodies (bodies NULL: duet_default_body each); poses count from the def's origin.
// ids [n] may be NULL. The lowest places that are empty are used first, then new ones at
// the end; a place whose body was removed is empty after the next step.
DUET_API bool duet_motion_add_bodies(duet_motion *motion, const duet_pose *poses,
                                     const duet_body *bodies, uint32_t n, uint64_t *ids,
                                     duet_error *err);

// What touched a removed body wakes, and its contacts end in the next step. An empty place
// keeps the last body's pose and is at rest.
DUET_API bool duet_motion_remove_bodies(duet_motion *motion, duet_body_list list, duet_error *err);

// A disabled body takes no part: nothing touches it, and it stands still. Enabled again it
// is at rest, or has the velocities that were set meanwhile.
DUET_API bool duet_motion_disable_bodies(duet_motion *motion, duet_body_list list, duet_error *err);
DUET_API bool duet_motion_enable_bodies(duet_motion *motion, duet_body_list list, duet_error *err);

// With the effect sleep. What is sent to sleep stops at once, and stays asleep unless it touches
// something that moves.
DUET_API bool duet_motion_wake_bodies(duet_motion *motion, duet_body_list list, duet_error *err);
DUET_API bool duet_motion_sleep_bodies(duet_motion *motion, duet_body_list list, duet_error *err);

// The ids of the bodies at places first .. first + n - 1, of duet_motion_get_count;
// DUET_NO_BODY where there is none.
DUET_API bool duet_motion_get_ids(const duet_motion *motion, uint32_t first, uint32_t n,
                                  uint64_t *ids, duet_error *err);

// Whether an id is that of a body that is there, enabled or not.
DUET_API bool duet_motion_has_body(const duet_motion *motion, uint64_t id);

// A number of the caller's for each body, 0 at first.
DUET_API bool duet_motion_set_user_data(duet_motion *motion, duet_body_list list,
                                        const uint64_t *data, duet_error *err);
DUET_API bool duet_motion_get_user_data(duet_motion *motion, duet_body_list list, uint64_t *data,
                                        duet_error *err);

// ---------------------------------------------------------------- what is set

typedef enum duet_body_field {
    DUET_BODY_VELOCITY = 1u << 0,
    DUET_BODY_ANGULAR_VELOCITY = 1u << 1,
    DUET_BODY_MASS = 1u << 2, // 0: nothing changes its velocity from then on
    DUET_BODY_RESTITUTION = 1u << 3,
    DUET_BODY_FRICTION = 1u << 4,
    DUET_BODY_FILTER = 1u << 5, // group and mask
    DUET_BODY_FIXED_ROTATION = 1u << 6,
    DUET_BODY_RADIUS = 1u << 7,
    DUET_BODY_ALL = (1u << 8) - 1
} duet_body_field;

DUET_API const char *duet_body_field_name(uint32_t field); // one bit: "velocity"; NULL for others

// Sets those fields of bodies [list.n]; the others are not read. Whether a body is a sensor
// does not change.
DUET_API bool duet_motion_set_bodies(duet_motion *motion, duet_body_list list, uint32_t fields,
                                     const duet_body *bodies, duet_error *err);

// Puts bodies elsewhere, with these sizes; velocities stay.
DUET_API bool duet_motion_set_poses(duet_motion *motion, duet_body_list list,
                                    const duet_pose *poses, duet_error *err);

// Changes gravity, attraction and its centre, drag, lower and upper, max_push_speed,
// restitution_threshold, sleep_speed and sleep_after to those of a def; its other members
// must be the motion's (duet_motion_get_def). What sleeps wakes.
DUET_API bool duet_motion_set_def(duet_motion *motion, const duet_motion_def *def, duet_error *err);
DUET_API const duet_motion_def *duet_motion_get_def(const duet_motion *motion); // the motion's

// ---------------------------------------------------------------- what pushes

// In the world's axes; forces act on the centre.
typedef struct duet_force {
    float force[3];
    float torque[3];
} duet_force;

// Forces for the whole of the next step, added to those that were applied before; with the
// effect forces. They do nothing to a body of mass 0.
DUET_API bool duet_motion_apply_forces(duet_motion *motion, duet_body_list list,
                                       const duet_force *forces, duet_error *err);

typedef struct duet_impulse {
    float impulse[3];
    float anchor[3]; // where it acts, from the centre, along the world's axes
} duet_impulse;

// Changes velocities at once. Does nothing to a body of mass 0. BAD_OBJECT where a velocity
// would not be finite; likewise for the sum of a body's forces, and the way to a target.
DUET_API bool duet_motion_apply_impulses(duet_motion *motion, duet_body_list list,
                                         const duet_impulse *impulses, duet_error *err);

// Kinematic targets: the next step moves bodies of mass 0 there, and what they touch feels
// that velocity. After it they are exactly there and stand still.
DUET_API bool duet_motion_set_targets(duet_motion *motion, duet_body_list list,
                                      const duet_transform *targets, duet_error *err);

DUET_C_END

#endif

// SPDX-License-Identifier: MIT
// Commands to a motion between its steps: bodies come and go, and are set, pushed or
// aimed at a target.
//
// Each call takes effect at once, in the order of the calls, and the next step begins with
// it; get_states shows it. A call checks all of its list first: if it fails with
// BAD_ARGUMENT or BAD_OBJECT, nothing has changed. A command wakes its bodies, and
// they wake what they touch. The same commands give the same bits on every device.
//
// A motion keeps the effects that it was created with. A command that needs another effect
// is refused with the effect's name; ask for it in wants when the motion is created.
#ifndef DUET_MOTION_COMMANDS_H
#define DUET_MOTION_COMMANDS_H

#include "duet_motion.h"

DUET_C_BEGIN

// A body's id: its place, plus 2^32 times the number of bodies that had that place before. The
// bodies that a motion is created with have the ids 0, 1, 2 ... An id is never reused.
#define DUET_NO_BODY UINT64_MAX

// The bodies of a command: those with ids [n], or if ids is NULL those at the places
// first .. first + n - 1. States, contacts and events count by place.
typedef struct duet_body_list {
    const uint64_t *ids;
    uint32_t first;
    uint32_t n;
} duet_body_list;

// ---------------------------------------------------------------- bodies come and go

// Adds n bodies; poses count from the def's origin. bodies NULL: duet_default_body each.
// ids [n] gets their ids; may be NULL. The lowest empty places are filled first, then new ones
// at the end; a removed body's place is empty after the next step.
DUET_API bool duet_motion_add_bodies(duet_motion *motion, const duet_pose *poses,
                                     const duet_body *bodies, uint32_t n, uint64_t *ids,
                                     duet_error *err);

// Removes bodies. Bodies that touched them wake, and their contacts end in the next step. An
// empty place keeps the last body's pose and is at rest.
DUET_API bool duet_motion_remove_bodies(duet_motion *motion, duet_body_list list, duet_error *err);

// Disables bodies, or enables them again. A disabled body touches nothing and stands still. An
// enabled one is at rest, or has the velocities that were set meanwhile.
DUET_API bool duet_motion_disable_bodies(duet_motion *motion, duet_body_list list, duet_error *err);
DUET_API bool duet_motion_enable_bodies(duet_motion *motion, duet_body_list list, duet_error *err);

// Wakes bodies, or puts them to sleep; needs the effect sleep. A body put to sleep stops at once,
// and stays asleep unless it touches something that moves.
DUET_API bool duet_motion_wake_bodies(duet_motion *motion, duet_body_list list, duet_error *err);
DUET_API bool duet_motion_sleep_bodies(duet_motion *motion, duet_body_list list, duet_error *err);

// Gets the ids of the bodies at places first .. first + n - 1, below duet_motion_get_count;
// DUET_NO_BODY for an empty place.
DUET_API bool duet_motion_get_ids(const duet_motion *motion, uint32_t first, uint32_t n,
                                  uint64_t *ids, duet_error *err);

// Says whether the motion has a body of that id, enabled or not.
DUET_API bool duet_motion_has_body(const duet_motion *motion, uint64_t id);

// Sets or gets a number of the caller's for each body, 0 at first: data [list.n].
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
    DUET_BODY_ROLLING_RESISTANCE = 1u << 8,
    DUET_BODY_SURFACE_VELOCITY = 1u << 9,
    DUET_BODY_MATERIAL = 1u << 10,
    DUET_BODY_ALL = (1u << 11) - 1
} duet_body_field;

DUET_API const char *duet_body_field_name(uint32_t field); // one bit: "velocity"; NULL for others

// Sets these fields from bodies [list.n]; other fields are not read. A body stays a sensor, or
// none.
DUET_API bool duet_motion_set_bodies(duet_motion *motion, duet_body_list list, uint32_t fields,
                                     const duet_body *bodies, duet_error *err);

// Moves bodies to poses [list.n], with the poses' sizes; velocities stay.
DUET_API bool duet_motion_set_poses(duet_motion *motion, duet_body_list list,
                                    const duet_pose *poses, duet_error *err);

// Sets gravity, attraction and its centre, drag, lower and upper, max_push_speed,
// restitution_threshold, sleep_speed and sleep_after to those of def; its other members
// must equal the motion's (duet_motion_get_def); substeps of 0 stand for the motion's. Wakes all
// bodies.
DUET_API bool duet_motion_set_def(duet_motion *motion, const duet_motion_def *def, duet_error *err);
DUET_API const duet_motion_def *duet_motion_get_def(const duet_motion *motion); // the motion's

// ---------------------------------------------------------------- what pushes

// A force on the centre and a torque, along the world's axes.
typedef struct duet_force {
    float force[3];
    float torque[3];
} duet_force;

// Applies forces [list.n] for the whole of the next step, added to those applied before; needs the
// effect forces. They do nothing to a body of mass 0. BAD_OBJECT if the sum of a body's forces
// would not be finite.
DUET_API bool duet_motion_apply_forces(duet_motion *motion, duet_body_list list,
                                       const duet_force *forces, duet_error *err);

typedef struct duet_impulse {
    float impulse[3];
    float anchor[3]; // point at which it acts, from the centre, along the world's axes
} duet_impulse;

// Applies impulses [list.n]: velocities change at once. They do nothing to a body of mass 0.
// BAD_OBJECT if a velocity would not be finite.
DUET_API bool duet_motion_apply_impulses(duet_motion *motion, duet_body_list list,
                                         const duet_impulse *impulses, duet_error *err);

// Sets kinematic targets [list.n]: the next step moves bodies of mass 0 there, and what they touch
// feels that velocity. After it they are exactly there and stand still. BAD_OBJECT if the way to a
// target is not finite.
DUET_API bool duet_motion_set_targets(duet_motion *motion, duet_body_list list,
                                      const duet_transform *targets, duet_error *err);

DUET_C_END

#endif

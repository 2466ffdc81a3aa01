// SPDX-License-Identifier: MIT
// Duet: collisions among boxes, found by two OpenCL devices together. "The paper" is
// Mohid Tayyub and Gul N. Khan, "Heterogeneous Design and Efficient CPU-GPU Implementation
// of Collision Detection", Ryerson University, not dated.
//
// Owners are opaque pointers with one _create and one _destroy. Makers return a
// pointer or NULL and doers return bool; both take a duet_error last (NULL
// allowed). A def is filled by its duet_default_..._def() first. Two worlds in
// two threads are independent; one world belongs to one thread at a time.
//
// A NULL pointer is BAD_ARGUMENT, unless its call says what NULL means; an array of 0 rows
// may be NULL. Calls without a duet_error answer NULL, or an index past the end, with NULL,
// false or 0, unless they say otherwise. Destroying NULL does nothing.
//
// Owners can be destroyed in any order: what was made on a device pair holds it open, and
// a duet_online holds its world. Each owner is destroyed once, by its maker, and is not used
// after that. Memory that a call returns belongs to the owner that the call names, and ends with
// it.
//
// The application's locale does not matter: calls read and write numbers with a decimal point. If
// the locale has a comma, a call and its callbacks run in the locale "C".
//
// Units are the caller's (metres, say); floats are IEEE single; ids are the
// objects' indices in the input, from 0. Sets are closed: touching collides.
#ifndef DUET_H
#define DUET_H

#include "duet_box_query.h"
#include "duet_contact_query.h"
#include "duet_device.h"
#include "duet_error.h"
#include "duet_level.h"
#include "duet_motion.h"
#include "duet_motion_commands.h"
#include "duet_motion_map.h"
#include "duet_object.h"
#include "duet_pair_delta.h"
#include "duet_pair_query.h"
#include "duet_point_query.h"
#include "duet_ray_query.h"
#include "duet_replay.h"
#include "duet_scene.h"
#include "duet_sweep_query.h"
#include "duet_task.h"
#include "duet_tree.h"
#include "duet_world.h"

#include <stddef.h> // NULL

DUET_C_BEGIN

DUET_API const char *duet_version(void); // "0.9.0"

// Frees memory that a call says the caller frees. NULL does nothing.
DUET_API void duet_free(void *memory);

DUET_C_END

#endif

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
// A pointer that is NULL is BAD_ARGUMENT, unless its call says what NULL means; rows
// may be NULL where there are 0 of them. Calls without a duet_error answer NULL, or a
// place past the end, with NULL, false or 0, unless they say otherwise. Destroying NULL
// does nothing.
//
// Owners can be destroyed in any order: what was made on a device pair holds it open, and
// a share that is kept on line holds its world. Each is destroyed once, by who made it,
// and is not used after that. Memory that a call hands out goes with the owner it names.
//
// Units are the caller's (metres, say); floats are IEEE single; ids are the
// objects' places in the input, from 0. Sets are closed: touching collides.
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
#include "duet_tree.h"
#include "duet_world.h"

#include <stddef.h> // NULL

DUET_C_BEGIN

DUET_API const char *duet_version(void); // "0.9.0"

// Memory that a call says the caller frees. NULL does nothing.
DUET_API void duet_free(void *memory);

DUET_C_END

#endif

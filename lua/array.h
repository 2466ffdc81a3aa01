// SPDX-License-Identifier: MIT
// Poses, bounds, pairs and what else comes in bulk: n rows of numbers in one
// block of memory, the script's own or a view of a scene's or a world's. Places
// are from 0.
#ifndef LUA_ARRAY_H
#define LUA_ARRAY_H

#include "runtime/duet.h"

#include <lua.h>

typedef enum array_kind {
    ARRAY_POSES,
    ARRAY_BOUNDS,
    ARRAY_TRANSFORMS,
    ARRAY_COMPACT_TRANSFORMS,
    ARRAY_SIZES,
    ARRAY_ROUNDED_BOXES,
    ARRAY_SPHERES,
    ARRAY_LARGE_POSES,
    ARRAY_PAIRS,
    ARRAY_PAIRS64,
    ARRAY_BODIES,
    ARRAY_STATES,
    ARRAY_CONTACTS,
    ARRAY_ANSWERS,
    ARRAY_SEPARATIONS,
    ARRAY_RAYS,
    ARRAY_LARGE_RAYS,
    ARRAY_HITS,
    ARRAY_PLACES,
    ARRAY_IDS,
    ARRAY_BOX_HITS,
    ARRAY_FILTERS,
    ARRAY_POINTS,
    ARRAY_LARGE_POINTS,
    ARRAY_POINT_HITS,
    ARRAY_SWEEPS,
    ARRAY_BOUNDS_SWEEPS,
    ARRAY_LARGE_SWEEPS,
    ARRAY_ROUNDED_SWEEPS,
    ARRAY_SPHERE_SWEEPS,
    ARRAY_SWEEP_HITS,
    ARRAY_FORCES,
    ARRAY_IMPULSES,
    ARRAY_STATE_ROWS,
    ARRAY_DOUBLE_STATE_ROWS,
    ARRAY_KINDS
} array_kind;

// The owner of the rows.
typedef enum array_access {
    ARRAY_OPEN,  // the userdata's or its owner's, and may be written
    ARRAY_FIXED, // the owner's, and must not be written
    ARRAY_OWNED, // C's, and given back by duet_free
} array_access;

typedef struct array {
    array_kind kind;
    array_access access;
    void *rows; // duet_pose, duet_bounds ...
    uint64_t n;
    const uint64_t *epoch; // the owner's epoch; a view is valid while it equals epoch_made
    uint64_t epoch_made;
} array;

void array_open(lua_State *L); // adds duet.poses ... to the module at -1

// Pushes an array with zeroed rows of its own.
array *array_push(lua_State *L, array_kind kind, uint64_t n);

// Pushes an array with a copy of such rows.
void array_push_copy(lua_State *L, array_kind kind, const void *rows, uint64_t n);

// Pushes an empty one for rows that C made, and gives it n of them, which
// duet_free gives back.
array *array_push_empty(lua_State *L, array_kind kind);
void array_own(array *a, void *rows, uint64_t n);

// Pushes a view of rows that the userdata at 1 has. access: open or fixed.
void array_push_view(lua_State *L, array_kind kind, array_access access, void *rows, uint64_t n,
                     const uint64_t *epoch);

// The rows at index: an array, a string of packed rows, a table of rows or of
// numbers; the latter become an array, which takes their place at index.
const array *array_check(lua_State *L, int index, array_kind kind);

// The array at 1; NULL if there is something else.
array *array_test(lua_State *L);

// The objects that rows of poses, bounds, transforms, sizes, rounded boxes, spheres or large poses
// are.
duet_object_kind array_object_kind(array_kind kind);

// A pair hash as 16 hex digits.
void array_push_hash(lua_State *L, uint64_t hash);

#endif

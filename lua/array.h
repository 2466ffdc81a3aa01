// SPDX-License-Identifier: MIT
// Poses, bounds, pairs and what else comes in bulk: n rows of numbers in one
// block of memory, the script's own or a view of a scene's or a world's. Places
// are from 0.
#ifndef LUA_ARRAY_H
#define LUA_ARRAY_H

#include "runtime/duet.h"

#include <lua.h>

// clang-format off
// Each kind: its name in C and in Lua, a letter for each column (array.c), the bytes of a row, and
// columns that a row may end after; 0: it has all.
#define ARRAY_LIST(X) \
    X(POSES, poses, "ffffffffff", sizeof(duet_pose), 0) \
    X(BOUNDS, bounds, "ffffff", sizeof(duet_bounds), 0) \
    X(TRANSFORMS, transforms, "fffffff", sizeof(duet_transform), 0) \
    X(COMPACT_TRANSFORMS, compact_transforms, "fffhhhh", sizeof(duet_compact_transform), 0) \
    X(SIZES, sizes, "fff", sizeof(duet_size), 0) \
    X(ROUNDED_BOXES, rounded_boxes, "fffffffffff", sizeof(duet_rounded_box), 0) \
    X(SPHERES, spheres, "ffff", sizeof(duet_sphere), 0) \
    X(LARGE_POSES, large_poses, "ffffffffffiii", sizeof(duet_large_pose), 0) \
    X(PAIRS, pairs, "II", sizeof(duet_pair), 0) \
    X(PAIRS64, pairs64, "QQ", 2 * sizeof(uint64_t), 0) \
    X(BODIES, bodies, "fffffffffIIfBBffffI", sizeof(duet_body), 14) \
    X(STATES, states, "ddddddddddddd", sizeof(duet_state), 0) \
    X(CONTACTS, contacts, "IIfffIffffffffffffffffffff", sizeof(duet_contact), 0) \
    X(ANSWERS, answers, "C", sizeof(uint8_t), 0) \
    X(SEPARATIONS, separations, "d", sizeof(double), 0) \
    X(RAYS, rays, "fffffff", sizeof(duet_ray), 0) \
    X(LARGE_RAYS, large_rays, "fffffffiii", sizeof(duet_large_ray), 0) \
    X(HITS, hits, "IIf", sizeof(duet_ray_hit), 0) \
    X(PLACES, places, "I", sizeof(uint32_t), 0) \
    X(BOX_HITS, box_hits, "II", sizeof(duet_box_hit), 0) \
    X(FILTERS, filters, "II", sizeof(duet_filter), 0) \
    X(POINTS, points, "fff", sizeof(duet_point), 0) \
    X(LARGE_POINTS, large_points, "fffiii", sizeof(duet_large_point), 0) \
    X(POINT_HITS, point_hits, "IIf", sizeof(duet_point_hit), 0) \
    X(SWEEPS, sweeps, "ffffffffffffff", sizeof(duet_sweep), 0) \
    X(BOUNDS_SWEEPS, bounds_sweeps, "ffffffffff", sizeof(duet_bounds_sweep), 0) \
    X(LARGE_SWEEPS, large_sweeps, "ffffffffffiiiffff", sizeof(duet_large_sweep), 0) \
    X(ROUNDED_SWEEPS, rounded_sweeps, "fffffffffffffff", sizeof(duet_rounded_sweep), 0) \
    X(SPHERE_SWEEPS, sphere_sweeps, "ffffffff", sizeof(duet_sphere_sweep), 0) \
    X(SWEEP_HITS, sweep_hits, "IIffff", sizeof(duet_sweep_hit), 0) \
    X(IDS, ids, "Q", sizeof(uint64_t), 0) \
    X(FORCES, forces, "ffffff", sizeof(duet_force), 0) \
    X(IMPULSES, impulses, "ffffff", sizeof(duet_impulse), 0) \
    X(STATE_ROWS, state_rows, "ffff", 4 * sizeof(float), 0) \
    X(DOUBLE_STATE_ROWS, double_state_rows, "dddd", 4 * sizeof(double), 0)
// clang-format on

#define ARRAY_KIND(kind, name, columns, bytes, least) ARRAY_##kind,
typedef enum array_kind { ARRAY_LIST(ARRAY_KIND) ARRAY_KINDS } array_kind;

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

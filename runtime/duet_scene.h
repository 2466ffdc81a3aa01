// SPDX-License-Identifier: MIT
// Scenes: objects with the world they live in, and the reference that says what collides.
#ifndef DUET_SCENE_H
#define DUET_SCENE_H

#include "duet_level.h"
#include "duet_object.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// Objects with the world they live in, as read from a file.
typedef struct duet_scene duet_scene;

typedef struct duet_scene_info {
    const char *name; // the file's or the scene's own name; the scene's
    uint32_t dims;    // 2 or 3
    duet_shape shape;
    uint32_t n;
    bool rotated;    // some object has a rotation other than the identity
    float cell;      // cell edge that the scene asks for; 0: chosen from the objects
    bool cell_fixed; // refuses rather than widens a cell that is too small
    bool has_world;  // lower and upper are given
    float lower[3];
    float upper[3];
    duet_level level;  // level that the scene asks for; certified by default
    bool has_accuracy; // leaves the level to a profile within accuracy
    duet_accuracy accuracy;
    float origin_edge; // above 0: objects are large poses, in origin cells of that edge
} duet_scene_info;

// A parameter of a Lua scene, set from outside: "n" = "1000".
typedef struct duet_setting {
    const char *name;
    const char *value; // a number, true, false, or else a string
} duet_setting;

// Reads .lua, .npy, or numbers as text (.csv, .txt, any other ending), and "-", stdin; the
// number of columns says what a row is (docs/formats.md). A word without '/' and '.' is
// first the name of a scene that comes with Duet, such as "paper". Values that are not
// finite, negative extents and radii, and zero quaternions are refused with their place. A
// file whose objects have radii has the shape ROUNDED_BOXES, or SPHERES if all are spheres.
DUET_API duet_scene *duet_scene_load(const char *path, const duet_setting *settings,
                                     uint32_t n_settings, duet_error *err);
// Reads pairs for duet_pair_query_run, .npy or text: two poses a row, 20 numbers or in
// 2D 10. Objects 2 i and 2 i + 1 are row i's.
DUET_API duet_scene *duet_scene_load_pairs(const char *path, duet_error *err);
// Copies n objects: POSES, BOUNDS, LARGE_POSES, ROUNDED_BOXES or SPHERES. dims is 2 or 3.
// origin_edge is the edge of the origin cells of LARGE_POSES, a power of two, else 0.
DUET_API duet_scene *duet_scene_create(duet_object_kind kind, const void *objects, uint32_t n,
                                       uint32_t dims, float origin_edge, duet_error *err);
DUET_API void duet_scene_destroy(duet_scene *scene);
DUET_API const duet_scene_info *duet_scene_get_info(const duet_scene *scene);
// Returns objects [n] of the kind, the scene's; NULL if it has none of the kind. A scene of
// LARGE_POSES has them as POSES too, rounded.
DUET_API const void *duet_scene_get_objects(const duet_scene *scene, duet_object_kind kind);

// Finds all pairs of a scene in plain C, operation for operation as a level of accuracy does;
// certified is exact. The pairs are ascending. The caller frees *pairs with duet_free.
DUET_API bool duet_reference(const duet_scene *scene, duet_level level, duet_pair **pairs,
                             uint64_t *n, duet_error *err);

DUET_C_END

#endif

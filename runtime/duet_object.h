// SPDX-License-Identifier: MIT
// Objects: boxes, however they are given, and the pairs of boxes that collide.
#ifndef DUET_OBJECT_H
#define DUET_OBJECT_H

#include "duet_error.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// An oriented box. The rotation is M(q)/|q|^2, so any quaternion but zero is
// legal. In 2D centre[2], half[2], rotation[0] and rotation[1] are not read.
typedef struct duet_pose {
    float centre[3];
    float half_extents[3]; // >= 0
    float rotation[4];     // quaternion x y z w
} duet_pose;

// A box's position and rotation without its size: what changes from step to step.
typedef struct duet_transform {
    float centre[3];
    float rotation[4]; // quaternion, like a pose's
} duet_transform;

// A transform in 20 bytes. The rotation's parts are whole numbers; their common factor does
// not count, so that the box is exactly that of a pose with the same numbers as floats.
typedef struct duet_compact_transform {
    float centre[3];
    int16_t rotation[4]; // x y z w; in 2D the first two are not read
} duet_compact_transform;

// Sets the nearest compact transform: it turns a box by at most 5.3e-5 rad from the given one.
// In 2D the rotation's first two parts must be 0. BAD_OBJECT if the rotation is zero or not
// finite.
DUET_API bool duet_compact_transform_set(duet_compact_transform *compact,
                                         const duet_transform *transform, duet_error *err);

typedef struct duet_size {
    float half_extents[3]; // >= 0
} duet_size;

// An oriented box however far from 0: along each axis its centre is at
// cell * edge + pose.centre, the edge being a power of two that the scene or the
// world states (origin_edge). Offsets are kept to 2^-24 of an edge, so that precision
// is the same everywhere up to 2^30 edges from 0.
typedef struct duet_large_pose {
    duet_pose pose;
    int32_t cell[3];
    int32_t unused;
} duet_large_pose;

// Sets cell and pose.centre to the position nearest to a centre. BAD_ARGUMENT
// if edge is not a power of two, BAD_OBJECT beyond 2^30 edges.
DUET_API bool duet_large_pose_set(duet_large_pose *pose, const double centre[3], float edge,
                                  duet_error *err);

// An axis-aligned box. In 2D lower[2] and upper[2] are not read.
typedef struct duet_bounds {
    float lower[3];
    float upper[3]; // >= lower
} duet_bounds;

// A rounded box: all points at most `radius` from the pose's box, its core. It is a sphere if all
// half extents are 0, and a capsule if all but one are.
typedef struct duet_rounded_box {
    duet_pose pose;
    float radius; // >= 0
} duet_rounded_box;

// A sphere, in 2D a disc; centre[2] is then not read.
typedef struct duet_sphere {
    float centre[3];
    float radius; // >= 0
} duet_sphere;

// A confirmed collision, a < b.
typedef struct duet_pair {
    uint32_t a;
    uint32_t b;
} duet_pair;

// Sums a hash over n pairs, on which every variant, device and share must agree: see
// duet_result_get_hash. Independent of the pairs' order.
DUET_API uint64_t duet_pairs_hash(const duet_pair *pairs, uint64_t n);

// The kind of the rows of an array of objects.
typedef enum duet_object_kind {
    DUET_OBJECT_POSES,              // duet_pose
    DUET_OBJECT_BOUNDS,             // duet_bounds
    DUET_OBJECT_LARGE_POSES,        // duet_large_pose
    DUET_OBJECT_TRANSFORMS,         // duet_transform, with sizes
    DUET_OBJECT_SIZES,              // duet_size
    DUET_OBJECT_COMPACT_TRANSFORMS, // duet_compact_transform, with sizes
    DUET_OBJECT_ROUNDED_BOXES,      // duet_rounded_box
    DUET_OBJECT_SPHERES             // duet_sphere
} duet_object_kind;

// The most objects of a scene, of a world and of a cluster's rank: 2^32 - 3.
#define DUET_MOST_OBJECTS 4294967293u

typedef enum duet_shape {
    DUET_SHAPE_POSES,         // oriented boxes
    DUET_SHAPE_BOUNDS,        // axis-aligned boxes, given by their corners
    DUET_SHAPE_ROUNDED_BOXES, // oriented boxes with a radius, so capsules and spheres too
    DUET_SHAPE_SPHERES        // spheres alone
} duet_shape;

#define DUET_SHAPES 4

// Says whether the exact boxes share a point; false if one is invalid, or dims is
// neither 2 nor 3.
DUET_API bool duet_poses_collide(const duet_pose *a, const duet_pose *b, uint32_t dims);

// Says the same of rounded boxes.
DUET_API bool duet_rounded_boxes_collide(const duet_rounded_box *a, const duet_rounded_box *b,
                                         uint32_t dims);

// Computes in double how far two boxes are separated along the best of the 15 (4) axes, each of
// length one; below 0 it is their penetration. NaN if a box is invalid.
DUET_API double duet_poses_separation(const duet_pose *a, const duet_pose *b, uint32_t dims);

// Computes in double how far two rounded boxes are separated: the distance of their cores, or if
// the cores collide their separation, less both radii.
DUET_API double duet_rounded_boxes_separation(const duet_rounded_box *a, const duet_rounded_box *b,
                                              uint32_t dims);

// The same two for large poses, in origin cells of that edge.
DUET_API bool duet_large_poses_collide(const duet_large_pose *a, const duet_large_pose *b,
                                       float edge, uint32_t dims);
DUET_API double duet_large_poses_separation(const duet_large_pose *a, const duet_large_pose *b,
                                            float edge, uint32_t dims);

DUET_C_END

#endif

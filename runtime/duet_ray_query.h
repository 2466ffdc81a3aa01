// SPDX-License-Identifier: MIT
// Ray queries: the nearest box of a tree that a ray meets, whether it meets any, or all of them.
#ifndef DUET_RAY_QUERY_H
#define DUET_RAY_QUERY_H

#include "duet_tree.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// The points origin + t direction for t from 0 to t_max, both included. The direction may
// have any length, and 0: the ray is then its origin. In 2D z is not read.
typedef struct duet_ray {
    float origin[3];
    float direction[3];
    float t_max; // INFINITY: without end
} duet_ray;

// A ray far from 0: it begins at cell * edge + ray.origin, as a duet_large_pose.
typedef struct duet_large_ray {
    duet_ray ray;
    int32_t cell[3];
} duet_large_ray;

// docs/accuracy.md, "Rays", bounds the error of t.
typedef struct duet_ray_hit {
    uint32_t ray;
    uint32_t id; // id of the box; DUET_NO_OBJECT: the ray meets none
    float t;     // enters the box there; 0 if it begins inside
} duet_ray_hit;

typedef struct duet_ray_query duet_ray_query;

typedef struct duet_ray_query_def {
    duet_tree *tree; // held until the query is destroyed
    duet_query_wants wants;
    bool normals;              // results have normals; not with ANY
    const duet_filter *filter; // filter of the rays; copied. NULL: finds every object
    int cookie;
} duet_ray_query_def;

DUET_API duet_ray_query_def duet_default_ray_query_def(void); // closest, no normals

// The outward normal of the box at the hit, of length 1: that of the face by which the ray enters,
// on an edge or a corner that of one of the faces there, of a rounded box that of its surface. 0 if
// the ray begins in the box, its surface included, or meets none. docs/accuracy.md, "Rays", bounds
// its error.
typedef struct duet_ray_normal {
    float normal[3];
} duet_ray_normal;

typedef struct duet_ray_query_result {
    const duet_ray_hit
        *hits; // [n_hits] the query's, until its next call; EVERY: all, else one a ray
    const duet_ray_normal *normals; // [n_hits] of each hit, likewise; NULL unless the def asks
    uint64_t n_hits;
    uint64_t undecided;  // hits that float left open and the host decided
    double total_ms;     // wall clock
    double device_ms[2]; // time of each device's part
} duet_ray_query_result;

// Creates a query and builds its kernels.
DUET_API duet_ray_query *duet_ray_query_create(const duet_ray_query_def *def, duet_error *err);
DUET_API void duet_ray_query_destroy(duet_ray_query *query);

// Casts n rays, fewer than 2^32. Which boxes they meet is exact, touching included, and the
// same on every device and at every share. BAD_OBJECT names the first invalid ray: a NaN, an
// origin above 2^100, a direction above 2^100 or, unless 0, below 2^-100, or a t_max below 0.
DUET_API bool duet_ray_query_run(duet_ray_query *query, const duet_ray *rays, uint64_t n,
                                 duet_ray_query_result *result, duet_error *err);

// The same for a tree in origin cells. Origins are rounded to 2^-24 of a cell's edge.
DUET_API bool duet_ray_query_run_large(duet_ray_query *query, const duet_large_ray *rays,
                                       uint64_t n, duet_ray_query_result *result, duet_error *err);

DUET_C_END

#endif

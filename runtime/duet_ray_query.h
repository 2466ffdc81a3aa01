// SPDX-License-Identifier: MIT
// Which boxes of a tree rays meet: the nearest, whether there is any, or every one.
#ifndef DUET_RAY_QUERY_H
#define DUET_RAY_QUERY_H

#include "duet_tree.h"

#include <stdbool.h>
#include <stdint.h>

DUET_C_BEGIN

// The points origin + t direction for t from 0 to t_max, both included. The direction may
// have any length, and 0: the ray is then its origin. In 2D z counts for nothing.
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

// t: where the ray enters the box, 0 if it begins inside. Of the error of t
// docs/accuracy.md, "Rays".
typedef struct duet_ray_hit {
    uint32_t ray;
    uint32_t id; // of the box; DUET_NO_OBJECT: the ray meets none
    float t;
} duet_ray_hit;

typedef struct duet_ray_query duet_ray_query;

typedef struct duet_ray_query_def {
    duet_tree *tree; // held until the query is destroyed
    duet_query_wants wants;
    bool normals;              // results have them; not with ANY
    const duet_filter *filter; // of its rays; copied. NULL: every object is found
    int cookie;
} duet_ray_query_def;

DUET_API duet_ray_query_def duet_default_ray_query_def(void); // closest, no normals

// Of length 1 and out of the box that the hit is on: that of the face that the ray enters by, on
// an edge or a corner of one of the faces there, of a rounded box that of its surface. 0 if the
// ray begins in the box, its surface included, and if it meets none. Of its error
// docs/accuracy.md, "Rays".
typedef struct duet_ray_normal {
    float normal[3];
} duet_ray_normal;

typedef struct duet_ray_query_result {
    const duet_ray_hit *hits; // [n_hits] the query's, until its next call: one a ray, or every
    const duet_ray_normal *normals; // [n_hits] likewise, of each hit; NULL unless the def asks
    uint64_t n_hits;
    uint64_t undecided;  // hits that float left open and the host decided
    double total_ms;     // wall clock
    double device_ms[2]; // of each device's part
} duet_ray_query_result;

// Builds the kernels that it needs.
DUET_API duet_ray_query *duet_ray_query_create(const duet_ray_query_def *def, duet_error *err);
DUET_API void duet_ray_query_destroy(duet_ray_query *query);

// Casts n rays, fewer than 2^32. Which boxes they meet is exact, touching included, and the
// same on every device and at every share. BAD_OBJECT names the first ray that is not valid: a
// number that is none, an origin above 2^100, a direction above 2^100 or, unless 0, below
// 2^-100, or a t_max below 0.
DUET_API bool duet_ray_query_run(duet_ray_query *query, const duet_ray *rays, uint64_t n,
                                 duet_ray_query_result *result, duet_error *err);

// The same for a tree in origin cells. A ray begins at the nearest 2^-24 of a cell's edge.
DUET_API bool duet_ray_query_run_large(duet_ray_query *query, const duet_large_ray *rays,
                                       uint64_t n, duet_ray_query_result *result, duet_error *err);

DUET_C_END

#endif

// SPDX-License-Identifier: MIT
// Sweep queries (shape casts): which boxes of a tree a box meets that moves along a straight line.
#ifndef DUET_SWEEP_QUERY_H
#define DUET_SWEEP_QUERY_H

#include "duet_tree.h"

DUET_C_BEGIN

// The box at centre + t direction for t from 0 to t_max, both included; it does not turn. The
// direction may have any length, and 0: the box then stays. In 2D z is not read.
typedef struct duet_sweep {
    duet_pose box;
    float direction[3];
    float t_max; // INFINITY: without end
} duet_sweep;

// A sweep far from 0: its box begins at cell * edge + box.centre, as a duet_large_pose.
typedef struct duet_large_sweep {
    duet_pose box;
    int32_t cell[3];
    float direction[3];
    float t_max;
    int32_t unused;
} duet_large_sweep;

typedef struct duet_bounds_sweep {
    duet_bounds bounds;
    float direction[3];
    float t_max;
} duet_bounds_sweep;

typedef struct duet_rounded_sweep {
    duet_rounded_box box;
    float direction[3];
    float t_max;
} duet_rounded_sweep;

typedef struct duet_sphere_sweep {
    duet_sphere sphere;
    float direction[3];
    float t_max;
} duet_sphere_sweep;

// docs/accuracy.md, "Swept boxes", bounds the error of t.
typedef struct duet_sweep_hit {
    uint32_t sweep;
    uint32_t id;     // id of the object; DUET_NO_OBJECT: the box meets none
    float t;         // first touches it there; 0 if it does so at the start
    float normal[3]; // unit length, towards the box that moves; 0 if t is 0, and for ANY
} duet_sweep_hit;

typedef struct duet_sweep_query duet_sweep_query;

typedef struct duet_sweep_query_def {
    duet_tree *tree; // held until the query is destroyed
    duet_query_wants wants;
    const duet_filter *filter; // filter of the sweeps; copied. NULL: finds every object
    int cookie;
} duet_sweep_query_def;

DUET_API duet_sweep_query_def duet_default_sweep_query_def(void); // closest

typedef struct duet_sweep_query_result {
    const duet_sweep_hit *hits; // [n_hits] the query's, until its next call; EVERY: all, else one a
                                // sweep
    uint64_t n_hits;
    uint64_t undecided;  // hits that float left open and the host decided
    double total_ms;     // wall clock
    double device_ms[2]; // time of each device's part
} duet_sweep_query_result;

// Creates a query and builds its kernels.
DUET_API duet_sweep_query *duet_sweep_query_create(const duet_sweep_query_def *def,
                                                   duet_error *err);
DUET_API void duet_sweep_query_destroy(duet_sweep_query *query);

// Moves n boxes, fewer than 2^32. kind is the kind of the tree's objects; sweeps holds duet_sweep
// for POSES, duet_bounds_sweep for BOUNDS, duet_rounded_sweep for ROUNDED_BOXES, duet_sphere_sweep
// for SPHERES, duet_large_sweep for LARGE_POSES. Which objects they meet is exact, touching
// included, and the same on every device and at every share. BAD_OBJECT names the first invalid
// sweep: no box, a number above 2^100, a direction below 2^-100 that is not 0, or a t_max below 0.
DUET_API bool duet_sweep_query_run(duet_sweep_query *query, duet_object_kind kind,
                                   const void *sweeps, uint64_t n, duet_sweep_query_result *result,
                                   duet_error *err);

DUET_C_END

#endif

// SPDX-License-Identifier: MIT
// A ground of either shape, as queries keep it.
#ifndef RUNTIME_GROUND_SHAPE_H
#define RUNTIME_GROUND_SHAPE_H

#include "runtime/narrowphase/ground_probe.h"
#include "runtime/narrowphase/mesh_tree.h"

// At most one of both is there.
typedef struct ground_shape {
    duet_heights heights; // heights NULL: there are none
    duet_mesh mesh;       // vertices NULL: there is none
    mesh_node *tree;
} ground_shape;

// Copies a ground that was checked; one of both, or both, are NULL. BAD_ARGUMENT for places that
// doubles do not tell apart well; then, and without memory, there is none to free.
bool ground_shape_copy(ground_shape *ground, const duet_heights *heights, const duet_mesh *mesh,
                       duet_error *err);
void ground_shape_free(ground_shape *ground);
bool ground_shape_is_there(const ground_shape *ground);

// Whether a probe meets the ground, touching included: in double with an error bound, then in
// rational numbers; with a radius in double, within 2^-40 of the sizes. Sets entry if it does.
bool ground_shape_meet(const ground_shape *ground, const ground_probe *probe, ground_entry *entry);

// Whether a point lies in it, and how far it is away, 0 in it.
bool ground_shape_contain(const ground_shape *ground, const float at[3]);
double ground_shape_distance(const ground_shape *ground, const float at[3]);

#endif

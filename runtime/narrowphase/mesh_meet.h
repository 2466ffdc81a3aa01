// SPDX-License-Identifier: MIT
// A ground of triangles as queries see it: the closed set of all points on them, which has two
// sides and nothing within.
//
// Its places are doubles, origin + vertex rounded once. All answers are about these, and made on
// the host: bits are the same on every machine.
#ifndef RUNTIME_MESH_MEET_H
#define RUNTIME_MESH_MEET_H

#include "runtime/narrowphase/ground_probe.h"
#include "runtime/narrowphase/mesh_tree.h"

// Does as heights_meet.
bool mesh_meet(const duet_mesh *mesh, const mesh_node *tree, const ground_probe *probe,
               ground_entry *entry);

// How far a point is from the nearest triangle, on none of which it lies.
double mesh_distance(const duet_mesh *mesh, const mesh_node *tree, const float at[3]);

#endif

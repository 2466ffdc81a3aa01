// SPDX-License-Identifier: MIT
// The objects that a grid is for: rows of an array, whatever their shape.
#ifndef RUNTIME_GRID_OBJECTS_H
#define RUNTIME_GRID_OBJECTS_H

#include "runtime/duet.h"
#include "runtime/opencl/thread_pool.h"

#include <assert.h>
#include <stddef.h>

// An array in host memory.
typedef struct host_array {
    const void *rows; // NULL if the host does not see them
    size_t row_bytes;
    uint32_t n;
    uint64_t generation; // changes with the content and the place
} host_array;

// The objects that a grid is for. A row begins with the point that decides its cell, and with its
// pose if it has one whole.
typedef struct grid_objects {
    duet_object_kind kind; // in a row
    duet_shape shape;
    uint32_t dims;
    float origin; // the edge of origin cells, or 0
    host_array all;
    host_array sizes; // duet_size; its rows are NULL if the objects' rows have their sizes
} grid_objects;

static_assert(offsetof(duet_pose, centre) == 0 && offsetof(duet_bounds, lower) == 0 &&
                  offsetof(duet_transform, centre) == 0 && offsetof(duet_sphere, centre) == 0 &&
                  offsetof(duet_compact_transform, centre) == 0 &&
                  offsetof(duet_large_pose, pose) == 0 && offsetof(duet_rounded_box, pose) == 0,
              "a row begins with its point");

// A pose without its size.
duet_transform grid_transform_of(const duet_pose *pose);

// The pose of an object that has one; *scratch holds it if its size lies apart, or for a
// sphere. A rounded box's pose is its core's.
const duet_pose *grid_pose_of(const grid_objects *objects, uint32_t id, duet_pose *scratch);

// 0 if objects have none.
float grid_radius_of(const grid_objects *objects, uint32_t id);
static inline bool grid_has_radii(const grid_objects *objects)
{
    return objects->shape == DUET_SHAPE_ROUNDED_BOXES || objects->shape == DUET_SHAPE_SPHERES;
}

// An object's centre; z is 0 in 2D.
void grid_centre_of(double centre[3], const grid_objects *objects, uint32_t id);

// Whether two boxes that the host sees collide, exactly.
bool grid_objects_collide(const grid_objects *objects, uint32_t a, uint32_t b);

enum { GRID_OCTAVES = 300 };

// The grid that the objects need. Bad ones are not counted.
typedef struct grid_needs {
    double lower[3]; // the least of the points that decide cells
    double upper[3];
    double widest;      // the largest extent of any object
    uint32_t widest_id; // the object that has it
    // The number of objects and the largest extent, by octave of the extent of the bounds that
    // devices compute, which are wider by their rounding.
    uint32_t octave_n[GRID_OCTAVES];
    double octave_widest[GRID_OCTAVES];
} grid_needs;

// By these threads and the caller's; NULL: by that alone.
void grid_needs_of(grid_needs *needs, const grid_objects *objects, thread_pool *threads);

#endif

// SPDX-License-Identifier: MIT
// Objects and their world while a reader fills them.
//
// Readers (text, npy, Lua) hand over rows of numbers in double. They are checked
// on their way in and nowhere else, so that a bad object is refused in the same
// words from every kind of file.
#ifndef RUNTIME_SCENE_H
#define RUNTIME_SCENE_H

#include "runtime/duet.h"
#include "runtime/scene/scene_row.h"

struct duet_scene {
    duet_scene_info info;
    char *name;           // info.name
    uint32_t columns;     // columns of a row; 0: none was read yet
    uint32_t per_row;     // objects in a row: 1, or 2 in a file of pairs
    void *objects;        // [n] by info.shape, or with an origin duet_large_pose
    duet_pose *rounded;   // with an origin: the poses with their centres rounded to float
    float *radii;         // [n] of poses while they are read, where one has some
    bool mixes;           // rows with and without a radius may stand side by side
    bool keep_centres;    // a reader that does not know yet whether it will be asked for an origin
    double (*centres)[3]; // [n] poses' centres as they were read
    uint64_t capacity;    // objects that fit
    uint64_t n_read;      // objects so far, kept or not
    uint64_t first, end;  // objects that are kept: [first, end)
    bool defers;          // `each` makes only its first object, and
    uint64_t n_deferred;  // these are left out

    duet_motion_def motion; // the scene's settings of motion
    duet_body body;         // body of objects without their own
    bool has_body;
    duet_heights heights; // motion.heights, if there is a ground
    float *height_values;
    duet_mesh mesh;           // motion.mesh, likewise
    struct scene_body *given; // bodies of single objects, as far as given
    uint32_t n_given;
    duet_body *bodies; // [n], or NULL where nothing is said of any
};

// An empty scene, which is 3D poses until rows say otherwise.
duet_scene *scene_new(duet_error *err);

bool scene_set_name(duet_scene *scene, const char *name, size_t length, duet_error *err);

// Decides what a row is, before the first one (docs/formats.md). False with
// BAD_INPUT for a count of numbers that no row has, or for one that differs from
// an earlier call's.
bool scene_set_columns(duet_scene *scene, uint32_t columns, scene_place place, duet_error *err);

// Space for n objects; a row that finds none makes some by itself.
bool scene_reserve(duet_scene *scene, uint64_t n, duet_error *err);

// Whether rows may have so many numbers, and which may, for messages.
bool scene_columns_fit(const duet_scene *scene, uint64_t columns);
const char *scene_columns_right(const duet_scene *scene);

// Adds the next object, or two, unless they are among those that are passed over. False with
// BAD_OBJECT, naming place, object and number.
bool scene_add_row(duet_scene *scene, const double *row, scene_place place, duet_error *err);

// Adds the next object of that layout, unless it is among those that are passed over.
bool scene_add_object(duet_scene *scene, const scene_layout *l, const double *row,
                      scene_place place, duet_error *err);

// Passes over the next objects, at most n, up to one that is kept. Returns how many.
uint64_t scene_pass_over(duet_scene *scene, uint64_t n);

// Moves the objects: the i-th is then the one that was order[i].
bool scene_reorder(duet_scene *scene, const uint32_t *order, duet_error *err);

// Returns the kind of a scene's objects.
duet_object_kind scene_kind(const duet_scene_info *info);

// ---------------------------------------------------------------- scene_radii.c

// Before the first object that has a radius: those before it have none.
bool scene_begin_radii(duet_scene *scene, duet_error *err);
bool scene_reserve_radii(duet_scene *scene, uint64_t n, duet_error *err);

// Makes poses and their radii into objects of that shape.
bool scene_join_radii(duet_scene *scene, duet_shape shape, duet_error *err);

// The same into the shape that costs least, after the last object; poses stay poses where none
// has a radius.
bool scene_settle_radii(duet_scene *scene, duet_error *err);

// An object of a scene whose objects have radii.
duet_rounded_box scene_rounded_box(const duet_scene *scene, uint32_t id);

// ---------------------------------------------------------------- scene_origin.c

// Poses become placed ones in origin cells of that edge: in the cells of the given ones, or where
// that is NULL by the centres that were kept. To be called once, after the last object.
bool scene_set_origin(duet_scene *scene, const duet_large_pose *given, double edge,
                      duet_error *err);
void scene_forget_centres(duet_scene *scene);

#endif

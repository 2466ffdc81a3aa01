// SPDX-License-Identifier: MIT
// A row of numbers: what its columns are, whether they make an object, and how.
#ifndef RUNTIME_SCENE_ROW_H
#define RUNTIME_SCENE_ROW_H

#include "runtime/duet.h"

#define SCENE_MAX_COLUMNS 11 // columns of an object
#define SCENE_MAX_NUMBERS 20 // numbers of a row: two poses in a file of pairs

// The origin of a row, for messages: "path:line: ", "path: " for line 0, nothing for path NULL.
// Objects 2 i and 2 i + 1 of a file of pairs are called the poses of pair i.
typedef struct scene_place {
    const char *path;
    uint64_t line;
    bool in_pairs;
} scene_place;

typedef struct scene_place_text {
    char chars[320];
} scene_place_text;

scene_place_text scene_place_name(scene_place place);

typedef enum column_kind {
    COLUMN_COORDINATE,
    COLUMN_HALF,    // >= 0
    COLUMN_RADIUS,  // >= 0; the last one
    COLUMN_ANGLE,   // radians; not stored, so it may be any finite double
    COLUMN_ROTATION // part of a quaternion; scaled before it is stored
} column_kind;

typedef struct scene_column {
    const char *name;
    column_kind kind;
} scene_column;

// A kind of row, and how one that was checked becomes a pose or bounds.
typedef struct scene_layout {
    uint32_t n;
    uint32_t dims;
    duet_shape shape;
    const scene_column *columns;                    // [n]
    void (*store)(const double *row, void *object); // but for the radius
} scene_layout;

bool scene_layout_has_radius(const scene_layout *l);

// The layout of files with so many columns (docs/formats.md); NULL where no
// file has them.
const scene_layout *scene_layout_find(uint32_t columns);

// cx cy hx hy qz qw: what a duet_pose holds in 2D; in no file.
extern const scene_layout scene_layout_pose_2d;

// And with a radius: 7 numbers, or 11 in 3D.
const scene_layout *scene_layout_rounded_box(uint32_t dims);

// False with BAD_OBJECT, naming place, object and number.
bool scene_row_check(const scene_layout *l, const double *row, uint64_t id, scene_place place,
                     duet_error *err);

#endif

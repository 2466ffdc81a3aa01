// SPDX-License-Identifier: MIT
// Columns of bodies that stand on each other when a motion begins.
#ifndef RUNTIME_COLUMN_H
#define RUNTIME_COLUMN_H

#include "runtime/dynamics/motion.h"

typedef enum column_kind {
    COLUMN_UPRIGHT,
    COLUMN_LEANING, // its weight presses more than a tenth off the middle of what bears it
} column_kind;

// Bodies on each other. The edge is that of cubes as slender: width^2 / height, the least of an
// upright column's bodies; of a leaning one twice the way from where its weight presses to the rim
// of what bears it, squared, by the height of its lowest body.
typedef struct column {
    column_kind kind;
    uint32_t layers; // 0: no body can stand
    double edge;
} column;

// Finds the column that needs the shortest substeps: `need` says how short, and the greatest
// counts.
bool column_find(const duet_motion *m, double (*need)(const duet_motion *m, const column *c),
                 column *found, duet_error *err);

#endif

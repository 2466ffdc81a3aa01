// SPDX-License-Identifier: MIT
// Columns of bodies that stand on each other when a motion begins.
#ifndef RUNTIME_COLUMN_H
#define RUNTIME_COLUMN_H

#include "runtime/dynamics/motion.h"

// The column that needs the shortest substeps.
typedef struct column {
    uint32_t layers; // 0: no body can stand
    double edge;     // least width^2 / height of its bodies: the edge, if they are cubes
} column;

// Finds it among the bodies with a mass. Gravity's greatest component says which way is up; a body
// stands on another if they are a margin apart at most, along the lines through their centres.
// `need` says how short the substeps of a column must be: the greatest counts.
bool column_find(const duet_motion *m, double (*need)(const duet_motion *m, const column *c),
                 column *found, duet_error *err);

#endif

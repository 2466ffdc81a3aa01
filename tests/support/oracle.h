// SPDX-License-Identifier: MIT
// The truth about two boxes by another road than separating axes: a point p is
// sought that meets all twelve inequalities of both boxes, by Fourier-Motzkin
// elimination of its coordinates, in exact integers.
#ifndef TESTS_ORACLE_H
#define TESTS_ORACLE_H

#include "runtime/duet.h"

// Sound boxes only.
bool oracle_collide(const duet_pose *a, const duet_pose *b, uint32_t dims);

// Decides two boxes as rows of ten doubles, none of which is rounded.
bool oracle_rows_collide(const double a[10], const double b[10]);

#endif

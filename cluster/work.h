// SPDX-License-Identifier: MIT
// A step costs as much as so many bodies: an end of a contact that pushes costs a part of a body,
// which is fitted to the times that ranks took.
#ifndef CLUSTER_WORK_H
#define CLUSTER_WORK_H

#include <stdint.h>

// A rank's bodies, ends of their contacts, and the time that they took it, of one step or several.
typedef struct work_row {
    double bodies, ends, busy_ns;
} work_row;

typedef struct work_model {
    double end;                // what an end costs, of a body
    double nn, ne, ee, nt, et; // sums of the fit: of products of bodies, ends and times
} work_model;

work_model work_begin(void);

// Fits to the rows of n ranks as well; what was noted before counts a little less from then on.
void work_note(work_model *w, const work_row *rows, uint32_t n);

static inline double work_of(const work_model *w, double bodies, double ends)
{
    return bodies + w->end * ends;
}

#endif

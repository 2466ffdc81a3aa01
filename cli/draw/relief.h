// SPDX-License-Identifier: MIT
// A ground of heights in a picture: its cells, from far to near, so that hills hide what is behind
// them. A large ground is drawn by every second, third ... height.
#ifndef CLI_RELIEF_H
#define CLI_RELIEF_H

#include "cli/draw/view.h"

#include <stddef.h>
#include <stdint.h>

typedef struct relief_cell {
    uint32_t i, j;   // its lowest place
    double nearness; // of the corner that is farthest from the eye, as if the ground were level
} relief_cell;

typedef struct relief {
    const duet_heights *heights; // borrowed
    const view *view;            // likewise
    uint32_t step;               // places from one drawn to the next
    relief_cell *cells;          // [n] from far to near; NULL: there is no ground
    size_t n, n_drawn;
} relief;

// Grows a part of space by what of the ground lies beneath and about it.
void relief_widen(const duet_heights *heights, extent *part);

// heights NULL: draws nothing. Call relief_end whatever this returns.
bool relief_begin(relief *r, const duet_heights *heights, const view *v, duet_error *err);
// Draws the cells that lie farther than a nearness, of those that are left.
void relief_draw(relief *r, canvas *c, double nearness);
void relief_end(relief *r);

// How near the nearest part of a box is, as if all lay on level ground.
double relief_nearness(const view *v, const corners *box);

#endif

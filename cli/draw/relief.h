// SPDX-License-Identifier: MIT
// A ground in a picture: its triangles, from far to near, so that hills hide what is behind them.
// Heights, if there are many, are drawn by every second, third ... one.
#ifndef CLI_RELIEF_H
#define CLI_RELIEF_H

#include "cli/draw/view.h"

#include <stddef.h>
#include <stdint.h>

typedef struct relief_triangle {
    double at[3][3]; // counterclockwise, seen from outside
    double nearness; // that the corner farthest from the eye has
    size_t order;    // among those as near
} relief_triangle;

typedef struct relief {
    const view *view;           // borrowed
    bool is_level;              // nearness is that of a place on level ground below or above
    relief_triangle *triangles; // [n] from far to near; NULL: there is no ground
    size_t n, n_drawn;
} relief;

// Grows a part of space by what of a motion's ground lies about it.
void relief_widen(const duet_motion_def *def, extent *part);

// A def without a ground draws nothing. Call relief_end whatever this returns.
bool relief_begin(relief *r, const duet_motion_def *def, const view *v, duet_error *err);
// Draws the triangles that lie farther than a nearness, of those that are left.
void relief_draw(relief *r, canvas *c, double nearness);
void relief_end(relief *r);

// How near the nearest part of a box is, as that of triangles is measured.
double relief_nearness(const relief *r, const corners *box);

#endif

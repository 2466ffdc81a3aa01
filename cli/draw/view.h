// SPDX-License-Identifier: MIT
// Where points of a scene lie on a canvas, without perspective: 2D from above with y
// upwards, 3D from where a look says.
#ifndef CLI_VIEW_H
#define CLI_VIEW_H

#include "cli/draw/canvas.h"
#include "runtime/duet.h"

// A part of space; in 2D lower[2] and upper[2] are 0.
typedef struct extent {
    double lower[3];
    double upper[3];
} extent;

extent extent_empty(void);
void extent_add(extent *e, const double p[3]);

// From where a scene in 3D is seen, and from where light comes.
typedef struct look {
    double right[3]; // right and up: of one length, at right angles
    double up[3];
    double near[3]; // towards the eye
    double light[3];
    double dark;   // brightness of a face that no light falls on
    double bright; // added to it by light
} look;

extern const look oblique; // from above, with x nearer than y

typedef struct view {
    const look *look;
    uint32_t dims;
    extent shown;
    double scale; // pixels a unit of length
    point at;     // the place of the scene's origin
} view;

// Shows the extent as large as fits between the points.
view view_fit(const look *from, uint32_t dims, const extent *shown, point least, point most);
point view_point(const view *v, const double p[3]);

// How near a point is to the eye; in 2D no box hides another.
double view_nearness(const view *v, const double p[3]);

// Corner i of a box is at its upper side on axis k where bit k of i is set; 2D
// boxes have the first four. The columns of turn are the box's axes.
typedef struct corners {
    double at[8][3];
    double turn[3][3];
    double radius; // the radius of a rounded box; the corners are its core's
} corners;

corners corners_of(const duet_pose *box, uint32_t dims);

typedef struct box_ink {
    colour fill;
    colour edge; // alpha 0: none
} box_ink;

// Its outline filled, or in 3D the faces that are seen, shaded by direction; round edges are all
// of one shade.
void view_box(const view *v, canvas *c, const corners *box, const box_ink *ink);

// A bar of 1, 2 or 5 times a power of ten units, its left end at the point, with its
// length in words behind it. In 3D it measures what faces the eye.
void view_scale_bar(const view *v, canvas *c, point at, double words_px, colour ink);

// The edges alone.
void view_frame(const view *v, canvas *c, const extent *e, colour ink);

#endif

// SPDX-License-Identifier: MIT
// A drawing of lines, shapes and words that becomes an SVG or PNG file, as the
// file's ending says. Sizes are in pixels, y goes down.
#ifndef CLI_CANVAS_H
#define CLI_CANVAS_H

#include "duet_error.h"

#include <stdbool.h>

typedef struct canvas canvas;

typedef struct point {
    double x;
    double y;
} point;

typedef struct colour {
    double red; // 0..1, as the rest
    double green;
    double blue;
    double alpha; // 1: opaque
} colour;

// Colours of words and frames.
extern const colour canvas_ink;
extern const colour canvas_grey;

// White. BAD_ARGUMENT for an ending other than .svg and .png.
canvas *canvas_open(const char *path, double width, double height, duet_error *err);

void canvas_line(canvas *c, point from, point to, colour ink, double width);
// An edge of alpha 0 is not drawn.
void canvas_polygon(canvas *c, const point *corners, int n, colour fill, colour edge);
void canvas_dot(canvas *c, point at, double radius, colour fill);

// Left end of the words' base line at the point. Returns where they end.
double canvas_words(canvas *c, point at, double size, colour ink, const char *words);

// Closes the canvas, after writing its file if it is to be kept; whether it was.
bool canvas_close(canvas *c, bool keep, duet_error *err); // NULL allowed

#endif

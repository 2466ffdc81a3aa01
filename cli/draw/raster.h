// SPDX-License-Identifier: MIT
// A picture of triangles in space that becomes a PNG file: where they hide each
// other the nearest is seen. Sizes are in pixels, y goes down.
#ifndef CLI_RASTER_H
#define CLI_RASTER_H

#include "duet_error.h"

#include <stdbool.h>

typedef struct raster raster;

typedef struct spot {
    double x, y;
    double nearness; // any unit
} spot;

typedef struct tint {
    double red, green, blue; // 0..1
} tint;

// BAD_ARGUMENT for an ending other than .png.
raster *raster_open(const char *path, int width, int height, tint paper, duet_error *err);
void raster_triangle(raster *r, const spot corners[3], tint fill);

// Closes it, after writing its file if it is to be kept; whether it was.
bool raster_close(raster *r, bool keep, duet_error *err); // NULL allowed

#endif

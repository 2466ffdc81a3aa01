// SPDX-License-Identifier: MIT
// How far a point is from a triangle.
#include "runtime/narrowphase/ground_piece.h"
#include "runtime/narrowphase/vector.h"

#include <math.h>

static void less(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; ++k)
        out[k] = a[k] - b[k];
}

static double square_to_edge(const double a[3], const double b[3], const double at[3])
{
    double along[3], way[3];
    less(along, b, a);
    less(way, at, a);
    double t = fmin(fmax(dot(way, along) / dot(along, along), 0.0), 1.0);
    for (int k = 0; k < 3; ++k)
        way[k] -= t * along[k];
    return dot(way, way);
}

// Over the inside of a triangle the plane is nearest, else an edge.
double ground_piece_square(const ground_piece *p, const double at[3])
{
    double e[2][3], normal[3], way[3], square = INFINITY;
    bool inside = true;
    less(e[0], p->corner[1], p->corner[0]);
    less(e[1], p->corner[2], p->corner[0]);
    cross(normal, e[0], e[1]);
    for (int k = 0; k < 3; ++k) {
        double along[3], out[3];
        less(along, p->corner[(k + 1) % 3], p->corner[k]);
        less(way, at, p->corner[k]);
        cross(out, normal, along);
        inside = inside && dot(out, way) >= 0.0;
        square = fmin(square, square_to_edge(p->corner[k], p->corner[(k + 1) % 3], at));
    }
    double high = dot(normal, way);
    return inside ? high * high / dot(normal, normal) : square;
}

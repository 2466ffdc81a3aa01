// SPDX-License-Identifier: MIT
// Faces are filled line by line, the nearest one kept (a depth buffer), seen
// from above and aside without perspective; in 2D from straight above.
#include "tuner/cli/snapshot.h"

#include "runtime/base/error.h"

#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 960, HEIGHT = 720, ROW = 3 * WIDTH };

typedef struct spot {
    double x, y, z; // pixels, and nearness
} spot;

typedef struct frame {
    unsigned char *pixels; // [HEIGHT][WIDTH][3]
    float *nearest;        // [HEIGHT][WIDTH]
    double right[3], up[3], near[3];
    double scale;
    double middle[3];
} frame;

// ---------------------------------------------------------------- the view

static void grow(snapshot_view *v, const double at[3], double reach)
{
    for (int k = 0; k < 3; ++k) {
        v->lower[k] = fmin(v->lower[k], at[k] - reach);
        v->upper[k] = fmax(v->upper[k], at[k] + reach);
    }
}

snapshot_view snapshot_view_of(const duet_motion_def *def, const duet_pose *poses,
                               const duet_state *states, uint32_t n)
{
    snapshot_view v = {.dims = def->dims,
                       .lower = {INFINITY, INFINITY, INFINITY},
                       .upper = {-INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t i = 0; i < n; ++i) {
        const float *h = poses[i].half;
        grow(&v, states[i].centre, fmax(h[0], fmax(h[1], def->dims == 3 ? h[2] : 0.0)));
    }
    if (def->edge != DUET_EDGE_NONE) {
        grow(&v, def->lower, 0.0);
        double top[3] = {def->upper[0], def->upper[1], n > 0 ? v.upper[2] : def->upper[2]};
        grow(&v, top, 0.0);
    }
    return v;
}

static void normalise(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; ++k)
        v[k] /= length;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void aim(frame *c, const snapshot_view *v)
{
    static const double views[2][3][3] = {
        {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
        {{0.8, 0.6, 0}, {-0.27, 0.36, 0.9}, {0.54, -0.72, 0.45}},
    };
    const double(*view)[3] = views[v->dims == 3];
    memcpy(c->right, view[0], sizeof c->right);
    memcpy(c->up, view[1], sizeof c->up);
    memcpy(c->near, view[2], sizeof c->near);
    normalise(c->right);
    normalise(c->up);
    normalise(c->near);
    double wide = 1e-9, high = 1e-9;
    for (uint32_t k = 0; k < v->dims; ++k) {
        double length = v->upper[k] - v->lower[k];
        c->middle[k] = 0.5 * (v->upper[k] + v->lower[k]);
        wide += fabs(c->right[k]) * length;
        high += fabs(c->up[k]) * length;
    }
    c->scale = 0.95 * fmin(WIDTH / wide, HEIGHT / high);
}

static spot project(const frame *c, const double at[3])
{
    double d[3] = {at[0] - c->middle[0], at[1] - c->middle[1], at[2] - c->middle[2]};
    return (spot){0.5 * WIDTH + c->scale * dot(d, c->right),
                  0.5 * HEIGHT - c->scale * dot(d, c->up), dot(d, c->near)};
}

// ---------------------------------------------------------------- filling

static double edge(spot a, spot b, double x, double y)
{
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

static void fill_triangle(frame *c, spot a, spot b, spot d, const double colour[3])
{
    double area = edge(a, b, d.x, d.y);
    if (fabs(area) < 1e-12)
        return;
    int x0 = (int)fmax(0, floor(fmin(a.x, fmin(b.x, d.x))));
    int x1 = (int)fmin(WIDTH - 1, ceil(fmax(a.x, fmax(b.x, d.x))));
    int y0 = (int)fmax(0, floor(fmin(a.y, fmin(b.y, d.y))));
    int y1 = (int)fmin(HEIGHT - 1, ceil(fmax(a.y, fmax(b.y, d.y))));
    for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
            double u = edge(b, d, x, y) / area, v = edge(d, a, x, y) / area;
            double w = 1.0 - u - v;
            float z = (float)(u * a.z + v * b.z + w * d.z);
            size_t at = (size_t)y * WIDTH + (size_t)x;
            if (u < 0 || v < 0 || w < 0 || z <= c->nearest[at])
                continue;
            c->nearest[at] = z;
            for (int k = 0; k < 3; ++k)
                c->pixels[3 * at + (size_t)k] = (unsigned char)(255.0 * fmin(1.0, colour[k]));
        }
    }
}

static void axes_of(const double q[4], double axis[3][3])
{
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rows[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
        {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
        {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)},
    };
    memcpy(axis, rows, sizeof rows);
}

// Colours far apart for neighbours, by the golden angle.
static void colour_of(uint32_t id, bool heavy, double colour[3])
{
    double hue = 6.283185307 * fmod(id * 0.618033988749895, 1.0);
    for (int k = 0; k < 3; ++k)
        colour[k] = heavy ? 0.62 + 0.33 * cos(hue - 2.0943951 * k) : 0.55;
}

// One of the faces across axis k, where it is turned to the eye.
static void fill_face(frame *c, const double centre[3], double axis[3][3], const float half[3],
                      int k, double side, const double colour[3])
{
    int u = (k + 1) % 3, v = (k + 2) % 3;
    double facing = side * dot(axis[k], c->near);
    if (facing <= 0)
        return;
    static const double light[3] = {0.35, -0.45, 0.82};
    double bright = 0.45 + 0.55 * fmax(0.0, side * dot(axis[k], light));
    double shade[3] = {bright * colour[0], bright * colour[1], bright * colour[2]};
    spot corners[4];
    for (int i = 0; i < 4; ++i) {
        double su = i == 0 || i == 3 ? 1 : -1, sv = i < 2 ? 1 : -1;
        double at[3];
        for (int j = 0; j < 3; ++j)
            at[j] = centre[j] + side * half[k] * axis[k][j] + su * half[u] * axis[u][j] +
                    sv * half[v] * axis[v][j];
        corners[i] = project(c, at);
    }
    fill_triangle(c, corners[0], corners[1], corners[2], shade);
    fill_triangle(c, corners[0], corners[2], corners[3], shade);
}

static void fill_box(frame *c, const duet_pose *pose, const duet_state *state, uint32_t dims,
                     const double colour[3])
{
    double axis[3][3];
    double centre[3] = {state->centre[0], state->centre[1], dims == 3 ? state->centre[2] : 0.0};
    float half[3] = {pose->half[0], pose->half[1], dims == 3 ? pose->half[2] : 0.0f};
    axes_of(state->rotation, axis);
    for (int k = dims == 3 ? 0 : 2; k < 3; ++k) {
        fill_face(c, centre, axis, half, k, 1.0, colour);
        fill_face(c, centre, axis, half, k, -1.0, colour);
    }
}

// ---------------------------------------------------------------- the file

static bool write_png(const char *path, const unsigned char *pixels, duet_error *err)
{
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT, .format = PNG_FORMAT_RGB};
    bool ok = png_image_write_to_file(&image, path, 0, pixels, ROW, NULL);
    return ok || error_set(err, DUET_IO_FAILED, "%s: %s", path, image.message);
}

bool snapshot_write(const char *path, const snapshot_view *view, const duet_pose *poses,
                    const duet_body *bodies, const duet_state *states, uint32_t n, duet_error *err)
{
    frame c = {.pixels = malloc((size_t)HEIGHT * ROW),
               .nearest = malloc((size_t)HEIGHT * WIDTH * sizeof(float))};
    bool ok = c.pixels && c.nearest;
    if (!ok)
        error_set(err, DUET_NO_MEMORY, "%s: no memory for a picture", path);
    if (ok) {
        memset(c.pixels, 0xf7, (size_t)HEIGHT * ROW);
        for (size_t i = 0; i < (size_t)HEIGHT * WIDTH; ++i)
            c.nearest[i] = -INFINITY;
        aim(&c, view);
        for (uint32_t i = 0; i < n; ++i) {
            double colour[3];
            colour_of(i, !bodies || bodies[i].mass > 0.0f, colour);
            fill_box(&c, &poses[i], &states[i], view->dims, colour);
        }
        ok = write_png(path, c.pixels, err);
    }
    free(c.pixels);
    free(c.nearest);
    return ok;
}
